#include "tools/bringup/watch_cameras.hpp"

#include <algorithm>
#include <array>
#include <memory>

#include "hal/v4l2/capture.hpp"
#include "tools/bringup/picture.hpp"

namespace vergence::tools {
namespace {

constexpr std::int64_t kPatience_ns = 2'000'000'000;  // with a camera that is not there

v4l2::CaptureCounts difference(const v4l2::CaptureCounts& now, const v4l2::CaptureCounts& before) {
  v4l2::CaptureCounts run;
  run.frames = now.frames - before.frames;
  run.flagged = now.flagged - before.flagged;
  run.incomplete = now.incomplete - before.incomplete;
  run.bad_stamps = now.bad_stamps - before.bad_stamps;
  run.gaps = now.gaps - before.gaps;
  run.lost = now.lost - before.lost;
  run.restarts = now.restarts - before.restarts;
  return run;
}

class Watcher {
 public:
  Watcher(v4l2::VideoSystem& system, const v4l2::StereoVideoConfig& config,
          const std::function<std::int64_t()>& now_ns)
      : system_(&system), now_ns_(&now_ns) {
    for (std::size_t side = 0; side < 2; ++side) {
      v4l2::VideoConfig eye = config.eyes[side];
      eye.give_up_ns = std::min(eye.give_up_ns, kPatience_ns);
      start_within_ns_ = std::max(start_within_ns_, eye.settle_ns + eye.first_frame_ns + eye.give_up_ns);
      const v4l2::VideoError error = captures_[side].configure(system, eye);
      if (v4l2::is_ok(error)) captures_[side].start((*now_ns_)());
      seen_.eyes[side].error = error;
    }
  }

  [[nodiscard]] CameraObservation watch(double seconds) {
    run((*now_ns_)() + start_within_ns_, true);
    std::array<v4l2::CaptureCounts, 2> before;
    for (std::size_t side = 0; side < 2; ++side) {
      before[side] = captures_[side].counts();
      seen_.eyes[side].streamed = captures_[side].camera_state() == CameraState::kOk;
      seen_.eyes[side].format = captures_[side].format();
      read_controls(side, seen_.eyes[side].first);
    }
    is_recording_ = true;
    if (seen_.eyes[0].streamed || seen_.eyes[1].streamed) {
      run((*now_ns_)() + static_cast<std::int64_t>(seconds * 1e9), false);
    }
    for (std::size_t side = 0; side < 2; ++side) {
      EyeObservation& eye = seen_.eyes[side];
      read_controls(side, eye.last);
      eye.counts = difference(captures_[side].counts(), before[side]);
      eye.light = light_[side].summary();
      if (v4l2::is_ok(eye.error)) eye.error = captures_[side].error();
      captures_[side].stop();
    }
    return std::move(seen_);
  }

 private:
  void read_controls(std::size_t side, ControlReadings& readings) {
    const int handle = captures_[side].handle_to_poll();
    for (std::size_t role = 0; handle >= 0 && role < readings.size(); ++role) {
      readings[role] = v4l2::read_control(*system_, handle, static_cast<v4l2::ControlRole>(role));
    }
  }

  [[nodiscard]] bool is_settled(std::size_t side) const {
    const v4l2::Capture& capture = captures_[side];
    return capture.state() == v4l2::CaptureState::kFault || capture.state() == v4l2::CaptureState::kStopped ||
           capture.camera_state() == CameraState::kOk;
  }

  void run(std::int64_t until_ns, bool ends_when_settled) {
    for (std::int64_t now = (*now_ns_)(); now < until_ns; now = (*now_ns_)()) {
      if (ends_when_settled && is_settled(0) && is_settled(1)) return;
      std::array<v4l2::PollEntry, 2> entries{};
      std::int64_t wake_ns = std::min(until_ns, now + v4l2::kMaxWait_ns);
      for (std::size_t side = 0; side < 2; ++side) {
        entries[side].handle = captures_[side].handle_to_poll();
        wake_ns = std::min(wake_ns, captures_[side].deadline_ns());
      }
      const int error = system_->poll(entries, std::max<std::int64_t>(wake_ns - now, 0));
      for (std::size_t side = 0; side < 2; ++side)
        serve(side, error == 0 ? entries[side].happened : short{0});
    }
  }

  void serve(std::size_t side, short happened) {
    const std::int64_t now = (*now_ns_)();
    v4l2::CapturedFrame frame;
    for (int i = 0; i < v4l2::kMaxVideoBuffers && happened != 0 && captures_[side].next(now, frame); ++i) {
      if (is_recording_) record(side, frame);
      captures_[side].give_back(now, frame.buffer);
    }
    captures_[side].tend(now, happened);
  }

  void record(std::size_t side, const v4l2::CapturedFrame& frame) {
    EyeObservation& eye = seen_.eyes[side];
    if (eye.frames.empty()) eye.picture = rgb_of(frame.image);
    eye.frames.push_back({frame.number, frame.stamp_ns});
    light_[side].look(frame.image);
  }

  v4l2::VideoSystem* system_;
  const std::function<std::int64_t()>* now_ns_;
  std::array<v4l2::Capture, 2> captures_;
  std::array<LightWatch, 2> light_;
  CameraObservation seen_;
  std::int64_t start_within_ns_ = 0;
  bool is_recording_ = false;
};

}  // namespace

CameraObservation watch_cameras(v4l2::VideoSystem& system, const v4l2::StereoVideoConfig& config,
                                double seconds, const std::function<std::int64_t()>& now_ns) {
  return std::make_unique<Watcher>(system, config, now_ns)->watch(seconds);
}

}  // namespace vergence::tools
