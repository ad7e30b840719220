// The configuration as one file that `vergenced` reads without parsing: a header that says what it is, and
// the settings in the order of the table, then geometry, arm and target. Whatever is wrong with it is
// refused.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware_like/config/controller_config.hpp"

namespace vergence {

// Raised with every change of what is stored that the table's own check sum does not see.
inline constexpr std::uint32_t kImageVersion = 3;
inline constexpr std::size_t kMaxImageBytes = std::size_t{512} * 1024;

enum class ImageStatus : std::uint8_t {
  kOk,
  kTruncated,
  kNotAnImage,
  kWrongByteOrder,
  kOtherVersion,
  kOtherSettings,  // of the same version, but with other settings: made by another build
  kWrongSize,
  kCorrupted,
  kBadValue,  // the check sum is right, but a setting is out of its range or two do not go together
  kTooSmall,  // to be written: the room does not suffice
};
// What is wrong and what to do, for people.
[[nodiscard]] const char* describe(ImageStatus status);

struct ImageResult {
  ImageStatus status = ImageStatus::kOk;
  std::size_t bytes = 0;  // of the image
  // Of kBadValue: the setting, or the section where two do not go together.
  const char* section = "";
  const char* key = "";
  const char* problem = "";
};

// Into `room`, kMaxImageBytes are always enough. Paddings are zero: equal configurations are equal images.
[[nodiscard]] ImageResult write_image(const ControllerConfig& config, std::span<std::byte> room);

// `config` is only to be used where kOk is answered.
[[nodiscard]] ImageResult read_image(std::span<const std::byte> image, ControllerConfig& config);

}  // namespace vergence
