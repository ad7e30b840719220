// The hand's loop closed: a drive that follows with a lag, targets seen late and with noise.
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <deque>
#include <numbers>

#include "algo/arm_kinematics.hpp"
#include "algo/hand_servo.hpp"
#include "algo/rotation_vector.hpp"
#include "tests/support/random.hpp"
#include "tests/support/random_arm.hpp"

namespace vergence {
namespace {

using testing::Random;
using testing::RandomArm;

constexpr double kPeriod_s = 0.002;
constexpr std::int64_t kPeriod_ns = 2'000'000;
constexpr double kLag_s = 0.02;
constexpr std::int64_t kLag_ns = 20'000'000;

double seconds(std::int64_t t_ns) {
  return static_cast<double>(t_ns) * 1e-9;
}

// A hand that takes the velocity asked for with a first-order lag; without one, at once.
struct Hand {
  Transform T_W_E;
  Twist velocity;
  double lag_s = kLag_s;

  void move(const Twist& asked) {
    const double share = lag_s > 0 ? 1 - std::exp(-kPeriod_s / lag_s) : 1;
    velocity.linear_mm_per_s += share * (asked.linear_mm_per_s - velocity.linear_mm_per_s);
    velocity.angular_rad_per_s += share * (asked.angular_rad_per_s - velocity.angular_rad_per_s);
    T_W_E.t_mm += velocity.linear_mm_per_s * kPeriod_s;
    T_W_E.R = rotation_from_vector(velocity.angular_rad_per_s * kPeriod_s) * T_W_E.R;
  }
};

// Positions fall as exp(-K t / (1 + K_VP)), and since e is the sine of half the angle, tan(angle / 4) as
// exp(-K t / 2 / (1 + K_VO)).
TEST(HandServoLoop, ConvergesAsTheGainsSay) {
  for (const HandGains& gains : {thesis_gains(), vergence_gains()}) {
    for (const double lag_s : {0.0, kLag_s}) {
      double worst_position = 0;
      double worst_angle = 0;
      ASSERT_TRUE(rc::check([&] {
        RandomArm random(*rc::gen::arbitrary<std::uint64_t>());
        TargetState target;
        target.T_W_M = random.transform(600);
        const DesiredRelation relation{random.transform(600), {}, false};
        Hand hand{random.transform(600), {}, lag_s};
        const Twist none;
        const HandError start = hand_error(hand.T_W_E, none, target, relation);
        const double start_quarter = std::tan(std::asin(std::min(start.e.norm(), 1.0)) / 2);
        const double rate = gains.position_per_s / (1 + gains.position_rate);
        const double turn_rate = gains.orientation_per_s / 2 / (1 + gains.orientation_rate);
        const int periods = static_cast<int>(3 / rate / kPeriod_s);
        for (int i = 1; i <= periods; ++i) {
          const HandError error = hand_error(hand.T_W_E, hand.velocity, target, relation);
          hand.move(hand_twist(gains, error, desired_hand_velocity(hand.T_W_E, target, relation)));
          const HandError now = hand_error(hand.T_W_E, hand.velocity, target, relation);
          const double t_s = i * kPeriod_s;
          const double position = now.position_mm.norm() / start.position_mm.norm();
          const double quarter = std::tan(std::asin(std::min(now.e.norm(), 1.0)) / 2);
          const double off = std::fabs(position - std::exp(-rate * t_s));
          const double off_angle = std::fabs(quarter - start_quarter * std::exp(-turn_rate * t_s));
          worst_position = std::max(worst_position, off);
          worst_angle = std::max(worst_angle, off_angle);
        }
      }));
      std::printf("K %.1f, lag %.0f ms: off exp by at most %.4f of the start, tan(angle/4) by %.4f\n",
                  gains.position_per_s, lag_s * 1000, worst_position, worst_angle);
      // What the lag and the period hold up.
      const double most = gains.position_per_s * (lag_s + kPeriod_s);
      EXPECT_LT(worst_position, most);
      EXPECT_LT(worst_angle, most);
    }
  }
}

struct Response {
  double gain_db = 0;
  double phase_deg = 0;
  double rest_rms = 0;  // of what is not the fitted sine: mm or rad
};

struct Course {
  HandGains gains;
  double amplitude = 150;  // mm; along with it a turn of a thousandth of it in rad
  double w = 1.256;
  double noise = 0;          // mm, and a hundredth of it in rad
  double latency_s = 0.033;  // of a frame
  TargetMotionOptions options;
  bool lead = true;
};

struct Both {
  Response position, turn;
};

// The target swings along y and turns about z, seen at 30 fps through the filter, the hand keeps 500 mm
// before it. Fitted over whole turns.
Both respond(const Course& course) {
  Random random(3);
  TargetMotion motion;
  EXPECT_EQ(motion.configure(course.options), Status::kOk);
  const auto truth = [&](double t_s) {
    const double s = std::sin(course.w * t_s);
    return Transform{rotation_from_vector({0, 0, 1e-3 * course.amplitude * s}), {0, course.amplitude * s, 0}};
  };
  const DesiredRelation relation{{Matrix3::Identity(), {0, 0, 500}}, {}, false};
  Hand hand{{Matrix3::Identity(), {0, 0, -500}}, {}, kLag_s};
  struct Frame {
    std::int64_t stamp_ns;
    Transform T_W_M;
  };
  std::deque<Frame> under_way;
  const double turn_s = 2 * std::numbers::pi / course.w;
  const double settle_s = std::ceil(20 / turn_s) * turn_s;
  const double fit_s = std::ceil(20 / turn_s) * turn_s;
  double n = 0;
  Vector2 sine = Vector2::Zero();
  Vector2 cosine = Vector2::Zero();
  Vector2 squares = Vector2::Zero();
  std::int64_t frame = 0;
  for (std::int64_t now_ns = 0; seconds(now_ns) < settle_s + fit_s; now_ns += kPeriod_ns) {
    const double now_s = seconds(now_ns);
    if (now_ns >= frame * 33'333'333) {
      ++frame;
      Transform seen = truth(now_s);
      const auto spread = [&] { return course.noise * std::sqrt(3.0) * random.between(-1, 1); };
      for (int i = 0; i < 3; ++i) seen.t_mm[i] += spread();
      Vector3 off = Vector3::Zero();
      for (int i = 0; i < 3; ++i) off[i] = 0.01 * spread();
      seen.R = rotation_from_vector(off) * seen.R;
      under_way.push_back({now_ns, seen});
    }
    while (!under_way.empty() && now_s - seconds(under_way.front().stamp_ns) >= course.latency_s) {
      EXPECT_TRUE(motion.observe(under_way.front().stamp_ns, under_way.front().T_W_M));
      under_way.pop_front();
    }
    if (motion.known()) {
      const HandError error = hand_error(hand.T_W_E, hand.velocity, motion.at(now_ns), relation);
      const Twist ahead =
          desired_hand_velocity(hand.T_W_E, motion.at(now_ns + (course.lead ? kLag_ns : 0)), relation);
      hand.move(hand_twist(course.gains, error, ahead));
    }
    if (now_s < settle_s) continue;
    const double t_s = now_s + kPeriod_s;
    const Vector2 x{hand.T_W_E.t_mm[1], vector_from_rotation(hand.T_W_E.R)[2]};
    sine += x * std::sin(course.w * t_s);
    cosine += x * std::cos(course.w * t_s);
    squares += x.cwiseProduct(x);
    ++n;
  }
  sine *= 2 / n;
  cosine *= 2 / n;
  const auto response = [&](int i, double amplitude) {
    const double found = std::hypot(sine[i], cosine[i]);
    return Response{20 * std::log10(found / amplitude),
                    std::atan2(cosine[i], sine[i]) * 180 / std::numbers::pi,
                    std::sqrt(std::max(squares[i] / n - found * found / 2, 0.0))};
  };
  const Both both{response(0, course.amplitude), response(1, 1e-3 * course.amplitude)};
  std::printf(
      "K %.1f, FF %.0f, lead %d, %3.0f mm at %.3f rad/s, noise %.1f: %+.2f dB %+.1f deg, turn %+.2f dB "
      "%+.1f deg; rest %.2f mm, %.4f rad\n",
      course.gains.position_per_s, course.gains.feed_forward, course.lead ? 1 : 0, course.amplitude, course.w,
      course.noise, both.position.gain_db, both.position.phase_deg, both.turn.gain_db, both.turn.phase_deg,
      both.position.rest_rms, both.turn.rest_rms);
  return both;
}

Course with(const HandGains& gains, double w) {
  Course course;
  course.gains = gains;
  course.w = w;
  if (w > 2) {
    // Quick targets want a quick filter, as the configuration would say.
    course.amplitude = 30;
    course.options.jerk_mm_per_s3 = 3000;
    course.options.angular_jerk_rad_per_s3 = 30;
  }
  return course;
}

TEST(HandServoLoop, FeedForwardTakesTheLagAway) {
  for (const double noise : {0.0, 0.3}) {
    for (const double w : {0.2, 0.628, 1.256, 3.0, 6.0}) {
      Course course = with(vergence_gains(), w);
      course.noise = noise;
      const Both both = respond(course);
      for (const Response& response : {both.position, both.turn}) {
        EXPECT_LT(std::fabs(response.phase_deg), w < 2 ? 1 : 5) << w;
        EXPECT_LT(std::fabs(response.gain_db), w < 4 ? 0.6 : 2.5) << w;
      }
      EXPECT_LT(both.position.rest_rms, noise > 0 ? 3 : 0.3) << w;
      EXPECT_LT(both.turn.rest_rms, noise > 0 ? 0.006 : 0.0003) << w;
    }
  }
}

// What quicker gains would cost and give.
TEST(HandServoLoop, NoiseGrowsWithTheGain) {
  double last_mm = 0;
  for (const double K : {1.0, 3.0, 8.0}) {
    Course course = with({K, 0, 2 * K, 0, 1}, 1.256);
    course.noise = 0.3;
    const Both both = respond(course);
    EXPECT_GT(both.position.rest_rms, last_mm);
    last_mm = both.position.rest_rms;
  }
}

// As late as the drive, where the velocity fed forward is the present one.
TEST(HandServoLoop, TheLeadMakesUpForTheDrive) {
  Course course = with(vergence_gains(), 3);
  const Both led = respond(course);
  course.lead = false;
  const Both late = respond(course);
  EXPECT_LT(late.position.phase_deg, led.position.phase_deg - 0.5);
  EXPECT_LT(late.turn.phase_deg, led.turn.phase_deg - 0.5);
}

// (K_PP + K_VP s) / (K_PP + (1 + K_VP) s): -3 dB at 0.367 rad/s; half of K_PO counts.
TEST(HandServoLoop, ThesisGainsBreakBelowHalfARadian) {
  const auto expected_db = [](double k, double w) {
    return 10 * std::log10((k * k + 0.01 * w * w) / (k * k + 1.21 * w * w));
  };
  for (const double w : {0.1, 0.2, 0.367, 0.4, 0.628}) {
    const Both both = respond(with(thesis_gains(), w));
    EXPECT_NEAR(both.position.gain_db, expected_db(0.4, w), 0.2) << w;
    EXPECT_NEAR(both.turn.gain_db, expected_db(0.2, w), 0.3) << w;
    EXPECT_LT(both.position.phase_deg, -10) << w;
    EXPECT_EQ(both.position.gain_db < -3, w >= 0.4) << w;
  }
}

TEST(HandServoLoop, PositionOnlyFollowsWithoutTurning) {
  RandomArm random(8);
  TargetState target;
  target.T_W_M = random.transform(600);
  target.velocity.linear_mm_per_s = Vector3(40, -30, 10);
  target.velocity.angular_rad_per_s = Vector3(0.4, 1, -0.3);
  const DesiredRelation relation{{Matrix3::Identity(), {0, 0, 600}}, {}, true};
  Hand hand{random.transform(600), {}, kLag_s};
  const Matrix3 R = hand.T_W_E.R;
  for (int i = 0; i < 3000; ++i) {
    const HandError error = hand_error(hand.T_W_E, hand.velocity, target, relation);
    hand.move(hand_twist(vergence_gains(), error, desired_hand_velocity(hand.T_W_E, target, relation)));
    target.T_W_M.t_mm += target.velocity.linear_mm_per_s * kPeriod_s;
    target.T_W_M.R = rotation_from_vector(target.velocity.angular_rad_per_s * kPeriod_s) * target.T_W_M.R;
  }
  EXPECT_EQ(hand.T_W_E.R, R);
  EXPECT_LT((hand.T_W_E.inverse() * target.T_W_M.t_mm - Vector3(0, 0, 600)).norm(), 1e-3);
}

}  // namespace
}  // namespace vergence
