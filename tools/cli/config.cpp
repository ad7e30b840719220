// `vergence config`: the controller's configuration, checked, built into an image, and shown.
#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "tools/cli/commands.hpp"
#include "tools/config/config_file.hpp"
#include "tools/config/read_config.hpp"
#include "tools/config/show_config.hpp"
#include "tools/io/input_error.hpp"

namespace vergence::tools {
namespace {

// Beside its place first, so that a running controller never finds half of one.
void write_file(const std::filesystem::path& file, const std::vector<std::byte>& bytes) {
  const std::filesystem::path beside = file.string() + ".new";
  std::ofstream out(beside, std::ios::binary);
  out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  out.close();
  if (!out) throw InputError(beside, "", "cannot be written", "is there such a folder, and room?");
  std::filesystem::rename(beside, file);
}

void check(const std::filesystem::path& file) {
  const auto config = read_any_config(file);
  const std::vector<std::byte> image = image_of(file, *config);
  std::printf("%s: good; an image of it has %zu bytes\n", file.c_str(), image.size());
  for (const std::string& load : bus_loads(*config)) std::printf("%s\n", load.c_str());
}

void build(const std::filesystem::path& file, const std::filesystem::path& out) {
  const std::vector<std::byte> image = image_of(file, *read_config(file));
  write_file(out, image);
  std::printf("written %s, %zu bytes\n", out.c_str(), image.size());
}

}  // namespace

void add_config_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("config", "Check, build and show the controller's configuration");
  command->require_subcommand(1);
  const auto file = std::make_shared<std::filesystem::path>();
  const auto out = std::make_shared<std::filesystem::path>();

  CLI::App* checking = command->add_subcommand("check", "Say what is wrong with a configuration");
  checking->add_option("FILE", *file, "TOML, or an image")->required();
  checking->callback([file] { check(*file); });

  CLI::App* building = command->add_subcommand("build", "Make the image that vergenced reads");
  building->add_option("FILE", *file, "TOML")->required();
  building->add_option("-o,--out", *out, "The image, robot.vcfg")->required()->type_name("FILE");
  building->callback([file, out] { build(*file, *out); });

  CLI::App* showing = command->add_subcommand("show", "Print every setting of a configuration, as TOML");
  showing->add_option("FILE", *file, "TOML, or an image")->required();
  showing->callback([file] { std::fputs(show_config(*read_any_config(*file)).c_str(), stdout); });

  CLI::App* settings = command->add_subcommand("settings", "Print what can be set, as Markdown");
  settings->callback([] { std::fputs(describe_settings().c_str(), stdout); });

  command->footer(
      "\nExample:\n"
      "  vergence config build robot.toml -o robot.vcfg && vergenced --config robot.vcfg");
}

}  // namespace vergence::tools
