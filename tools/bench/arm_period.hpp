// What the arm task calculates each period while it servos, over made-up motions of arm and target.
#pragma once

#include <cstdint>

#include "firmware_like/hand_task.hpp"

namespace vergence::tools {

class ArmPeriod {
 public:
  // Throws std::logic_error where the default robot is refused.
  ArmPeriod();

  // Answers the sum of what the joints would be sent, so that nothing is left out.
  double run(std::int64_t now_ns);

 private:
  HandTask hand_;
  ArmFeedback feedback_;
  std::array<double, kMaxJoints> middle_rad_{};
  TargetState target_;
};

}  // namespace vergence::tools
