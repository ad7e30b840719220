// Is the bus sound, and is every drive on it what the configuration says?
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "firmware_like/config/controller_config.hpp"
#include "hal/canopen/can_bus.hpp"
#include "hal/canopen/nmt.hpp"
#include "tools/bringup/can_link.hpp"
#include "tools/bringup/finding.hpp"

namespace vergence::tools {

inline constexpr int kRoundTrips = 50;

// An object that was asked for.
struct ObjectReading {
  enum class State : std::uint8_t {
    kNotAsked,
    kRead,
    kRefused,  // abort_code says why
    kNoAnswer,
  };
  State state = State::kNotAsked;
  std::uint32_t abort_code = 0;
  std::vector<std::uint8_t> bytes;

  [[nodiscard]] bool was_read() const { return state == State::kRead; }
  [[nodiscard]] std::uint32_t number() const;  // of the first four bytes
};

// What came by itself, by node.
struct HeardNode {
  int heartbeats = 0;
  int boots = 0;
  std::int64_t first_ns = 0;  // heartbeats
  std::int64_t last_ns = 0;
  canopen::NmtState state = canopen::NmtState::kUnknown;
  std::uint16_t emergency = 0;  // code of the last; 0: none
  int others = 0;               // process data
};

struct DriveObservation {
  ObjectReading device_type;
  ObjectReading vendor;
  ObjectReading name;
  ObjectReading heartbeat_ms;
  ObjectReading error_register;
  ObjectReading statusword;
  ObjectReading position;
  std::vector<std::int64_t> round_trips_ns;
  int unanswered = 0;  // of those

  [[nodiscard]] bool answers() const {
    return device_type.state == ObjectReading::State::kRead ||
           device_type.state == ObjectReading::State::kRefused;
  }
};

// Of one of the buses.
struct CanObservation {
  int bus = 0;
  CanLink link;
  std::string open_problem;  // empty: the bus was listened to
  std::array<HeardNode, canopen::kMaxNodeId + 1> heard{};
  std::array<bool, canopen::kMaxNodeId + 1> found{};  // by asking every node once
  std::vector<DriveObservation> drives;               // by axis; empty those of the other bus
  int foreign_commands = 0;                           // SYNC, NMT, requests and commands that were not ours
  canopen::CanHealth health;
};

// Where there are two buses, the checks that are of no drive say of which they are.
[[nodiscard]] std::vector<Finding> judge(const CanObservation& seen, const CanConfig& config);

}  // namespace vergence::tools
