// A record of the controller as a row of a table.
#pragma once

#include <string>
#include <vector>

#include "firmware_like/daemon/telemetry_record.hpp"

namespace vergence::tools {

[[nodiscard]] const std::vector<std::string>& record_columns();
// In their order.
[[nodiscard]] std::vector<double> record_values(const TelemetryRecord& record);

}  // namespace vergence::tools
