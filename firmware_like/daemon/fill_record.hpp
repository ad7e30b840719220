// What the arm's task knows, as a record.
#pragma once

#include "firmware_like/daemon/telemetry_record.hpp"
#include "firmware_like/pipeline.hpp"

namespace vergence {

// All but `period` and `tasks`, which are the executive's. From the thread that runs step_arm().
void fill_record(const Pipeline& pipeline, TelemetryRecord& record);

}  // namespace vergence
