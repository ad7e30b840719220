// Whole frames of the tracker, found, followed, lost and searched for, the arm's kinematics and the servo of
// the hand, without one call of the allocator.
#include <gtest/gtest.h>
#include <sys/mman.h>

#include <array>
#include <atomic>
#include <memory>
#include <vector>

#include "algo/hand_servo.hpp"
#include "algo/iterative_inverse.hpp"
#include "algo/pa10.hpp"
#include "hal/rt/machine_check.hpp"
#include "hal/rt/memory_lock.hpp"
#include "hal/rt/monotonic_clock.hpp"
#include "hal/rt/rt_thread.hpp"
#include "hal/rt/service_manager.hpp"
#include "hal/rt/sleep.hpp"
#include "hal/rt/task_timing.hpp"
#include "hal/v4l2/v4l2_stereo_camera.hpp"
#include "tests/noheap/heap_counter.hpp"
#include "tests/support/canopen_robot.hpp"
#include "tests/support/fake_video_system.hpp"
#include "tests/support/ideal_robot.hpp"
#include "tests/support/small_world.hpp"
#include "tests/support/step_rig.hpp"

namespace vergence {
namespace {

using testing::HeapCounter;

TEST(HeapCounter, CountsWhatAllocates) {
  const HeapCounter counter;
  const auto block = std::make_unique<std::vector<int>>(100);
  EXPECT_GE(counter.calls(), 2) << block->size();
}

TEST(HeapCounter, CountsWhatMaps) {
  const HeapCounter counter;
  void* const place = ::mmap(nullptr, 4096, PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  ASSERT_NE(place, MAP_FAILED);
  EXPECT_EQ(::munmap(place, 4096), 0);
  EXPECT_EQ(counter.calls(), 2);
}

TEST(NoHeap, FramesOfTheTrackerDoNotAllocate) {
  for (const TargetKind kind : {TargetKind::kMarker, TargetKind::kPhoto}) {
    for (const Method method : {Method::kVergence, Method::kThesis}) {
      testing::World world(kind);
      testing::Bench bench(world, 1, method);
      std::vector<std::pair<testing::Picture, testing::Picture>> frames;
      for (int frame = 0; frame < 6; ++frame) {
        const Transform truth = to_transform({{10.0 + frame, 0, 480}, {0, 0.1, 0}});
        world.present = frame != 3 && frame != 4;
        frames.emplace_back(world.look(world.rig.left, truth), world.look(world.rig.right, truth));
      }
      (void)bench.step(frames[0].first, frames[0].second, 10);  // Highway chooses its instruction set once
      const HeapCounter counter;
      for (const auto& [left, right] : frames) (void)bench.step(left, right, 600);
      EXPECT_EQ(counter.calls(), 0);
    }
  }
}

TEST(NoHeap, KinematicsOfTheArmDoNotAllocate) {
  const SerialArm arm = pa10();
  JointVector q;
  q << 0, 0.5, 0.1, 1.6, 0.1, -0.5, 0;
  Vector6 twist;
  twist << 10, 20, 30, 0.1, 0.2, 0.3;
  const HeapCounter counter;
  const ArmFrames frames = forward_kinematics(arm, q);
  const VelocityStep step = damped_joint_velocity(arm, geometric_jacobian(arm, frames), twist);
  const Pa10Inverse inverse = inverse_pa10(arm, frames.T_W_H, q);
  const bool is_found = nearest_solution(arm, inverse, q).has_value();
  const IkSolution reached = solve_ik_damped(arm, frames.T_W_H, JointVector(q * 1.2));
  Transform far = frames.T_W_H;
  far.t_mm *= 10;
  const IkSolution unreached = solve_ik_damped(arm, far, q);
  EXPECT_EQ(counter.calls(), 0);
  EXPECT_EQ(step.status, Status::kOk);
  EXPECT_TRUE(is_found);
  EXPECT_EQ(reached.result, IkResult::kReached);
  EXPECT_EQ(unreached.result, IkResult::kUnreachable);
}

TEST(NoHeap, PeriodsOfTheHandServoDoNotAllocate) {
  const SerialArm arm = pa10();
  JointVector q;
  q << 0, 0.5, 0.1, 1.6, 0.1, -0.5, 0;
  TargetMotion motion;
  DesiredRelation relation;
  relation.T_Ed_M.t_mm = Vector3(0, 0, 500);
  int taken = 0;
  int moving = 0;
  const HeapCounter counter;
  const Status configured = motion.configure({});
  for (int period = 0; period < 300; ++period) {
    const std::int64_t now_ns = period * 2'000'000LL;
    const ArmFrames frames = forward_kinematics(arm, q);
    Transform T_W_M = frames.T_W_H * relation.T_Ed_M;
    if (period >= 200) T_W_M.t_mm[1] += 50;  // outliers, then a new start
    if (period % 16 == 0 && motion.observe(now_ns, T_W_M)) ++taken;
    relation.position_only = period % 2 == 0;
    const HandError error = hand_error(frames.T_W_H, {}, motion.at(now_ns), relation);
    const Twist ahead = desired_hand_velocity(frames.T_W_H, motion.at(now_ns + 20'000'000), relation);
    const Twist twist = hand_twist(vergence_gains(), error, ahead);
    const VelocityStep step = joint_velocity(arm, geometric_jacobian(arm, frames), twist, q, q);
    if (step.status == Status::kOk) ++moving;
  }
  EXPECT_EQ(counter.calls(), 0);
  EXPECT_EQ(configured, Status::kOk);
  EXPECT_EQ(taken, 16);  // of 19: three outliers are left out
  EXPECT_EQ(moving, 300);
}

// Everything between the devices and back: found, followed, lost, stopped and reset.
TEST(NoHeap, TheWholeControllerDoesNotAllocate) {
  const auto robot = std::make_unique<testing::IdealRobot>();
  robot->run(0.1);
  const HeapCounter counter;
  robot->start();
  robot->run(1);
  const Mode following = robot->mode();
  robot->target_there = false;
  robot->run(0.5);
  robot->target_there = true;
  robot->run(0.5);
  robot->pipeline.command(OperatorCommand::kStop);
  robot->run(0.5);
  robot->pipeline.command(OperatorCommand::kReset);
  robot->run(0.1);
  EXPECT_EQ(counter.calls(), 0);
  EXPECT_EQ(following, Mode::kServo);
  EXPECT_EQ(robot->mode(), Mode::kIdle);
}

// A hundred thousand periods of the arm's task, with mode changes on the way.
TEST(NoHeap, AHundredThousandPeriodsNeitherAllocateNorFaultAPage) {
  const auto robot = std::make_unique<testing::IdealRobot>();
  robot->run(0.1);
  robot->start();
  robot->run(1);
  // Where it may not be locked, the kernel may take memory back, and what comes again is not the
  // controller's.
  const bool locked = rt::lock_memory().error == rt::MemoryLockError::kNone;
  const rt::PageFaults before = rt::page_faults_of_this_thread();
  const HeapCounter counter;
  for (int round = 0; round < 100; ++round) {
    robot->pipeline.command(OperatorCommand::kServo);
    robot->run(1.5);
    robot->pipeline.command(OperatorCommand::kHold);
    robot->run(0.5);
  }
  const rt::PageFaults after = rt::page_faults_of_this_thread();
  EXPECT_EQ(counter.calls(), 0);
  rt::unlock_memory();
  if (locked) {
    EXPECT_EQ(after.major - before.major, 0);
    EXPECT_EQ(after.minor - before.minor, 0);
  }
  EXPECT_EQ(robot->mode(), Mode::kHold);
  EXPECT_GE(robot->t_ns, 2'000'000LL * 100'000);
}

// Seven drives booted, moved, stopped by a fault, and reset; the drives' own side too.
void expect_no_allocation(const canopen::CanopenArmConfig& config, int bus_that_fails) {
  const auto robot = std::make_unique<testing::CanopenRobot>(config);
  const HeapCounter counter;
  const bool moved = robot->move();
  robot->drives[2].fail(0x4310);
  robot->request = ArmRequest::kDisable;
  robot->run(200);
  const canopen::FaultText words = canopen::describe(robot->fault());
  robot->arm.request(ArmRequest::kResetFault);
  const bool reset = robot->run_until(ArmState::kDisabled, 100);
  const bool enabled = robot->enable();
  robot->master_port(bus_that_fails).set_off(true);
  robot->run(10);
  EXPECT_EQ(counter.calls(), 0);
  EXPECT_TRUE(moved);
  EXPECT_TRUE(reset);
  EXPECT_TRUE(enabled);
  EXPECT_STREQ(words.data(), "axis 3: emergency: 0x4310, drive too hot");
  EXPECT_EQ(robot->fault().kind, canopen::ArmFaultKind::kBusOff);
}

TEST(NoHeap, TheArmsBusDoesNotAllocate) {
  expect_no_allocation(testing::config_of_drives(), 0);
}

TEST(NoHeap, TheArmsTwoBusesDoNotAllocate) {
  expect_no_allocation(testing::config_of_two_buses(), 1);
}

// Steps made and commanded, refused, stopped by a switch and by broken lines, and enabled again.
TEST(NoHeap, TheEyesMotorsDoNotAllocate) {
  step::StepMotorsConfig config = testing::config_of_step_rig();
  config.motors[1].high_end = step::EndAction::kFault;
  const auto rig = std::make_unique<testing::StepRig<>>();
  const HeapCounter counter;
  const step::MotorError error = rig->configure(config);
  std::uint64_t faults = 0;
  for (std::uint64_t round = 0; rig->runs < 100'000; ++round) {
    rig->lines.press(0);
    rig->motors.enable(true);
    rig->run_for(3'000'000);
    rig->command(8000, 4000, round % 8 == 0 ? 1e9 : -3000);
    rig->run_for(30'000'000);
    rig->command(-8000, 4000, 0);
    rig->run_for(30'000'000);
    if (round % 4 == 1) rig->lines.press(step::high_end_bit(1));
    rig->lines.break_outputs(round % 4 == 2);
    rig->lines.break_inputs(round % 4 == 3);
    rig->run_for(2'000'000);
    if (rig->state() == PanTiltState::kFault) ++faults;
    rig->lines.break_outputs(false);
    rig->lines.break_inputs(false);
    rig->motors.enable(false);
    rig->run_for(2'000'000);
    rig->lines.forget_edges();
  }
  EXPECT_EQ(counter.calls(), 0);
  EXPECT_EQ(error.error, step::TimingError::kNone);
  EXPECT_TRUE(rig->lines_work);
  EXPECT_GT(faults, 10U);
  EXPECT_GT(rig->report().refused_commands, 10U);
  EXPECT_GT(rig->steps(1), 10'000);
}

// From pictures to a sighting, the eyes' and the hand's motion looked up on the way.
TEST(NoHeap, VisionDoesNotAllocate) {
  testing::World world(TargetKind::kMarker);
  RobotConfig config = testing::config_of_robot();
  config.rig = world.rig;
  config.tracker = default_settings(Method::kVergence, TargetKind::kMarker);
  const auto vision = std::make_unique<VisionTask>();
  const auto model = std::make_unique<MarkerModel>();
  world.make_model(*model);
  ASSERT_EQ(vision->configure(config, *model), Status::kOk);
  HandHistory hand;
  EyeHistory eyes;
  for (int i = 0; i < 60; ++i) {
    hand.add(2'000'000 * i, {0, 0.46, 0, 1.62, 0, -0.51, 0});
    eyes.add(2'000'000 * i, {0, 0, 0});
  }
  const Transform truth = to_transform({{10, 0, 480}, {0, 0.1, 0}});
  const testing::Picture left = world.look(world.rig.left, truth);
  const testing::Picture right = world.look(world.rig.right, truth);
  Sighting sighting;
  (void)vision->step({0, 1'000'000, left.view(), right.view()}, hand, eyes, sighting);
  const HeapCounter counter;
  const bool seen = vision->step({1, 34'000'000, left.view(), right.view()}, hand, eyes, sighting);
  const bool too_late = vision->step({2, 150'000'000, left.view(), right.view()}, hand, eyes, sighting);
  EXPECT_EQ(counter.calls(), 0);
  EXPECT_TRUE(seen);
  EXPECT_FALSE(too_late);
  EXPECT_EQ(vision->frames_left_out(), 1U);
}

// The fake kernel may allocate where the real one is called; nothing on our side of the seam may.
class UncountedSystem final : public v4l2::VideoSystem {
 public:
  testing::FakeVideoSystem fake;
  long own_calls = 0;  // of the allocator

  [[nodiscard]] std::int64_t now_ns() const { return fake.now_ns(); }
  int open(const char* path, int& handle) override {
    return uncounted([&] { return fake.open(path, handle); });
  }
  void close(int handle) override {
    uncounted([&] { return fake.close(handle), 0; });
  }
  int control(int handle, unsigned long request, void* argument) override {
    return uncounted([&] { return fake.control(handle, request, argument); });
  }
  int poll(std::span<v4l2::PollEntry> entries, std::int64_t timeout_ns) override {
    return uncounted([&] { return fake.poll(entries, timeout_ns); });
  }
  int map(int handle, std::size_t bytes, std::int64_t offset, std::uint8_t*& memory) override {
    return uncounted([&] { return fake.map(handle, bytes, offset, memory); });
  }
  int map_own(std::size_t bytes, std::uint8_t*& memory) override {
    return uncounted([&] { return fake.map_own(bytes, memory); });
  }
  void unmap(std::uint8_t* memory, std::size_t bytes) override {
    uncounted([&] { return fake.unmap(memory, bytes), 0; });
  }
  const HeapCounter* counter = nullptr;

 private:
  template <typename F>
  int uncounted(F call) {
    const long before = counter == nullptr ? 0 : counter->calls();
    const int e = call();
    own_calls += counter == nullptr ? 0 : counter->calls() - before;
    return e;
  }
};

// Cameras from the first opening over a stall and an unplugging to the end.
TEST(NoHeap, CapturingDoesNotAllocate) {
  testing::FakeVideoDevice left;
  testing::FakeVideoDevice right;
  right.path = "/dev/video2";
  UncountedSystem system;
  system.fake.devices = {&left, &right};
  v4l2::StereoVideoConfig config;
  config.eyes = {config_of(left), config_of(right)};
  const auto camera = std::make_unique<v4l2::V4l2StereoCamera>();
  int pairs = 0;
  const HeapCounter counter;
  system.counter = &counter;
  int side = 0;
  const bool configured = is_ok(camera->configure(system, config, side));
  camera->start(0);
  for (int i = 0; i < 1000; ++i) {
    StereoFrame frame;
    v4l2::StereoVideoReport report;
    camera->run_once(system);
    if (camera->take(frame)) ++pairs;
    (void)camera->report(report);
    left.stalls = i >= 300 && i < 350;
    if (i == 500) right.is_present = false;
    if (i == 600) right.is_present = true;
  }
  camera->stop();
  system.counter = nullptr;
  EXPECT_EQ(counter.calls() - system.own_calls, 0);
  EXPECT_TRUE(configured);
  EXPECT_GT(pairs, 200);
}

// The executive, from the look at the machine to the end of a periodic task. The C library takes the thread's
// local storage from the heap while it starts.
TEST(NoHeap, TheExecutiveDoesNotAllocate) {
  struct Task {
    std::atomic<bool> stop = false;
    rt::TimingRecord record;
    long calls = -1;

    static void run(void* context) {
      Task& task = *static_cast<Task*>(context);
      rt::MonotonicClock clock;
      rt::MonotonicSleeper sleeper;
      rt::PeriodicSchedule schedule(clock.now_ns(), 100'000);
      rt::ServiceManager service;
      const HeapCounter counter;
      const bool opened = service.open({"/nonexistent/notify", "1000", nullptr}) == rt::ServiceError::kNone;
      rt::run_periodic(clock, sleeper, schedule, task.record, task.stop, [&](const rt::Release& release) {
        (void)service.keep_alive(release.now_ns);
        (void)service.status("running");
        task.stop = task.record.timing.runs() == 100;
      });
      task.calls = opened ? counter.calls() : -2;
    }
  };
  static rt::RtStack<std::size_t{256} * 1024> stack;
  const auto task = std::make_unique<Task>();
  rt::RtThread thread;
  rt::RtThreadConfig config;
  config.stack = stack.span();
  config.policy = rt::RealtimePolicy::kIgnore;
  ASSERT_EQ(thread.start(config, Task::run, task.get()), rt::RtThreadError::kNone);
  thread.join();
  EXPECT_EQ(task->calls, 0);
  EXPECT_EQ(task->record.execution.count(), 100U);

  const std::array cores = {0, 1};
  rt::MachineDemand demand;
  demand.cores = cores;
  rt::CpuLatencyRequest latency;
  const HeapCounter counter;
  const rt::MachineReport report = rt::check_machine(demand, rt::ask_kernel(80));
  const rt::CpuLatencyError held = latency.hold("/nonexistent/cpu_dma_latency");
  EXPECT_EQ(counter.calls(), 0);
  EXPECT_NE(report.findings[0].detail[0], 0);
  EXPECT_EQ(held, rt::CpuLatencyError::kNoDevice);
}

}  // namespace
}  // namespace vergence
