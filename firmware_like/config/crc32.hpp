// The cyclic redundancy check of Ethernet and PNG (IEEE 802.3), bit by bit: an image is checked once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace vergence {

// Of several pieces: hand on what came of the last.
[[nodiscard]] constexpr std::uint32_t crc32(std::span<const std::byte> bytes, std::uint32_t before = 0) {
  std::uint32_t crc = ~before;
  for (const std::byte byte : bytes) {
    crc ^= static_cast<std::uint32_t>(byte);
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1U) != 0 ? 0xEDB88320U : 0U);
  }
  return ~crc;
}

}  // namespace vergence
