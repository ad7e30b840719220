// The whole controller on a robot that does what it is told: it follows, stops, and says why.
#include "firmware_like/pipeline.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>
#include <numbers>

#include "algo/trigonometry.hpp"
#include "tests/support/bit_hash.hpp"
#include "tests/support/ideal_robot.hpp"
#include "tests/support/random.hpp"

namespace vergence {
namespace {

using testing::IdealRobot;
using testing::start_of_hand;

// Tens of megabytes each.
std::unique_ptr<IdealRobot> robot(const RobotConfig& config = testing::config_of_robot()) {
  return std::make_unique<IdealRobot>(config);
}

Transform in_hand(double x_mm, double y_mm, double z_mm, const Vector3& e = Vector3::Zero()) {
  return start_of_hand() * to_transform({{x_mm, y_mm, z_mm}, e});
}

TEST(Pipeline, ComesUpStepByStepAndMovesNothingUntilItIsTold) {
  const auto it = robot();
  ASSERT_EQ(it->status, Status::kOk);
  EXPECT_EQ(it->mode(), Mode::kInit);
  it->run(0.2);
  EXPECT_EQ(it->mode(), Mode::kIdle);
  EXPECT_EQ(it->arm.requested(), ArmRequest::kDisable);
  EXPECT_FALSE(it->eyes.is_enabled());
  it->run(1);
  EXPECT_EQ(it->mode(), Mode::kIdle);
  EXPECT_EQ(it->speed_rad_per_s(), 0);
  it->pipeline.command(OperatorCommand::kArm);
  it->run(0.2);
  EXPECT_EQ(it->mode(), Mode::kTrack);  // the target is there, but nobody said that the hand is to follow
  EXPECT_LT(it->speed_rad_per_s(), 1e-9);
  EXPECT_TRUE(it->eyes.is_enabled());
}

TEST(Pipeline, BringsTheHandToItsPlace) {
  const auto it = robot();
  it->target = [](double) { return in_hand(60, -150, 580, {0.05, -0.08, 0.1}); };
  it->start();
  ASSERT_EQ(it->mode(), Mode::kServo);
  EXPECT_GT(it->error_mm(), 50);
  it->run(5);
  EXPECT_LT(it->error_mm(), 0.05);
  const Transform T_H_M = it->T_W_H().inverse() * it->target(0);
  EXPECT_LT(to_pose(T_H_M).e.norm(), 1e-4);
}

TEST(Pipeline, FollowsAMovingTargetWithHandAndEyes) {
  const auto it = robot();
  it->target = [](double t_s) { return in_hand(100 * sin_cos(1.256 * t_s).sine, -100, 545); };
  it->start();
  it->run(4);
  double worst_mm = 0;
  double worst_rad = 0;
  for (int i = 0; i < 5000; ++i) {
    it->tick();
    worst_mm = std::max(worst_mm, it->error_mm());
    // The target on the eyes' axes.
    const RobotConfig config = testing::config_of_robot();
    const Vector3 target_H = it->T_W_H().inverse() * it->target(static_cast<double>(it->t_ns) * 1e-9).t_mm;
    const EyeAngles wanted = desired_eye_angles(config.mount, target_H).value();
    worst_rad = std::max(
        worst_rad, std::abs(wanted.pan_left_rad - static_cast<double>(it->eyes_feedback.steps[2]) / 2546));
  }
  EXPECT_LT(worst_mm, 4);
  EXPECT_LT(worst_rad, 0.004);  // ten steps
}

// At twice the rate it brings the hand as near, stops within as many milliseconds, and breaks no limit.
TEST(Pipeline, FollowsAndStopsAt1kHzAsWell) {
  RobotConfig config = testing::config_of_robot();
  config.arm_period_ns = 1'000'000;
  const auto it = robot(config);
  ASSERT_EQ(it->status, Status::kOk);
  it->target = [](double t_s) { return in_hand(100 * sin_cos(1.256 * t_s).sine, -100, 545); };
  it->start();
  it->run(4);
  ASSERT_EQ(it->mode(), Mode::kServo);
  double worst_mm = 0;
  std::array<double, kMaxJoints> before = it->arm.commanded_rad_per_s();
  for (int i = 0; i < 5000; ++i) {
    it->tick();
    worst_mm = std::max(worst_mm, it->error_mm());
    for (std::size_t joint = 0; joint < kMaxJoints; ++joint) {
      const JointLimits& limits = config.arm.limits[joint];
      const double now = it->arm.commanded_rad_per_s()[joint];
      EXPECT_LE(std::abs(now), limits.velocity_rad_per_s * (1 + 1e-9));
      EXPECT_LE(std::abs(now - before[joint]), limits.acceleration_rad_per_s2 * 1e-3 * (1 + 1e-9));
      before[joint] = now;
    }
  }
  EXPECT_LT(worst_mm, 4);
  it->pipeline.command(OperatorCommand::kStop);
  it->run(2);
  EXPECT_EQ(it->mode(), Mode::kSafeStop);
  EXPECT_EQ(it->arm.requested(), ArmRequest::kDisable);
  EXPECT_EQ(it->speed_rad_per_s(), 0);
}

TEST(Pipeline, LooksFromThePositionAloneWhereThatIsAsked) {
  RobotConfig config = testing::config_of_robot();
  config.relation.position_only = true;
  const auto it = robot(config);
  it->target = [](double) { return in_hand(60, -60, 560, {0.1, 0.2, -0.1}); };
  it->start();
  it->run(5);
  const Transform T_H_M = it->T_W_H().inverse() * it->target(0);
  EXPECT_LT((T_H_M.t_mm - config.relation.T_Ed_M.t_mm).norm(), 0.05);
  EXPECT_LT(to_pose(start_of_hand().inverse() * it->T_W_H()).e.norm(), 1e-4);
}

TEST(Pipeline, StopsBeforeItSwitchesOff) {
  const auto it = robot();
  it->target = [](double t_s) { return in_hand(100 * sin_cos(2 * t_s).sine, -100, 545); };
  it->start();
  it->run(2);
  ASSERT_GT(it->speed_rad_per_s(), 0.05);
  it->pipeline.command(OperatorCommand::kStop);
  it->run(0.004);
  EXPECT_EQ(it->mode(), Mode::kSafeStop);
  EXPECT_EQ(it->arm.requested(), ArmRequest::kEnable);  // torque is what brakes it
  int periods = 0;
  while (it->arm.requested() == ArmRequest::kEnable && periods < 1000) {
    it->run(0.002);
    ++periods;
  }
  int most = 0;
  const SerialArm arm = pa10();
  for (const JointLimits& limits : arm.limits) most = std::max(most, most_brake_periods(limits, 0.002));
  EXPECT_LE(periods, most);
  for (const double v : it->arm.commanded_rad_per_s()) EXPECT_EQ(v, 0);
  it->run(0.1);
  EXPECT_FALSE(it->eyes.is_enabled());
  // Latched: nothing but a reset leaves it.
  it->pipeline.command(OperatorCommand::kArm);
  it->run(0.1);
  EXPECT_EQ(it->mode(), Mode::kSafeStop);
  it->pipeline.command(OperatorCommand::kReset);
  it->run(0.1);
  EXPECT_EQ(it->mode(), Mode::kIdle);
}

TEST(Pipeline, TakesAShoveAndComesBack) {
  const auto it = robot();
  it->start();
  it->run(3);
  for (const std::size_t joint : {1, 2, 3}) {
    it->feedback.position_rad[joint] += 0.03;
    it->run(0.01);
    EXPECT_GT(it->error_mm(), 4);
    it->run(3);
    EXPECT_EQ(it->mode(), Mode::kServo);
    EXPECT_LT(it->error_mm(), 0.05);
  }
  // Nothing of it is left: as many again are no more than one.
  for (int i = 0; i < 10; ++i) {
    it->feedback.position_rad[2] += 0.03;
    it->run(2);
  }
  EXPECT_EQ(it->mode(), Mode::kServo);
  EXPECT_LT(it->error_mm(), 0.05);
}

TEST(Pipeline, PutsTheHeldJointBack) {
  const auto it = robot();
  it->start();
  it->run(1);
  it->feedback.position_rad[0] += 0.05;
  it->run(3);
  EXPECT_NEAR(it->feedback.position_rad[0], 0, 1e-4);
}

struct Trouble {
  const char* name;
  void (*cause)(IdealRobot&);
  Event event;
};

void PrintTo(const Trouble& trouble, std::ostream* out) {
  *out << trouble.name;
}

class PipelineTrouble : public ::testing::TestWithParam<Trouble> {};

INSTANTIATE_TEST_SUITE_P(
    Pipeline, PipelineTrouble,
    ::testing::Values(
        Trouble{"ArmFallsSilent", [](IdealRobot& it) { it.arm_answers = false; }, Event::kDeviceFault},
        Trouble{"DriveFaults", [](IdealRobot& it) { it.feedback.state = ArmState::kFault; },
                Event::kDeviceFault},
        Trouble{"ArmDoesNotObey", [](IdealRobot& it) { it.arm_obeys = false; }, Event::kFollowingError},
        Trouble{"CameraFallsSilent", [](IdealRobot& it) { it.camera_answers = false; }, Event::kDeviceFault},
        Trouble{"MotorFaults", [](IdealRobot& it) { it.eyes_feedback.state = PanTiltState::kFault; },
                Event::kDeviceFault},
        Trouble{"DeadlinesAreMissed", [](IdealRobot& it) { it.pipeline.report_missed_deadlines(3); },
                Event::kDeadlineMissed}),
    [](const auto& of) { return of.param.name; });

TEST_P(PipelineTrouble, EndsInAStop) {
  const auto it = robot();
  it->target = [](double t_s) { return in_hand(140 * sin_cos(2 * t_s).sine, -100, 545); };
  it->start();
  it->run(2);
  ASSERT_EQ(it->mode(), Mode::kServo);
  const std::uint64_t before = it->pipeline.supervisor().changes();
  GetParam().cause(*it);
  it->run(3);
  EXPECT_TRUE(it->mode() == Mode::kSafeStop || it->mode() == Mode::kFault) << to_string(it->mode());
  EXPECT_EQ(it->arm.requested(), ArmRequest::kDisable);
  for (const double v : it->arm.commanded_rad_per_s()) EXPECT_EQ(v, 0);
  bool found = false;
  for (std::uint64_t i = before; i < it->pipeline.supervisor().changes(); ++i) {
    found = found || it->pipeline.supervisor().change(i).event == GetParam().event;
  }
  EXPECT_TRUE(found);
}

TEST(Pipeline, ClearsADrivesFaultWhenItIsReset) {
  const auto it = robot();
  it->start();
  it->run(1);
  it->feedback.state = ArmState::kFault;
  it->fault_clears = false;
  it->run(0.1);
  ASSERT_EQ(it->mode(), Mode::kFault);
  it->pipeline.command(OperatorCommand::kReset);
  it->run(0.1);
  EXPECT_EQ(it->arm.requested(), ArmRequest::kResetFault);
  EXPECT_EQ(it->mode(), Mode::kFault);
  it->run(1);  // the drives do not clear it, so nobody goes on asking
  EXPECT_EQ(it->arm.requested(), ArmRequest::kDisable);
  it->fault_clears = true;
  it->run(0.1);
  EXPECT_EQ(it->mode(), Mode::kFault);
  it->pipeline.command(OperatorCommand::kReset);
  it->run(0.1);
  EXPECT_EQ(it->mode(), Mode::kIdle);
  EXPECT_EQ(it->arm.requested(), ArmRequest::kDisable);
}

TEST(Pipeline, WaitsWhileTheTargetIsGoneAndGoesOnWhenItIsBack) {
  const auto it = robot();
  it->target = [](double t_s) { return in_hand(80 * sin_cos(t_s).sine, -100, 545); };
  it->start();
  it->run(3);
  it->target_there = false;
  it->run(1.5);
  EXPECT_EQ(it->mode(), Mode::kSearch);
  EXPECT_LT(it->speed_rad_per_s(), 1e-3);
  it->target_there = true;
  it->run(3);
  EXPECT_EQ(it->mode(), Mode::kServo);
  EXPECT_LT(it->error_mm(), 4);
}

// A pair that does not come may be one that was lost; a camera that says it is gone is.
TEST(Pipeline, RestsSoonerWhereACameraSaysThatItIsGone) {
  struct GoneCamera {
    static bool take(StereoFrame&) { return false; }
    static CameraState state() { return CameraState::kRestarting; }
  };
  const auto seconds_to_rest = [](IdealRobot& it, bool told) {
    it.target = [](double t_s) { return in_hand(140 * sin_cos(2 * t_s).sine, -100, 545); };
    it.start();
    it.run(2.2);
    EXPECT_EQ(it.mode(), Mode::kServo);
    it.camera_answers = false;
    GoneCamera gone;
    if (told) it.pipeline.step_vision(it.t_ns, gone);
    double t_s = 0;
    for (; t_s < 0.9 && (it.mode() == Mode::kServo || it.speed_rad_per_s() > 1e-3); t_s += 0.01) it.run(0.01);
    EXPECT_EQ(it.mode(), Mode::kSearch);
    return t_s;
  };
  const auto silent = robot();
  const auto told = robot();
  const double believe_s = static_cast<double>(testing::config_of_robot().believe_ns) * 1e-9;
  EXPECT_LT(seconds_to_rest(*told, true), seconds_to_rest(*silent, false) - 0.5 * believe_s);
  told->camera_answers = true;
  told->run(3);
  EXPECT_EQ(told->mode(), Mode::kServo);
  EXPECT_LT(told->error_mm(), 8);
}

// Drives that take longer than the model has it: what they are off by then is not made up for once there is
// no place to be.
TEST(Pipeline, DoesNotCreepOnWhereTheTargetIsGone) {
  const auto it = robot();
  it->lag_periods = 32;
  it->target = [](double t_s) { return in_hand(140 * sin_cos(2 * t_s).sine, -100, 545); };
  it->start();
  it->run(2.2);
  ASSERT_EQ(it->mode(), Mode::kServo);
  it->target_there = false;
  it->run(0.34);
  for (int look = 0; look < 50; ++look) {
    it->run(0.01);
    EXPECT_LT(it->speed_rad_per_s(), 1e-3) << look;
  }
}

TEST(Pipeline, ActsOnASightingFromItsReleaseOn) {
  const auto it = robot();
  it->start();
  it->run(1);
  const Transform before = it->pipeline.arm_period().target.T_W_M;
  it->camera_answers = false;
  Sighting sighting = it->pipeline.sighting();
  ++sighting.sequence;
  sighting.stamp_ns = it->t_ns;
  sighting.valid_from_ns = it->t_ns + 33'000'000;
  sighting.T_H_M.t_mm[0] += 2;
  it->pipeline.put_sighting(it->t_ns, sighting);
  const auto moved_mm = [&] { return (it->pipeline.arm_period().target.T_W_M.t_mm - before.t_mm).norm(); };
  it->run(0.031);
  EXPECT_LT(moved_mm(), 1e-9);
  it->run(0.004);
  EXPECT_GT(moved_mm(), 0.1);
  EXPECT_EQ(it->pipeline.belief().late(), 0U);
}

TEST(Pipeline, CountsSightingsThatComeAfterTheirRelease) {
  const auto it = robot();
  it->start();
  it->run(1);
  EXPECT_EQ(it->pipeline.belief().late(), 0U);
  it->late_ns = 5'000'000;
  it->run(1);
  EXPECT_GE(it->pipeline.belief().late(), 29U);
  EXPECT_EQ(it->mode(), Mode::kServo);  // late ones are better than none
}

TEST(Pipeline, FindsInItsSelfTestWhatIsWrong) {
  const auto finding = [](const std::function<void(IdealRobot&)>& spoil,
                          RobotConfig config = testing::config_of_robot()) {
    const auto it = robot(config);
    spoil(*it);
    it->run(0.2);
    EXPECT_EQ(it->mode(), Mode::kFault);
    it->pipeline.command(OperatorCommand::kArm);
    it->run(0.1);
    EXPECT_EQ(it->mode(), Mode::kFault);
    return it->pipeline.self_test_result();
  };
  SelfTestResult result = finding([](IdealRobot& it) { it.feedback.position_rad[3] = 2.6; });
  EXPECT_EQ(result.finding, SelfTestFinding::kJointBeyondLimits);
  EXPECT_EQ(result.index, 4);
  result = finding([](IdealRobot& it) { it.feedback.position_rad[1] = std::nan(""); });
  EXPECT_EQ(result.finding, SelfTestFinding::kJointNotFinite);
  EXPECT_EQ(result.index, 2);
  RobotConfig narrow = testing::config_of_robot();
  narrow.hand_limits.box_min_mm[2] = 500;  // the hand is at 485
  EXPECT_EQ(finding([](IdealRobot&) {}, narrow).finding, SelfTestFinding::kToolOutsideBox);
}

TEST(Pipeline, RefusesConfigurationsThatCannotWork) {
  const auto refused = [](const std::function<void(RobotConfig&)>& spoil) {
    RobotConfig config = testing::config_of_robot();
    spoil(config);
    const auto pipeline = std::make_unique<Pipeline>();
    return pipeline->configure_given(config) != Status::kOk;
  };
  EXPECT_FALSE(refused([](RobotConfig&) {}));
  EXPECT_TRUE(refused([](RobotConfig& c) { c.arm.joints = 0; }));
  EXPECT_TRUE(refused([](RobotConfig& c) { c.gains.position_per_s = -1; }));
  EXPECT_TRUE(refused([](RobotConfig& c) { c.hand_limits.linear_velocity_mm_per_s = 0; }));
  EXPECT_TRUE(refused([](RobotConfig& c) { c.following_error_rad = 0; }));
  EXPECT_TRUE(refused([](RobotConfig& c) { c.joint_servo.position_per_s = 600; }));
  EXPECT_TRUE(refused([](RobotConfig& c) { c.tool_mm[1] = std::nan(""); }));
  EXPECT_TRUE(refused([](RobotConfig& c) { c.eye_control.steps_per_rad[1] = 0; }));
  EXPECT_TRUE(refused([](RobotConfig& c) { c.target_motion.position_noise_mm = 0; }));
}

// Whatever the target does and the operator wants.
TEST(Pipeline, NeverSendsAJointBeyondItsLimits) {
  for (const std::uint64_t seed : {1, 2, 3, 4}) {
    testing::Random random(seed);
    const auto it = robot();
    Vector3 at(0, -100, 545);
    Vector3 e = Vector3::Zero();
    it->target = [&](double) { return in_hand(at[0], at[1], at[2], e); };
    it->start();
    std::array<double, kMaxJoints> last{};
    std::array<double, kMaxJoints> last_step{};
    double fastest = 0;
    const SerialArm arm = pa10();
    for (int i = 0; i < 5000; ++i) {
      if (random.below(200) == 0) {
        at = {random.between(-300, 300), random.between(-300, 100), random.between(300, 800)};
        e = {random.between(-0.4, 0.4), random.between(-0.4, 0.4), random.between(-0.4, 0.4)};
      }
      // An operator with an unsteady hand, who puts right what he has stopped.
      if (random.below(900) == 0) {
        it->pipeline.command(random.below(2) == 0 ? OperatorCommand::kHold : OperatorCommand::kStop);
      } else if (random.below(100) == 0) {
        it->pipeline.command(it->mode() == Mode::kSafeStop || it->mode() == Mode::kFault
                                 ? OperatorCommand::kReset
                             : it->mode() == Mode::kIdle ? OperatorCommand::kArm
                                                         : OperatorCommand::kServo);
      }
      it->tick();
      it->tick();
      if (it->feedback.state != ArmState::kEnabled) {
        last = {};
        last_step = {};
        continue;
      }
      const auto& sent = it->arm.commanded_rad_per_s();
      for (std::size_t k = 0; k < kMaxJoints; ++k) {
        const JointLimits& limits = arm.limits[k];
        const double step = sent[k] - last[k];
        ASSERT_LE(std::abs(sent[k]), limits.velocity_rad_per_s * (1 + 1e-9));
        ASSERT_LE(std::abs(step), limits.acceleration_rad_per_s2 * 0.002 * (1 + 1e-9));
        ASSERT_LE(std::abs(step - last_step[k]), limits.jerk_rad_per_s3 * 4e-6 * (1 + 1e-9));
        ASSERT_GE(it->feedback.position_rad[k], limits.min_rad - 1e-4);
        ASSERT_LE(it->feedback.position_rad[k], limits.max_rad + 1e-4);
        last[k] = sent[k];
        last_step[k] = step;
        fastest = std::max(fastest, std::abs(sent[k]));
      }
      const Vector3 hand = it->T_W_H().t_mm;
      const HandLimits box = testing::config_of_robot().hand_limits;
      ASSERT_TRUE((hand.array() > box.box_min_mm.array() - 1).all()) << hand.transpose();
      ASSERT_TRUE((hand.array() < box.box_max_mm.array() + 1).all()) << hand.transpose();
    }
    EXPECT_GT(fastest, 0.5) << seed;
  }
}

// One number proves behaviour unchanged, on x86-64 and on arm64.
TEST(Pipeline, KeepsItsBits) {
  const auto it = robot();
  it->target = [](double t_s) {
    return in_hand(80 * sin_cos(1.5 * t_s).sine, -100 + 30 * sin_cos(t_s).sine, 545,
                   {0, 0.1 * sin_cos(2 * t_s).sine, 0});
  };
  testing::BitHash hash;
  it->start();
  for (int i = 0; i < 2000; ++i) {
    it->tick();
    for (const double v : it->arm.commanded_rad_per_s()) hash.add(v);
    for (const double v : it->eyes.commanded_steps_per_s()) hash.add(v);
  }
  EXPECT_EQ(hash.value(), 0x1CBD69773833A950ULL)
      << "0x" << std::hex << std::uppercase << hash.value() << "ULL";
}

}  // namespace
}  // namespace vergence
