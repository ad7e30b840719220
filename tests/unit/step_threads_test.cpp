// The eyes' task and the step task in threads of their own, in virtual time: nothing is shared without the
// thread sanitizer's consent, no command undoes another, and steps issued are steps counted.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <thread>

#include "hal/gpio_step/step_motors.hpp"
#include "tests/support/random.hpp"
#include "tests/support/step_rig.hpp"

namespace vergence::step {
namespace {

// Lines for two threads. Outputs and inputs are the step task's.
class SharedLines {
 public:
  [[nodiscard]] bool set_outputs(std::uint32_t levels) {
    for (int motor = 0; motor < kPanTiltMotors; ++motor) {
      if ((levels & ~outputs_ & step_bit(motor)) == 0) continue;
      steps[static_cast<std::size_t>(motor)] += (outputs_ & forward_bit(motor)) != 0 ? 1 : -1;
    }
    outputs_ = levels;
    return true;
  }
  [[nodiscard]] bool set_enable(bool on) {
    enabled.store(on);
    return true;
  }
  [[nodiscard]] bool read_inputs(std::uint32_t& levels) const {
    levels = inputs.load();
    return true;
  }
  std::array<std::int64_t, kPanTiltMotors> steps{};
  std::atomic<bool> enabled{true};
  std::atomic<std::uint32_t> inputs{0};

 private:
  std::uint32_t outputs_ = 0;
};

class Robot {
 public:
  Robot() {
    StepMotorsConfig config = testing::config_of_step_rig();
    config.settle_ns = 0;
    config.motors[0].high_end = EndAction::kFault;
    bool lines_work = false;
    EXPECT_EQ(motors.configure(config, lines_work).error, TimingError::kNone);
    EXPECT_TRUE(lines_work);
    step_task_ = std::thread([this] {
      while (!stop_.load()) {
        run_once();
        std::this_thread::yield();
      }
      for (int i = 0; i < 1000; ++i) run_once();  // pulses that have begun end
    });
  }
  ~Robot() {
    if (step_task_.joinable()) join();
  }
  Robot(const Robot&) = delete;
  Robot& operator=(const Robot&) = delete;

  void join() {
    stop_.store(true);
    step_task_.join();
    (void)motors.read(feedback);
  }
  // Until the step task says so.
  void wait_for(PanTiltState state) {
    while (feedback.state != state) {
      if (!motors.read(feedback)) std::this_thread::yield();
    }
  }

  SharedLines lines;
  sim::SimClock clock;  // the step task's
  StepMotors<SharedLines, sim::SimClock> motors{lines, clock};
  PanTiltFeedback feedback;

 private:
  void run_once() {
    clock.set_now_ns(std::max(clock.now_ns(), motors.next_deadline_ns()));
    motors.run_edges(clock.now_ns());
  }
  std::atomic<bool> stop_{false};
  std::thread step_task_;
};

TEST(StepThreadsTest, WhatTheEyesTaskWantsLastHolds) {
  const auto robot = std::make_unique<Robot>();
  testing::Random random(8);
  for (int cycle = 0; cycle < 300; ++cycle) {
    robot->motors.enable(true);
    for (int toggle = random.below(3); toggle > 0; --toggle) {
      robot->motors.enable(false);
      robot->motors.enable(true);
    }
    robot->wait_for(PanTiltState::kEnabled);
    for (int command = random.below(50); command > 0; --command) {
      robot->motors.command({random.between(-1e4, 1e4), random.between(-1e4, 1e4), 5000});
      (void)robot->motors.read(robot->feedback);
    }
    if (cycle % 2 == 0) {  // some steps at least
      robot->motors.command({0, 0, 5000});
      for (const std::int64_t before = robot->feedback.steps[2]; robot->feedback.steps[2] < before + 5;) {
        if (!robot->motors.read(robot->feedback)) std::this_thread::yield();
      }
    }
    if (cycle % 3 == 0) {  // a fault
      robot->lines.inputs.store(high_end_bit(0));
      robot->motors.command({1e4, 0, 0});
      robot->wait_for(PanTiltState::kFault);
      robot->lines.inputs.store(0);
      EXPECT_FALSE(robot->lines.enabled.load());
    }
    robot->motors.enable(false);
    robot->wait_for(PanTiltState::kDisabled);
    EXPECT_FALSE(robot->lines.enabled.load());
  }
  robot->join();
  EXPECT_FALSE(robot->lines.enabled.load());
  EXPECT_EQ(robot->feedback.steps, robot->lines.steps);
  EXPECT_GE(robot->feedback.steps[2], 750);
  EXPECT_EQ(robot->motors.report().line_failures, 0U);
}

}  // namespace
}  // namespace vergence::step
