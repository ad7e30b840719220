#include "tools/bench/arm_period.hpp"

#include <cmath>
#include <stdexcept>

#include "firmware_like/task_table.hpp"
#include "hal/clock.hpp"

namespace vergence::tools {

ArmPeriod::ArmPeriod() {
  RobotConfig config;
  config.relation.T_Ed_M.t_mm = {0, -100, 545};
  if (hand_.configure(config, seconds(task(TaskId::kArm).period_ns)) != Status::kOk) {
    throw std::logic_error("the default robot is not valid");
  }
  Transform start;  // the hand before the arm, looking along -x
  start.R << 0, 0, -1, 1, 0, 0, 0, -1, 0;
  start.t_mm = {-690, 0, 485};
  const Pa10Inverse inverse = inverse_pa10(config.arm, start, JointVector::Zero());
  const auto solution = nearest_solution(config.arm, inverse, JointVector::Zero());
  if (!solution) throw std::logic_error("the default robot does not reach its start");
  for (std::size_t i = 0; i < middle_rad_.size(); ++i) {
    middle_rad_[i] = (*solution)[static_cast<Eigen::Index>(i)];
  }
  target_.T_W_M = start * config.relation.T_Ed_M;
  feedback_.state = ArmState::kEnabled;
}

double ArmPeriod::run(std::int64_t now_ns) {
  constexpr double kSwing_rad = 0.02;
  const double phase = std::fmod(seconds(now_ns), 6.283185307179586);
  feedback_.stamp_ns = now_ns;
  for (std::size_t i = 0; i < middle_rad_.size(); ++i) {
    feedback_.position_rad[i] = middle_rad_[i] + kSwing_rad * std::sin(phase + static_cast<double>(i));
    feedback_.velocity_rad_per_s[i] = kSwing_rad * std::cos(phase + static_cast<double>(i));
  }
  const HandPeriod period =
      hand_.step(now_ns, Mode::kServo, feedback_, true, [this](std::int64_t) { return target_; });
  double sum = 0;
  for (const double velocity : period.velocity_rad_per_s) sum += velocity;
  return sum;
}

}  // namespace vergence::tools
