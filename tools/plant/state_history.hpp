// Where hand and eyes were: the pictures are made when they are delivered, of what was there while they were
// exposed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "algo/eye_mount.hpp"
#include "algo/pose.hpp"

namespace vergence::plant {

struct HeadState {
  Transform T_W_H;
  EyeAngles eyes;
};

class StateHistory {
 public:
  // Samples at 0, interval, 2 * interval ...; the last `capacity` of them are kept.
  StateHistory(std::int64_t interval_ns, std::size_t capacity);

  void push(const HeadState& state);

  // Exact at samples; between them in a straight line, turning about one axis. Before time zero all was as at
  // zero. Throws std::out_of_range where it is no longer known or not yet.
  [[nodiscard]] HeadState at(std::int64_t t_ns) const;

 private:
  std::int64_t interval_ns_;
  std::vector<HeadState> ring_;
  std::int64_t pushed_ = 0;
};

}  // namespace vergence::plant
