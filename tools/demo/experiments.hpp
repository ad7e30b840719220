// The experiments, one function each; what they are: catalogue.cpp.
#pragma once

#include "tools/demo/scenario.hpp"

namespace vergence::demo {

Outcome lateral_known(const RunOptions& options);
Outcome lateral_3dof(const RunOptions& options);
Outcome lateral_6dof(const RunOptions& options);

}  // namespace vergence::demo
