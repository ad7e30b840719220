// The logistic function with + - * / only, so that a probability is the same bits on every machine.
#pragma once

namespace vergence {

// 1 / (1 + exp(-x)), to 1e-7 absolutely; rising in x; 0.5 at 0 exactly. NaN gives 0.
[[nodiscard]] double logistic(double x);

}  // namespace vergence
