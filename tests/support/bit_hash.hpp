// One number for the bits of many (FNV-1a), to tell whether behaviour is unchanged.
#pragma once

#include <bit>
#include <cstdint>

namespace vergence::testing {

class BitHash {
 public:
  void add(double number) {
    const auto bits = std::bit_cast<std::uint64_t>(number);
    for (int i = 0; i < 8; ++i) {
      value_ ^= (bits >> (8 * i)) & 0xFF;
      value_ *= 0x100000001B3ULL;
    }
  }
  [[nodiscard]] std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xCBF29CE484222325ULL;
};

}  // namespace vergence::testing
