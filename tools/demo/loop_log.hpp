// What a run of the closed loop leaves: a row each hundredth of a second. Poses are in S, the hand's frame at
// the start, as the thesis has its figures: x right, y down, z ahead.
#pragma once

#include <optional>

#include "firmware_like/pipeline.hpp"
#include "tools/plant/world.hpp"
#include "tools/report/log_table.hpp"

namespace vergence::demo {

// A frame that vision has looked at since the last row.
struct SeenFrame {
  Sighting sighting;
  Transform true_T_H_M;  // when it was exposed
};

class LoopLog {
 public:
  LoopLog();

  void add(const plant::World& world, const Pipeline& pipeline, const Transform& T_W_S,
           const DesiredRelation& relation, const std::optional<SeenFrame>& frame);

  [[nodiscard]] const tools::LogTable& table() const { return table_; }
  [[nodiscard]] tools::LogTable take() { return std::move(table_); }

 private:
  tools::LogTable table_;
};

}  // namespace vergence::demo
