// `vergence`: the one place where errors become messages and exit statuses: 0 done, 1 failed, 2 usage or bad
// input.
#include <cstdio>
#include <exception>

#include "tools/cli/commands.hpp"
#include "tools/io/input_error.hpp"

namespace {

constexpr int kFailed = 1;
constexpr int kBadInput = 2;

int fail(int status, const char* message) {
  std::fprintf(stderr, "vergence: error: %s\n", message);
  return status;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"vergence: 6-DoF poses from a stereo pair, by a photo-model or a ball marker"};
  app.name("vergence");
  app.set_version_flag("--version", VERGENCE_VERSION);
  app.require_subcommand(1);
  app.get_formatter()->column_width(34);
  vergence::tools::add_estimate_command(app);
  vergence::tools::add_fitness_map_command(app);
  vergence::tools::add_model_command(app);
  vergence::tools::add_calibrate_command(app);
  vergence::tools::add_render_command(app);
  vergence::tools::add_bench_command(app);
  vergence::tools::add_accuracy_command(app);
  vergence::tools::add_demo_command(app);
  vergence::tools::add_replay_command(app);
  vergence::tools::add_config_command(app);
  vergence::tools::add_bringup_command(app);
  vergence::tools::add_controller_commands(app);
  // After the commands, which would inherit it.
  app.footer(
      "`vergence COMMAND --help` tells more of each.\n"
      "Exit status: 0 done, 1 failed, 2 usage or bad input.");

  try {
    app.parse(argc, argv);
    return 0;
  } catch (const CLI::Success& help_or_version) {
    return app.exit(help_or_version);
  } catch (const CLI::ParseError& error) {
    fail(kBadInput, error.what());
    std::fprintf(stderr, "`vergence COMMAND --help` tells what is expected.\n");
    return kBadInput;
  } catch (const vergence::tools::InputError& error) {
    return fail(kBadInput, error.what());
  } catch (const std::exception& error) {
    return fail(kFailed, error.what());
  }
}
