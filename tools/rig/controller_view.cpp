#include "tools/rig/controller_view.hpp"

namespace vergence::rig {

void ControllerView::look() {
  TelemetryRecord record;
  // What stands still is of one that has ended, or hangs: there may be a new one.
  for (int attempt = 0; attempt < 2; ++attempt) {
    if (reader_.read(record) && record.period != period_) {
      period_ = record.period;
      record_ = record;
      return;
    }
    if (attempt == 0 && reader_.open(name_.c_str()) != SegmentStatus::kOk) break;
  }
  record_.reset();
}

bool ControllerView::searches() const {
  return record_ && record_->mode == static_cast<std::uint32_t>(Mode::kSearch) &&
         record_->target_believed == 0;
}

bool ControllerView::tracks() const {
  return record_ && record_->track_state == static_cast<std::uint32_t>(TrackState::kTracking);
}

}  // namespace vergence::rig
