// What the controller says of itself in its shared memory: for the log, and for what is judged of its state.
// The robot is never moved by it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "algo/tracker.hpp"
#include "firmware_like/daemon/telemetry_segment.hpp"
#include "firmware_like/mode.hpp"

namespace vergence::rig {

class ControllerView {
 public:
  // Of this shared memory, as shm_open() names it.
  explicit ControllerView(std::string name) : name_(std::move(name)) {}

  // Looks again: at the memory of the controller that runs now, where it was started anew.
  void look();

  // Empty where it has said nothing since the look before.
  [[nodiscard]] const std::optional<TelemetryRecord>& record() const { return record_; }
  // It looks for the target, and believes in none.
  [[nodiscard]] bool searches() const;
  // Its last look at pictures found the target.
  [[nodiscard]] bool tracks() const;

 private:
  std::string name_;
  TelemetryReader reader_;
  std::uint64_t period_ = 0;
  std::optional<TelemetryRecord> record_;
};

}  // namespace vergence::rig
