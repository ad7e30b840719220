// `vergence config`: the controller's configuration, checked, built into an image, and shown.
#include <array>
#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <vector>

#include "firmware_like/config/config_image.hpp"
#include "tools/cli/commands.hpp"
#include "tools/config/read_config.hpp"
#include "tools/config/show_config.hpp"
#include "tools/io/input_error.hpp"

namespace vergence::tools {
namespace {

std::vector<std::byte> image_of(const std::filesystem::path& file, const ControllerConfig& config) {
  std::vector<std::byte> image(kMaxImageBytes);
  const ImageResult result = write_image(config, image);
  if (result.status != ImageStatus::kOk) {
    throw InputError(file, std::string(result.section) + "." + result.key, describe(result.status),
                     result.problem);
  }
  image.resize(result.bytes);
  return image;
}

// Beside its place first, so that a running controller never finds half of one.
void write_file(const std::filesystem::path& file, const std::vector<std::byte>& bytes) {
  const std::filesystem::path beside = file.string() + ".new";
  std::ofstream out(beside, std::ios::binary);
  out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  out.close();
  if (!out) throw InputError(beside, "", "cannot be written", "is there such a folder, and room?");
  std::filesystem::rename(beside, file);
}

std::unique_ptr<ControllerConfig> read_any(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::array<char, 8> start{};
  in.read(start.data(), start.size());
  if (std::string_view(start.data(), 7) != "VERGCFG") return read_config(file);
  in.seekg(0);
  std::vector<std::byte> image(kMaxImageBytes);
  in.read(reinterpret_cast<char*>(image.data()), static_cast<std::streamsize>(image.size()));
  image.resize(static_cast<std::size_t>(in.gcount()));
  auto config = default_config();
  const ImageResult result = read_image(image, *config);
  if (result.status != ImageStatus::kOk) {
    const std::string field = std::string(result.section) + (result.key[0] != '\0' ? "." : "") + result.key;
    throw InputError(file, field, describe(result.status), result.problem);
  }
  return config;
}

void check(const std::filesystem::path& file) {
  const auto config = read_any(file);
  const std::vector<std::byte> image = image_of(file, *config);
  std::printf("%s: good; an image of it has %zu bytes\n", file.c_str(), image.size());
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
  showing->callback([file] { std::fputs(show_config(*read_any(*file)).c_str(), stdout); });

  CLI::App* settings = command->add_subcommand("settings", "Print what can be set, as Markdown");
  settings->callback([] { std::fputs(describe_settings().c_str(), stdout); });

  command->footer(
      "\nExample:\n"
      "  vergence config build robot.toml -o robot.vcfg && vergenced --config robot.vcfg");
}

}  // namespace vergence::tools
