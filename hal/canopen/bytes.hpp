// Numbers in a CAN frame: least significant byte first, as CiA 301 has them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace vergence::canopen {

// The first `size` bytes, at most four; bytes that are not there count as zero.
[[nodiscard]] constexpr std::uint32_t get_number(std::span<const std::uint8_t> bytes, std::size_t size) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < size && i < bytes.size() && i < 4; ++i) {
    value |= static_cast<std::uint32_t>(bytes[i]) << (8 * i);
  }
  return value;
}

constexpr void put_number(std::span<std::uint8_t> bytes, std::size_t size, std::uint32_t value) {
  for (std::size_t i = 0; i < size && i < bytes.size() && i < 4; ++i) {
    bytes[i] = static_cast<std::uint8_t>(value >> (8 * i));
  }
}

}  // namespace vergence::canopen
