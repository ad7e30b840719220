// The numbers of `vergence bench rt`, for people and for machines.
#pragma once

#include <string>

#include "tools/bench/rt_bench.hpp"

namespace vergence::tools {

[[nodiscard]] std::string rt_report_text(const RtBenchResult& result);
[[nodiscard]] std::string rt_report_json(const RtBenchResult& result);

}  // namespace vergence::tools
