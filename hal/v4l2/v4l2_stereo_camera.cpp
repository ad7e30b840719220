#include "hal/v4l2/v4l2_stereo_camera.hpp"

#include <algorithm>

namespace vergence::v4l2 {

VideoError V4l2StereoCamera::configure(VideoSystem& system, const StereoVideoConfig& config, int& side) {
  for (side = 0; side < 2; ++side) {
    const VideoConfig& eye = config.eyes[static_cast<std::size_t>(side)];
    if (const VideoError error = captures_[static_cast<std::size_t>(side)].configure(system, eye);
        !is_ok(error))
      return error;
    // With more, a frame would have two partners that are equally good.
    const std::int64_t interval_ns =
        eye.interval.denominator == 0 ? kMaxSkew_ns
                                      : static_cast<std::int64_t>(std::uint64_t{eye.interval.numerator} *
                                                                  1'000'000'000U / eye.interval.denominator);
    if (config.max_skew_ns < 0 || config.max_skew_ns > interval_ns / 2)
      return {VideoFault::kConfig, 0, 0, config.max_skew_ns, interval_ns / 2};
  }
  system_ = &system;
  pairing_.configure(config.max_skew_ns);
  return {};
}

void V4l2StereoCamera::start(std::int64_t now_ns) {
  for (Capture& capture : captures_) capture.start(now_ns);
}

void V4l2StereoCamera::stop() {
  for (int side = 0; side < 2; ++side) {
    DroppedFrames dropped;
    pairing_.clear(side, dropped);
    captures_[static_cast<std::size_t>(side)].stop();
  }
  // Both sides of the exchange are still: what it holds is no frame any more.
  for (int i = 0; i < 3; ++i) {
    (void)pairs_.offer({});
    (void)pairs_.take();
  }
  state_.store(CameraState::kRestarting, std::memory_order_release);
}

void V4l2StereoCamera::wait(std::int64_t now_ns) {
  if (system_ == nullptr) return;
  std::int64_t until_ns = now_ns + kMaxWait_ns;
  std::array<PollEntry, 2> entries{};
  for (std::size_t s = 0; s < 2; ++s) {
    entries[s].handle = captures_[s].handle_to_poll();
    until_ns = std::min(until_ns, captures_[s].deadline_ns());
  }
  const std::int64_t wait_ns = std::max<std::int64_t>(until_ns - now_ns, 0);
  report_.longest_wait_ns = std::max(report_.longest_wait_ns, wait_ns);
  const int e = system_->poll(entries, wait_ns);
  for (std::size_t s = 0; s < 2; ++s) happened_[s] = e == 0 ? entries[s].happened : short{0};
}

void V4l2StereoCamera::serve(std::int64_t now_ns) {
  if (system_ == nullptr) return;
  const int buffers = std::min(captures_[0].ring().count(), captures_[1].ring().count());
  pairing_.set_depth(buffers - kReaderBuffers - kDriverBuffers);
  for (int side = 0; side < 2; ++side) collect(now_ns, side);
  offer_newest(now_ns);
  recall(now_ns);

  CameraState state = CameraState::kOk;
  for (const Capture& capture : captures_) state = std::max(state, capture.camera_state());
  state_.store(state, std::memory_order_release);
  publish();
}

void V4l2StereoCamera::collect(std::int64_t now_ns, int side) {
  const auto s = static_cast<std::size_t>(side);
  Capture& capture = captures_[s];
  // A driver that always has one more must not keep us here.
  for (int i = 0; i < kMaxVideoBuffers && happened_[s] != 0; ++i) {
    CapturedFrame frame;
    if (!capture.next(now_ns, frame)) break;
    frames_[s][static_cast<std::size_t>(frame.buffer)] = frame;
    DroppedFrames dropped;
    pairing_.add(side, {frame.stamp_ns, frame.buffer}, dropped);
    give_back(now_ns, dropped);
  }
  capture.tend(now_ns, happened_[s]);
  happened_[s] = 0;
  if (capture.state() == CaptureState::kStreaming) return;
  DroppedFrames dropped;
  pairing_.clear(side, dropped);
  give_back(now_ns, dropped);
}

void V4l2StereoCamera::offer_newest(std::int64_t now_ns) {
  std::array<TimedFrame, 2> found{};
  DroppedFrames dropped;
  const bool is_pair = pairing_.newest(found[0], found[1], dropped);
  give_back(now_ns, dropped);
  if (!is_pair) return;

  Pair pair;
  std::uint64_t step = 1;
  for (std::size_t s = 0; s < 2; ++s) {
    const CapturedFrame& frame = frames_[s][static_cast<std::size_t>(found[s].id)];
    pair.buffers[s] = frame.buffer;
    (s == 0 ? pair.frame.left : pair.frame.right) = frame.image;
    // Frames that either eye lost, or that found no partner, are pairs that were lost.
    step = std::max(step, frame.number - last_numbers_[s]);
    last_numbers_[s] = frame.number;
  }
  sequence_ += step;
  pair.frame.sequence = sequence_;
  pair.frame.stamp_ns = found[0].stamp_ns + (found[1].stamp_ns - found[0].stamp_ns) / 2;
  const bool is_passed_over = !pairs_.is_taken() && !is_recalling_;
  is_recalling_ = false;
  const Pair free = pairs_.offer(pair);
  if (is_passed_over) ++report_.pairs_passed_over;
  give_back(now_ns, free);
}

// The reader's pictures go back in two steps: an empty pair is offered, and when the reader has taken it,
// what it had before comes back with the next offer.
void V4l2StereoCamera::recall(std::int64_t now_ns) {
  const bool is_wanted = captures_[0].wants_buffers_back() || captures_[1].wants_buffers_back();
  if (!is_wanted) return;
  if (is_recalling_ && !pairs_.is_taken()) return;
  is_recalling_ = true;
  give_back(now_ns, pairs_.offer({}));
}

void V4l2StereoCamera::give_back(std::int64_t now_ns, const DroppedFrames& dropped) {
  for (std::size_t s = 0; s < 2; ++s)
    for (int i = 0; i < dropped.count[s]; ++i)
      captures_[s].give_back(now_ns, dropped.ids[s][static_cast<std::size_t>(i)]);
}

void V4l2StereoCamera::give_back(std::int64_t now_ns, const Pair& pair) {
  for (std::size_t s = 0; s < 2; ++s)
    if (pair.buffers[s] >= 0) captures_[s].give_back(now_ns, pair.buffers[s]);
}

bool V4l2StereoCamera::take(StereoFrame& frame) {
  const Pair* pair = pairs_.take();
  if (pair == nullptr || pair->buffers[0] < 0) return false;
  frame = pair->frame;
  return true;
}

void V4l2StereoCamera::publish() {
  for (std::size_t s = 0; s < 2; ++s) {
    report_.eyes[s] = captures_[s].counts();
    report_.errors[s] = captures_[s].error();
    report_.formats[s] = captures_[s].format();
  }
  report_.pairing = pairing_.counts();
  (void)reports_.offer(report_);
}

bool V4l2StereoCamera::report(StereoVideoReport& report) {
  const StereoVideoReport* newest = reports_.take();
  if (newest == nullptr) return false;
  report = *newest;
  return true;
}

}  // namespace vergence::v4l2
