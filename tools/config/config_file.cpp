#include "tools/config/config_file.hpp"

#include <array>
#include <fstream>
#include <string>
#include <string_view>

#include "firmware_like/config/config_image.hpp"
#include "tools/config/read_config.hpp"
#include "tools/io/input_error.hpp"

namespace vergence::tools {

bool is_config_image(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::array<char, 8> start{};
  in.read(start.data(), start.size());
  return std::string_view(start.data(), 7) == "VERGCFG";
}

std::unique_ptr<ControllerConfig> read_any_config(const std::filesystem::path& file) {
  if (!is_config_image(file)) return read_config(file);
  std::ifstream in(file, std::ios::binary);
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

}  // namespace vergence::tools
