// One frame of classic CAN with an 11-bit identifier, and what an error frame says. Independent of the
// operating system; error frames have the bits that Linux gives them.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

namespace vergence::canopen {

struct CanFrame {
  std::uint32_t id = 0;   // 11 bits; of an error frame, the classes of error
  std::uint8_t size = 0;  // of data, at most 8
  bool is_remote = false;
  bool is_error = false;
  std::array<std::uint8_t, 8> data{};
  std::int64_t stamp_ns = 0;  // when it was received; of a frame to be sent, nothing

  [[nodiscard]] std::span<const std::uint8_t> payload() const {
    return std::span(data).first(std::min<std::size_t>(size, data.size()));
  }
};

// What a socket lets through: frames with (id & mask) == (filter.id & mask).
struct CanFilter {
  std::uint32_t id = 0;
  std::uint32_t mask = 0x7FF;
};

// Classes of error (the identifier of an error frame) and bits of its second byte.
inline constexpr std::uint32_t kErrorTxTimeout = 0x001;
inline constexpr std::uint32_t kErrorLostArbitration = 0x002;
inline constexpr std::uint32_t kErrorController = 0x004;
inline constexpr std::uint32_t kErrorProtocol = 0x008;
inline constexpr std::uint32_t kErrorTransceiver = 0x010;
inline constexpr std::uint32_t kErrorNoAcknowledge = 0x020;
inline constexpr std::uint32_t kErrorBusOff = 0x040;
inline constexpr std::uint32_t kErrorBus = 0x080;
inline constexpr std::uint32_t kErrorRestarted = 0x100;
inline constexpr std::uint8_t kControllerRxOverflow = 0x01;
inline constexpr std::uint8_t kControllerTxOverflow = 0x02;
inline constexpr std::uint8_t kControllerWarning = 0x0C;  // receiving or transmitting
inline constexpr std::uint8_t kControllerPassive = 0x30;
inline constexpr std::uint8_t kControllerActive = 0x40;  // is well again

struct CanErrors {
  bool bus_off = false;
  bool restarted = false;
  bool passive = false;
  bool warning = false;
  bool active = false;
  bool rx_overflow = false;
  bool tx_overflow = false;
  bool no_acknowledge = false;
  bool tx_timeout = false;
  bool lost_arbitration = false;
  bool transceiver = false;
  bool protocol = false;
};

// Of an error frame; of any other frame, nothing.
[[nodiscard]] CanErrors decode_errors(const CanFrame& frame);

// The gravest of them in words.
[[nodiscard]] const char* describe(const CanErrors& errors);

}  // namespace vergence::canopen
