// The experiments, one function each; what they are: catalogue.cpp.
#pragma once

#include "tools/demo/scenario.hpp"

namespace vergence::demo {

Outcome lateral_known(const RunOptions& options);
Outcome lateral_3dof(const RunOptions& options);
Outcome lateral_6dof(const RunOptions& options);
Outcome fitness_light(const RunOptions& options);
Outcome arc_swing(const RunOptions& options);
Outcome fitness_twelve(const RunOptions& options);
Outcome track_twenty(const RunOptions& options);
Outcome servo_position(const RunOptions& options);
Outcome servo_orientation(const RunOptions& options);
Outcome pool(const RunOptions& options);
Outcome photo_vergence(const RunOptions& options);
Outcome teleport(const RunOptions& options);
Outcome shove(const RunOptions& options);
Outcome drop_outs(const RunOptions& options);

}  // namespace vergence::demo
