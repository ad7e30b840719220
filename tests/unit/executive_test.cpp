// The executive with devices in memory, on the machine's own clock: tasks run, commands arrive, faults stop.
#include "firmware_like/daemon/executive.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>

#include "tests/support/daemon_devices.hpp"

namespace vergence {
namespace {

using testing::DaemonDevices;

std::unique_ptr<ControllerConfig> marker_config() {
  auto config = std::make_unique<ControllerConfig>();
  config->robot = testing::config_of_robot();
  config->robot.tracker = default_settings(Method::kVergence, TargetKind::kMarker);
  config->robot.rig.left.T_H_C = left_eye_at_zero(config->robot.mount);
  config->robot.rig.right.T_H_C = right_eye_at_zero(config->robot.mount);
  // A machine that tests run on may be late by anything.
  config->robot.most_missed_deadlines = 1'000'000;
  config->robot.arm_timeout_ns = 900'000'000;
  config->target = TargetKind::kMarker;
  const std::array balls = {Ball{{-45, 30, 20}, 20, 0, 20}, Ball{{45, 25, -15}, 20, 120, 20},
                            Ball{{5, -45, 0}, 20, 240, 20}};
  EXPECT_EQ(build_marker_model(balls.data(), 3, {}, config->marker), Status::kOk);
  return config;
}

class ExecutiveTest : public ::testing::Test {
 protected:
  void start() {
    const StartResult result = executive->start(*config, rt::RealtimePolicy::kIgnore);
    ASSERT_EQ(result.status, Status::kOk);
    ASSERT_EQ(result.thread_error, rt::RtThreadError::kNone) << rt::describe(result.thread_error);
  }
  // Patient: what comes is asked, not when.
  bool comes(const std::function<bool(const TelemetryRecord&)>& predicate) {
    for (int i = 0; i < 20'000; ++i) {
      if (executive->last_record(record) && predicate(record)) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return false;
  }
  bool comes_to(Mode mode) {
    return comes([mode](const TelemetryRecord& r) { return r.mode == static_cast<std::uint32_t>(mode); });
  }

  std::unique_ptr<ControllerConfig> config = marker_config();
  DaemonDevices devices;
  std::unique_ptr<Executive<DaemonDevices>> executive = std::make_unique<Executive<DaemonDevices>>(devices);
  TelemetryRecord record;
};

TEST_F(ExecutiveTest, RunsEveryTaskAndObeysItsOperators) {
  start();
  ASSERT_TRUE(comes_to(Mode::kIdle));
  executive->operators().put(OperatorCommand::kArm);
  ASSERT_TRUE(comes_to(Mode::kSearch));
  ASSERT_TRUE(comes([](const TelemetryRecord& r) {
    return r.arm_state == static_cast<std::uint32_t>(ArmState::kEnabled);
  }));
  ASSERT_TRUE(comes([](const TelemetryRecord& r) {
    for (const TaskRecord& task : r.tasks) {
      if (task.runs < 3) return false;
    }
    return r.sighting > 0;
  }));
  EXPECT_FALSE(executive->health().silent(rt::MonotonicClock{}.now_ns()));
  executive->operators().put(OperatorCommand::kStop);
  ASSERT_TRUE(comes_to(Mode::kSafeStop));
  ASSERT_TRUE(comes([](const TelemetryRecord& r) {
    return r.arm_state == static_cast<std::uint32_t>(ArmState::kDisabled);
  }));
  // Latched: nothing but a reset leaves it.
  executive->operators().put(OperatorCommand::kArm);
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_TRUE(comes_to(Mode::kSafeStop));
  executive->operators().put(OperatorCommand::kReset);
  EXPECT_TRUE(comes_to(Mode::kIdle));
  executive->stop();
  EXPECT_FALSE(devices.capturing);
  for (const TaskId id : {TaskId::kArm, TaskId::kEyes, TaskId::kVision, TaskId::kCapture, TaskId::kSteps}) {
    const TaskSummary& summary = executive->summary(id);
    EXPECT_GT(summary.timing.timing.runs(), 0U) << task(id).name;
    EXPECT_GT(summary.stack_used_bytes, 0U) << task(id).name;
    EXPECT_LT(summary.stack_used_bytes, summary.stack_bytes) << task(id).name;
  }
}

// Periods that ran and periods that were lost are together as many as there were milliseconds, but for those
// the machine is behind at the moment: waited for is a moment in which that is little.
TEST_F(ExecutiveTest, RunsTheArmsTaskAsOftenAsItIsConfigured) {
  config->robot.arm_period_ns = 1'000'000;
  start();
  ASSERT_TRUE(comes_to(Mode::kIdle));
  const auto periods = [](const TelemetryRecord& r) {
    const TaskRecord& arm = r.tasks[static_cast<std::size_t>(TaskId::kArm)];
    return static_cast<double>(arm.runs + arm.slips);
  };
  const double begun = periods(record);
  const std::int64_t begun_ns = record.t_ns;
  EXPECT_TRUE(comes([&](const TelemetryRecord& r) {
    const double elapsed_ms = static_cast<double>(r.t_ns - begun_ns) * 1e-6;
    return elapsed_ms > 300 && std::abs((periods(r) - begun) / elapsed_ms - 1) < 0.1;
  }));
}

TEST_F(ExecutiveTest, StopsWhenTheDrivesFallSilentAndKeepsWhatLedToIt) {
  start();
  ASSERT_TRUE(comes_to(Mode::kIdle));
  executive->operators().put(OperatorCommand::kArm);
  ASSERT_TRUE(comes_to(Mode::kSearch));
  devices.drives_silent = true;
  ASSERT_TRUE(comes([](const TelemetryRecord& r) {
    return r.mode == static_cast<std::uint32_t>(Mode::kSafeStop) ||
           r.mode == static_cast<std::uint32_t>(Mode::kFault);
  }));
  BlackBox& box = executive->black_box();
  for (int i = 0; i < 20'000 && !box.is_frozen(); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  ASSERT_TRUE(box.is_frozen());
  ASSERT_GT(box.records(), kBoxTailRecords);
  std::size_t armed = 0;
  for (std::size_t i = 0; i < box.records(); ++i) {
    armed += is_armed(static_cast<Mode>(box.record_at(i).mode)) ? 1 : 0;
    EXPECT_LT(i == 0 ? 0 : box.record_at(i - 1).t_ns, box.record_at(i).t_ns);
  }
  EXPECT_GT(armed, 0U);
  EXPECT_GT(box.pairs(), 0U);
  box.release();
}

TEST_F(ExecutiveTest, StopsAfterMoreMissedPeriodsThanAllowed) {
  config->robot.most_missed_deadlines = 20;
  start();
  ASSERT_TRUE(comes_to(Mode::kIdle));
  executive->operators().put(OperatorCommand::kArm);
  ASSERT_TRUE(comes([](const TelemetryRecord& r) { return r.mode_changes >= 3; }));
  devices.arm_hangs_ms = 100;  // fifty periods
  ASSERT_TRUE(comes([](const TelemetryRecord& r) {
    return r.mode == static_cast<std::uint32_t>(Mode::kSafeStop) &&
           r.last_event == static_cast<std::uint32_t>(Event::kDeadlineMissed);
  }));
}

TEST_F(ExecutiveTest, RefusesWhatThePipelineRefuses) {
  config->robot.gains.feed_forward = 2;
  EXPECT_EQ(executive->start(*config, rt::RealtimePolicy::kIgnore).status, Status::kBadGains);
}

TEST(TaskHealth, NamesTheTaskThatIsSilent) {
  TaskHealth health;
  EXPECT_FALSE(health.silent(1'000'000'000'000));
  health.expect(TaskId::kArm, 0);
  health.expect(TaskId::kVision, 0);
  EXPECT_FALSE(health.silent(longest_silence_ns(TaskId::kArm)));
  EXPECT_EQ(health.silent(longest_silence_ns(TaskId::kArm) + 1), TaskId::kArm);
  health.ping(TaskId::kArm, longest_silence_ns(TaskId::kVision));
  EXPECT_EQ(health.silent(longest_silence_ns(TaskId::kVision) + 1), TaskId::kVision);
}

TEST(OperatorChannel, LosesNoStop) {
  OperatorChannel channel;
  EXPECT_FALSE(channel.take());
  channel.put(OperatorCommand::kArm);
  channel.put(OperatorCommand::kServo);
  EXPECT_EQ(channel.take(), OperatorCommand::kServo);
  EXPECT_FALSE(channel.take());
  channel.put(OperatorCommand::kStop);
  channel.put(OperatorCommand::kReset);
  channel.put(OperatorCommand::kArm);
  EXPECT_EQ(channel.take(), OperatorCommand::kStop);
  EXPECT_FALSE(channel.take());
}

}  // namespace
}  // namespace vergence
