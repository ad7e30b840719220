// What the kernel says of a CAN interface: whether it is up, how fast it is, and how well.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace vergence::tools {

struct CanLink {
  bool was_told = false;  // the kernel answered
  bool exists = false;
  bool is_can = false;
  bool is_virtual = false;  // vcan: no wire, no bit rate
  bool is_up = false;
  std::uint32_t tx_queue = 0;  // frames
  // Not of every driver.
  std::optional<std::uint32_t> bitrate_bit_per_s;
  std::optional<std::uint32_t> state;  // of the kernel's enum can_state
  struct ErrorCounters {
    std::uint16_t tx = 0;
    std::uint16_t rx = 0;
  };
  std::optional<ErrorCounters> errors;
  std::optional<std::uint32_t> restart_ms;
};

// Of an answer to RTM_GETLINK [rtnetlink(7)], header included. What is cut short counts as not told.
[[nodiscard]] CanLink parse_link(std::span<const std::byte> message);

// Asks the kernel; needs no rights.
[[nodiscard]] CanLink read_link(const char* interface);

}  // namespace vergence::tools
