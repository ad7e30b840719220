#include "tools/render/command.hpp"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "tools/cli/progress.hpp"
#include "tools/io/input_error.hpp"
#include "tools/io/writable.hpp"
#include "tools/render/contact_sheet.hpp"
#include "tools/render/creatures.hpp"
#include "tools/render/dataset_writer.hpp"

namespace vergence::tools {
namespace {

struct RenderOptions {
  std::string scene;
  std::string out;
  std::string target;
  std::string sheet;
  int frames = 0;
  int seed = -1;
  int threads = 0;
  std::vector<std::string> changes;
  double scale = 1;
  bool list = false;
};

void list_creatures() {
  for (const auto& c : render::creatures()) {
    std::printf("%s  %-12s %6g x %6g x %6g mm\n", std::string(c.code).c_str(), std::string(c.name).c_str(),
                c.size_mm[0], c.size_mm[1], c.size_mm[2]);
  }
}

void run(const RenderOptions& options) {
  if (options.list) return list_creatures();
  if (options.scene.empty()) throw CLI::RequiredError("SCENE");
  render::SceneOverrides overrides;
  overrides.scale = options.scale;
  if (!options.target.empty()) overrides.target = options.target;
  if (options.seed >= 0) overrides.seed = static_cast<std::uint64_t>(options.seed);
  for (const std::string& change : options.changes) overrides.patch += change + "\n";
  if (!options.sheet.empty()) {
    require_writable(options.sheet);
    write_png(options.sheet, render::contact_sheet(options.scene, overrides, 2));
    std::printf("%s\n", options.sheet.c_str());
    return;
  }
  if (options.out.empty()) throw CLI::RequiredError("--out");
  const render::Scene scene = render::load_scene(options.scene, overrides);
  const int frames = options.frames > 0 ? options.frames : scene.frames;
  const int cores = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  Progress progress("rendering", static_cast<std::size_t>(frames));
  render::write_dataset(scene, options.out, frames,
                        options.threads > 0 ? options.threads : std::min(cores, 32),
                        [&] { progress.step(); });
  progress.hide();
  std::printf("%s: %d frame%s of %s\n", options.out.c_str(), frames, frames == 1 ? "" : "s",
              scene.target.name.c_str());
}

}  // namespace

void add_render_command(CLI::App& app) {
  auto options = std::make_shared<RenderOptions>();
  CLI::App* command = app.add_subcommand("render", "Render a scene to a data set with known truth");
  command->add_option("scene", options->scene, "Scene description, TOML (see docs/render.md)")
      ->type_name("SCENE.toml");
  command->add_option("-o,--out", options->out, "Directory of the data set; made where missing")
      ->type_name("DIR");
  command->add_option("--frames", options->frames, "How many frames, instead of the scene's")
      ->check(CLI::Range(1, 999999));
  command
      ->add_option("--seed", options->seed,
                   "Seed of noise, background and random poses, instead of the scene's")
      ->check(CLI::Range(0, 1 << 30));
  command->add_option("--target", options->target,
                      "Another creature in place of the scene's: C01..C12 or its name");
  command
      ->add_option(
          "--set", options->changes,
          "A key of the scene in TOML, instead of what it says, several times: 'light.preset=\"30lx\"'")
      ->type_name("KEY=VALUE")
      ->expected(1)
      ->take_all();
  command->add_option("--scale", options->scale, "Scale of the images")->check(CLI::Range(0.05, 4.0));
  command->add_option("--threads", options->threads, "Threads; no byte depends on them (default: all cores)")
      ->check(CLI::Range(1, 256));
  command
      ->add_option("--contact-sheet", options->sheet, "Instead: one picture of all creatures in this scene")
      ->type_name("FILE.png");
  command->add_flag("--list-creatures", options->list, "Instead: list codes, names and sizes");
  command->callback([options] { run(*options); });
}

}  // namespace vergence::tools
