// What the controller holds true of the target: sightings act from their release on, not before, and bear the
// belief for a while.
#pragma once

#include <cstdint>

#include "algo/target_motion.hpp"
#include "firmware_like/messages.hpp"
#include "firmware_like/robot_config.hpp"

namespace vergence {

class TargetBelief {
 public:
  [[nodiscard]] Status configure(const RobotConfig& config);

  // A sighting as vision makes it, ahead of its release as a rule.
  void put(const Sighting& sighting);

  // To be called each period: takes in what is released by now.
  void step(std::int64_t now_ns);

  // There is no seeing it for now: nothing is believed until the next sighting that is put.
  void lose();

  // Whether there is a target to act on.
  [[nodiscard]] bool is_believed(std::int64_t now_ns) const;

  // Where it is at an instant; only while it is believed.
  [[nodiscard]] TargetState at(std::int64_t t_ns) const { return motion_.at(t_ns); }

  // Sightings that came after their release: each is a period in which the target was guessed for longer.
  [[nodiscard]] std::uint64_t late() const { return late_; }
  // In a row, up to the last one.
  [[nodiscard]] int late_in_a_row() const { return late_in_a_row_; }

 private:
  void take(const Sighting& sighting);
  void forget();

  std::int64_t believe_ns_ = 0;
  double least_confidence_ = 0;
  TargetMotion motion_;
  Sighting waiting_;
  bool is_waiting_ = false;
  bool seen_ = false;
  std::int64_t seen_ns_ = 0;
  std::int64_t now_ns_ = 0;
  std::uint64_t late_ = 0;
  int late_in_a_row_ = 0;
};

}  // namespace vergence
