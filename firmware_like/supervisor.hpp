// Keeps the mode: turns what is seen of devices, target and operator into events, most urgent first, and runs
// them through the table. Called once a period of the arm's task.
#pragma once

#include <array>
#include <cstdint>

#include "firmware_like/messages.hpp"
#include "firmware_like/mode.hpp"

namespace vergence {

enum class SelfTest : std::uint8_t {
  kRunning,
  kPassed,
  kFailed,
};

struct Conditions {
  bool devices_ready = false;  // all have answered
  SelfTest self_test = SelfTest::kRunning;
  bool device_fault = false;
  bool following_error = false;
  bool target_believed = false;
  bool at_rest = true;
  int missed_deadlines = 0;  // in a row
};

// One change of mode, for telemetry and the black box.
struct ModeChange {
  std::int64_t t_ns = 0;
  Mode from = Mode::kInit;
  Mode to = Mode::kInit;
  Event event = Event::kDevicesReady;
};

class Supervisor {
 public:
  static constexpr std::size_t kChanges = 32;

  void configure(int most_missed_deadlines);

  // An operator's command, obeyed by the next step(). The last one of a period counts, but a stop outlasts
  // any other.
  void command(OperatorCommand command);

  Mode step(std::int64_t now_ns, const Conditions& conditions);

  [[nodiscard]] Mode mode() const { return mode_; }

  // Changes since the beginning; the last kChanges of them are kept.
  [[nodiscard]] std::uint64_t changes() const { return changes_; }
  [[nodiscard]] const ModeChange& change(std::uint64_t i) const { return kept_[i % kChanges]; }

 private:
  void apply(std::int64_t now_ns, Event event);

  int most_missed_deadlines_ = 1;
  Mode mode_ = Mode::kInit;
  bool servo_wanted_ =
      false;  // the operator wants the hand to follow as soon as there is something to follow
  bool commanded_ = false;
  OperatorCommand command_ = OperatorCommand::kStop;
  std::array<ModeChange, kChanges> kept_{};
  std::uint64_t changes_ = 0;
};

}  // namespace vergence
