// The time offset with known truth: exact, with noise, and where it must refuse.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "algo/rotation_vector.hpp"
#include "tests/support/chessboard.hpp"
#include "tests/support/small_dataset.hpp"
#include "tools/calibrate/frame_poses.hpp"
#include "tools/calibrate/pose_track.hpp"
#include "tools/calibrate/slopes.hpp"
#include "tools/calibrate/time_offset.hpp"
#include "tools/io/input_error.hpp"

namespace vergence::test {
namespace {

using calibrate::TimedPose;
using tools::InputError;

constexpr double kDegree = std::numbers::pi / 180;

struct Noise {
  double x_mm = 0;
  double z_mm = 0;
  double deg = 0;
};

// A hand that sways in sums of sines, and a target 550 mm ahead.
struct Motion {
  double speed = 1;       // of the sway
  bool periodic = false;  // one sine alone
  double duration_s = 20;

  [[nodiscard]] Transform hand_at(double t_s) const {
    const auto wave = [&](double rad_per_s, double phase) {
      return std::sin(speed * rad_per_s * t_s + phase);
    };
    const double second = periodic ? 0 : 1;
    Vector6 d;
    d << 60 * wave(2.1, 0) + second * 40 * wave(3.7, 1), 50 * wave(2.1, 2) + second * 30 * wave(4.3, 0.5),
        second * 40 * wave(1.3, 0), 0.08 * wave(2.1, 1) + second * 0.05 * wave(3.1, 0),
        second * 0.08 * wave(2.6, 2), 0.05 * wave(2.1, 0.3);
    return calibrate::moved({turn_deg(150, {1, 0.2, 0}), {500, 0, 800}}, d);
  }

  [[nodiscard]] std::vector<TimedPose> hand(double rate_hz = 250) const {
    std::vector<TimedPose> poses;
    for (int i = 0; i / rate_hz < duration_s; ++i) poses.push_back({i / rate_hz, hand_at(i / rate_hz)});
    return poses;
  }

  // Pictures at 30 a second, with stamps that lack `offset_s`.
  [[nodiscard]] std::vector<TimedPose> frames(double offset_s, const Noise& noise, std::uint64_t seed) const {
    testing::Random random(seed);
    const Transform T_W_M = hand_at(0) * Transform{turn_deg(5, {1, 1, 0}), {10, -20, 550}};
    std::vector<TimedPose> poses;
    for (int i = 0; i / 30.0 < duration_s; ++i) {
      const double t_s = i / 30.0;
      Transform T_H_M = hand_at(t_s).inverse() * T_W_M;
      T_H_M.t_mm += Vector3(noise.x_mm, noise.x_mm, noise.z_mm).cwiseProduct(normal3(random));
      T_H_M.R = T_H_M.R * rotation_from_vector(noise.deg * kDegree * normal3(random));
      poses.push_back({t_s - offset_s, T_H_M});
    }
    return poses;
  }
};

calibrate::TimeOffset offset_of(const std::vector<TimedPose>& frames, const std::vector<TimedPose>& hand,
                                double range_ms = 200) {
  return find_time_offset({"frames.csv", "hand.csv"}, frames, hand, range_ms);
}

template <class Call>
std::string refusal(Call&& call) {
  try {
    call();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(CalibrateTimeOffset, IsExactOnExactPoses) {
  const Motion motion;
  for (const double offset_ms : {-63.21, 0.0, 8.4, 142.0}) {
    const auto result = offset_of(motion.frames(1e-3 * offset_ms, {}, 1), motion.hand());
    EXPECT_NEAR(result.offset_ms, offset_ms, 0.01);
    EXPECT_LT(result.half_width_ms, 0.01);
    EXPECT_LT(result.after_mm, 0.01);
  }
}

// As a tracker sees: 0.3 mm across, 1.5 mm along, 0.2 deg.
TEST(CalibrateTimeOffset, IsWithinItsIntervalOnNoise) {
  const Motion motion;
  constexpr int kRuns = 20;
  int within = 0;
  for (int run = 0; run < kRuns; ++run) {
    const double offset_ms = -30 + 3.3 * run;
    const auto result =
        offset_of(motion.frames(1e-3 * offset_ms, {0.3, 1.5, 0.2}, static_cast<std::uint64_t>(run)),
                  motion.hand(), 100);
    EXPECT_NEAR(result.offset_ms, offset_ms, 0.5);
    EXPECT_LT(result.half_width_ms, 0.5);
    within += std::abs(result.offset_ms - offset_ms) < result.half_width_ms ? 1 : 0;
  }
  EXPECT_GE(within, 17);  // of 20; 19 are expected, and by chance fewer than 17 in one of sixty tries
}

TEST(CalibrateTimeOffset, BearsFramesThatAreFarOff) {
  const Motion motion;
  auto frames = motion.frames(0.012, {0.3, 1.5, 0.2}, 1);
  for (std::size_t i = 10; i < frames.size(); i += 40) frames[i].T.t_mm.x() += 70;
  const auto result = offset_of(frames, motion.hand());
  EXPECT_NEAR(result.offset_ms, 12, 0.5);
  EXPECT_GE(result.left_out, 14U);
}

TEST(CalibrateTimeOffset, SaysHowFarTheTargetWandered) {
  const Motion motion;
  const auto result = offset_of(motion.frames(0.050, {0.1, 0.1, 0.01}, 1), motion.hand());
  EXPECT_NEAR(result.after_mm, 0.1 * std::sqrt(3.0), 0.03);
  EXPECT_NEAR(result.before_mm, 0.050 * result.speed_mm_per_s, 0.2 * 0.050 * result.speed_mm_per_s);
}

TEST(CalibrateTimeOffset, RefusesAMotionThatIsTooSlow) {
  Motion motion;
  motion.speed = 0.03;
  const std::string message = refusal([&] {
    (void)offset_of(motion.frames(0.01, {0.3, 1.5, 0.2}, 1), motion.hand());
  });
  EXPECT_NE(message.find("hand.csv: the motion is too slow"), std::string::npos) << message;
  motion.speed = 0;
  const std::string still = refusal([&] {
    (void)offset_of(motion.frames(0.01, {0.3, 1.5, 0.2}, 1), motion.hand());
  });
  EXPECT_NE(still.find("too slow"), std::string::npos) << still;
}

TEST(CalibrateTimeOffset, RefusesAMotionThatRepeatsItself) {
  Motion motion;
  motion.periodic = true;
  motion.speed = 12;  // a period of 0.25 s
  const std::string message = refusal([&] {
    (void)offset_of(motion.frames(0.01, {0.3, 1.5, 0.2}, 1), motion.hand(1000), 400);
  });
  EXPECT_NE(message.find("repeats itself"), std::string::npos) << message;
  EXPECT_EQ(refusal([&] {
              (void)offset_of(motion.frames(0.01, {0.3, 1.5, 0.2}, 1), motion.hand(1000), 100);
            }),
            "");
}

TEST(CalibrateTimeOffset, RefusesWhatIsBeyondTheRange) {
  const Motion motion;
  const std::string message = refusal([&] { (void)offset_of(motion.frames(0.1, {}, 1), motion.hand(), 50); });
  EXPECT_NE(message.find("no offset within 50 ms"), std::string::npos) << message;
}

TEST(CalibrateTimeOffset, RefusesTablesThatHardlyOverlap) {
  const Motion motion;
  auto frames = motion.frames(0, {}, 1);
  for (TimedPose& frame : frames) frame.t_s += 1000;
  const std::string message = refusal([&] { (void)offset_of(frames, motion.hand()); });
  EXPECT_NE(message.find("frames.csv: t_s: 0 of 600 frames"), std::string::npos) << message;
}

TEST(CalibratePoseTrack, GoesThroughItsPosesAndStopsAtGaps) {
  const Motion motion;
  std::vector<TimedPose> poses = motion.hand(50);
  const calibrate::PoseTrack track(poses);
  EXPECT_LT((track.at(poses[7].t_s)->t_mm - poses[7].T.t_mm).norm(), 1e-9);
  EXPECT_LT((track.at(1.013)->t_mm - motion.hand_at(1.013).t_mm).norm(), 0.01);
  EXPECT_FALSE(track.at(-0.01));
  EXPECT_FALSE(track.at(20));
  poses.erase(poses.begin() + 100, poses.begin() + 120);
  const calibrate::PoseTrack broken(poses);
  EXPECT_FALSE(broken.at(2.2));
  EXPECT_LT((broken.at(1.975)->t_mm - motion.hand_at(1.975).t_mm).norm(), 0.2);
}

constexpr const char* kLine =
    R"({"frame":3,"t_s":0.1,"pose":{"x_mm":1,"y_mm":2,"z_mm":3,"e1":0,"e2":0,"e3":0.5},"state":"tracking"})";

TEST(CalibrateFramePoses, AreReadFromLinesWithStampsOfTheirOwn) {
  const TempDirectory directory;
  write_file(directory / "frames.jsonl", std::string(kLine) + "\n" + R"({"frame":4,"state":"lost"})" + "\n");
  auto frames = calibrate::read_frame_poses(directory.path());
  ASSERT_EQ(frames.poses.size(), 1U);
  EXPECT_EQ(frames.poses[0].t_s, 0.1);
  EXPECT_EQ(frames.poses[0].T.t_mm, Vector3(1, 2, 3));
  write_file(directory / "stamps.csv", "frame,t_s\n3,7.25\n");
  EXPECT_EQ(calibrate::read_frame_poses(directory.path()).poses[0].t_s, 7.25);
  write_file(directory / "stamps.csv", "frame,t_s\n4,7.25\n");
  EXPECT_NE(refusal([&] { (void)calibrate::read_frame_poses(directory.path()); }).find("no row for frame 3"),
            std::string::npos);
}

TEST(CalibrateFramePoses, ThatAreBadAreRefused) {
  const TempDirectory directory;
  const auto complaint = [&](const std::string& lines) {
    write_file(directory / "frames.jsonl", lines);
    return refusal([&] { (void)calibrate::read_frame_poses(directory.path()); });
  };
  EXPECT_NE(
      refusal([&] { (void)calibrate::read_frame_poses(directory.path()); }).find("frames.csv: no such file"),
      std::string::npos);
  EXPECT_NE(complaint("text").find("line 1: is no JSON object"), std::string::npos);
  EXPECT_NE(complaint("{}").find("line 1: state"), std::string::npos);
  EXPECT_NE(complaint(R"({"state":"tracking"})").find("line 1: t_s"), std::string::npos);
  EXPECT_NE(complaint(R"({"state":"tracking","t_s":0})").find("line 1: x_mm"), std::string::npos);
  EXPECT_NE(complaint(R"({"state":"lost"})").find("no frame was tracked"), std::string::npos);
  EXPECT_NE(complaint(std::string(kLine) + "\n" + kLine).find("line 2: t_s"), std::string::npos);
}

}  // namespace
}  // namespace vergence::test
