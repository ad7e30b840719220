// The eyes' three motors on step and direction lines: commands come from the eyes' task, edges are made by a
// task of their own that sleeps until next_deadline_ns() and calls run_edges(). They meet by mailboxes.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "hal/clock.hpp"
#include "hal/gpio_step/motor_set.hpp"
#include "hal/gpio_step/step_lines.hpp"
#include "hal/latest_value.hpp"
#include "hal/pan_tilt.hpp"

namespace vergence::step {

struct StepMotorsConfig {
  std::array<MotorConfig, kPanTiltMotors> motors{};
  // Inputs are read, commands taken and feedback given at least this often.
  std::int64_t poll_ns = 1'000'000;
  // From the enable line to the first pulse.
  std::int64_t settle_ns = 10'000'000;
};

// What the step task says of itself.
struct StepReport {
  PanTiltFeedback feedback;
  MotorFault fault;
  std::array<bool, kPanTiltMotors> homed{};
  std::uint64_t late_events = 0;       // later than the jitter allows
  std::int64_t delay_ns = 0;           // of the most delayed motor's motion, for that
  std::uint64_t refused_commands = 0;  // above a maximum rate, or no number
  std::uint64_t line_failures = 0;     // calls that could not set or read lines
};

// A rate as the generators take it. What is no number, or beyond any rate, becomes one that they refuse.
[[nodiscard]] std::int64_t to_millisteps_per_s(double steps_per_s);

// The part that knows neither lines nor threads: states, settling, and who may move when.
class StepSequencer {
 public:
  [[nodiscard]] MotorError configure(const StepMotorsConfig& config, std::int64_t now_ns);

  [[nodiscard]] PanTiltState state() const { return state_; }
  void enter_enabled(std::int64_t now_ns);
  void enter_disabled();
  void enter_fault(const MotorFault& fault);

  [[nodiscard]] bool is_poll_due(std::int64_t now_ns) const { return now_ns >= next_poll_ns_; }
  void polled(std::int64_t now_ns) { next_poll_ns_ = now_ns + config_.poll_ns; }
  void set_inputs(std::uint32_t inputs) { inputs_ = inputs; }
  void set_rates(const MotorRates& rates);
  // Hands the rates on; answers the fault that came of it.
  [[nodiscard]] MotorFault steer(std::int64_t now_ns);

  [[nodiscard]] std::int64_t next_deadline_ns() const;
  [[nodiscard]] MotorSet& motors() { return motors_; }
  [[nodiscard]] StepReport report(std::int64_t now_ns) const;

 private:
  StepMotorsConfig config_;
  MotorSet motors_;
  MotorRates rates_{};
  bool fresh_rates_ = false;
  PanTiltState state_ = PanTiltState::kDisabled;
  MotorFault fault_;
  std::uint32_t inputs_ = 0;
  std::int64_t next_poll_ns_ = 0;
  std::int64_t settled_ns_ = 0;
  std::uint64_t refused_commands_ = 0;
};

template <StepLines Lines, Clock C>
class StepMotors {
 public:
  StepMotors(Lines& lines, C& clock) : lines_(&lines), clock_(&clock) {}

  // Before the tasks start. Enable line dropped, step lines at rest. Errors: see TimingError; and false in
  // `lines_work` where the lines cannot be set.
  [[nodiscard]] MotorError configure(const StepMotorsConfig& config, bool& lines_work) {
    const MotorError error = sequencer_.configure(config, clock_->now_ns());
    if (error.error != TimingError::kNone) return error;
    wish_.store(0);
    followed_ = 0;
    drop_failed_.store(false);
    is_command_new_ = false;
    line_failures_ = 0;
    written_ = sequencer_.motors().outputs();
    are_drives_off_ = lines_->set_enable(false);
    are_lines_set_ = lines_->set_outputs(written_);
    lines_work = are_drives_off_ && are_lines_set_;
    return error;
  }

  // The eyes' task; see hal/pan_tilt.hpp. Rates are those of the last command since the last enable(true).
  [[nodiscard]] bool read(PanTiltFeedback& feedback) {
    if (!to_eyes_.read(report_)) return false;
    feedback = report_.feedback;
    return true;
  }
  void command(const std::array<double, kPanTiltMotors>& steps_per_s) {
    Command command;
    command.wish = wish_.load(std::memory_order_relaxed);
    for (std::size_t i = 0; i < command.rates.size(); ++i) {
      command.rates[i] = to_millisteps_per_s(steps_per_s[i]);
    }
    from_eyes_.write(command);
  }
  // Disabling drops the enable line before it returns; a step task that is just raising it for a wish from
  // before drops it again at once. It also
  // clears a fault; where its cause is still there, that clears itself once the cause is gone.
  void enable(bool on) {
    const std::uint32_t wish = wish_.load(std::memory_order_relaxed);
    if (is_on(wish) == on) return;
    wish_.store(wish + 1);
    if (!on && !lines_->set_enable(false)) drop_failed_.store(true);
  }
  // With the last feedback that was read.
  [[nodiscard]] const StepReport& report() const { return report_; }

  // The step task.
  [[nodiscard]] std::int64_t next_deadline_ns() const { return sequencer_.next_deadline_ns(); }
  void run_edges(std::int64_t now_ns) {
    const PanTiltState before = sequencer_.state();
    const std::uint32_t wish = wish_.load();
    const bool polls = sequencer_.is_poll_due(now_ns) || wish != followed_;
    heed_drops(wish);
    if (polls) poll(wish, now_ns);
    if (is_on(wish) && !are_lines_set_) make_edges(now_ns);
    if (is_on(wish) && sequencer_.state() == PanTiltState::kDisabled) switch_on(wish);
    followed_ = wish;
    take_command(wish);
    fail(sequencer_.steer(now_ns));
    make_edges(now_ns);
    if (polls || sequencer_.state() != before) report_to_eyes(now_ns);
  }

 private:
  struct Command {
    MotorRates rates{};
    std::uint32_t wish = 0;  // given under
  };
  static bool is_on(std::uint32_t wish) { return (wish & 1U) != 0; }

  // What was switched off is off, and a fault is over, even if it was switched on again since.
  void heed_drops(std::uint32_t wish) {
    if (drop_failed_.exchange(false)) {
      ++line_failures_;
      are_drives_off_ = false;
    }
    if (wish != followed_ && sequencer_.state() != PanTiltState::kDisabled) {
      sequencer_.enter_disabled();
      are_drives_off_ = false;
    }
    if (sequencer_.state() != PanTiltState::kEnabled && !are_drives_off_) drop();
  }

  void poll(std::uint32_t wish, std::int64_t now_ns) {
    sequencer_.polled(now_ns);
    std::uint32_t inputs = 0;
    const bool are_inputs_read = lines_->read_inputs(inputs);
    if (are_inputs_read) {
      sequencer_.set_inputs(inputs);
    } else {
      ++line_failures_;
      fail({StepFault::kInputsUnreadable, -1});
    }
    // Nobody wants the drives on, and whatever failed works again.
    if (sequencer_.state() == PanTiltState::kFault && !is_on(wish) && are_inputs_read && are_lines_set_ &&
        are_drives_off_) {
      sequencer_.enter_disabled();
    }
  }

  void switch_on(std::uint32_t wish) {
    are_drives_off_ = false;
    if (!lines_->set_enable(true)) {
      ++line_failures_;
      fail({StepFault::kEnableFailed, -1});
    } else if (wish_.load() != wish) {
      drop();  // the eyes' task may have done so before the line was raised
    } else {
      sequencer_.enter_enabled(clock_->now_ns());
    }
  }

  // A command that was given under a wish the step task has not seen yet waits for it.
  void take_command(std::uint32_t wish) {
    if (from_eyes_.read(command_)) is_command_new_ = true;
    if (!is_command_new_ || command_.wish != wish || sequencer_.state() != PanTiltState::kEnabled) return;
    sequencer_.set_rates(command_.rates);
    is_command_new_ = false;
  }

  void make_edges(std::int64_t now_ns) {
    MotorSet& motors = sequencer_.motors();
    const std::uint32_t wanted = motors.advance(now_ns);
    if (wanted == written_ && are_lines_set_) return;
    const bool were_lines_set = are_lines_set_;
    are_lines_set_ = lines_->set_outputs(wanted);
    written_ = wanted;
    // Whatever happened in between, the least times count from here.
    const std::int64_t done_ns = clock_->now_ns();
    if (were_lines_set) {
      motors.written(done_ns);
    } else {
      motors.rewritten(done_ns);
    }
    if (are_lines_set_) return;
    ++line_failures_;
    fail({StepFault::kOutputsFailed, -1});  // and tried again in the next run
  }

  void report_to_eyes(std::int64_t now_ns) {
    StepReport report = sequencer_.report(now_ns);
    report.line_failures = line_failures_;
    to_eyes_.write(report);
  }

  void fail(const MotorFault& fault) {
    if (fault.fault == StepFault::kNone || sequencer_.state() == PanTiltState::kFault) return;
    sequencer_.enter_fault(fault);
    drop();
  }

  // Drives that cannot be switched off are worse than whatever was the cause; it is tried again in each run.
  void drop() {
    are_drives_off_ = lines_->set_enable(false);
    if (are_drives_off_) return;
    ++line_failures_;
    sequencer_.enter_fault({StepFault::kEnableFailed, -1});
  }

  Lines* lines_;
  C* clock_;

  // The eyes' task.
  StepReport report_;
  // Odd: the drives are to be on. Counted, so that off and on again between two runs of the step task is
  // seen.
  std::atomic<std::uint32_t> wish_{0};
  std::atomic<bool> drop_failed_{false};

  // The step task.
  StepSequencer sequencer_;
  std::uint32_t written_ = 0;
  std::uint32_t followed_ = 0;   // wish
  bool are_lines_set_ = false;   // to written_
  bool are_drives_off_ = false;  // surely
  Command command_;
  bool is_command_new_ = false;
  std::uint64_t line_failures_ = 0;

  LatestValue<Command> from_eyes_;
  LatestValue<StepReport> to_eyes_;
};

}  // namespace vergence::step
