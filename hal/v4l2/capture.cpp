#include "hal/v4l2/capture.hpp"

#include <poll.h>

#include <algorithm>
#include <cerrno>

namespace vergence::v4l2 {
namespace {

constexpr std::int64_t kNever_ns = INT64_MAX;

std::int64_t back_off_ns(int attempts) {
  if (attempts == 0) return 0;
  return std::min(kFirstBackOff_ns << std::min(attempts - 1, 10), kMaxBackOff_ns);
}

// The device itself is well, as far as anybody knows.
bool is_of_stream(VideoFault fault) {
  return fault == VideoFault::kStream || fault == VideoFault::kStalled || fault == VideoFault::kQueue ||
         fault == VideoFault::kAnswer;
}

}  // namespace

VideoError Capture::configure(VideoSystem& system, const VideoConfig& config) {
  if (const VideoError error = check(config); !is_ok(error)) return error;
  *this = {};
  system_ = &system;
  config_ = config;
  controls_.configure(config.controls);
  return {};
}

void Capture::start(std::int64_t now_ns) {
  if (system_ == nullptr || (state_ != CaptureState::kStopped && state_ != CaptureState::kFault)) return;
  state_ = CaptureState::kRestarting;
  in_trouble_ = true;
  trouble_since_ns_ = now_ns;
  attempts_ = 0;
  keeps_device_ = false;
  due_ns_ = now_ns;
}

void Capture::stop() {
  close();
  state_ = CaptureState::kStopped;
}

void Capture::close() {
  ring_.release();
  if (handle_ >= 0) system_->close(handle_);
  handle_ = -1;
}

bool Capture::is_running() const {
  return state_ == CaptureState::kSettling || state_ == CaptureState::kStreaming;
}

bool Capture::wants_buffers_back() const {
  return state_ == CaptureState::kRestarting && !keeps_device_ && ring_.held() > 0;
}

CameraState Capture::camera_state() const {
  if (state_ == CaptureState::kFault) return CameraState::kFault;
  return state_ == CaptureState::kStreaming && good_frames_ > 0 ? CameraState::kOk : CameraState::kRestarting;
}

VideoError Capture::open(std::int64_t now_ns) {
  close();
  if (const int e = system_->open(config_.path.data(), handle_); e != 0) {
    handle_ = -1;
    return {VideoFault::kOpen, e};
  }
  VideoError error = negotiate(*system_, handle_, config_, format_);
  if (is_ok(error)) error = ring_.allocate(*system_, handle_, format_, config_.memory, config_.buffers);
  if (is_ok(error)) error = begin(now_ns);
  if (!is_ok(error)) {
    close();
    return error;
  }
  ++counts_.openings;
  return {};
}

VideoError Capture::begin(std::int64_t now_ns) {
  const bool settles = controls_.needs_settling();
  VideoError error = settles ? controls_.begin(*system_, handle_) : controls_.lock(*system_, handle_);
  if (is_ok(error)) error = ring_.start();
  if (!is_ok(error)) return error;
  state_ = settles ? CaptureState::kSettling : CaptureState::kStreaming;
  settled_ns_ = now_ns + config_.settle_ns;
  last_good_ns_ = now_ns;
  good_frames_ = 0;
  has_sequence_ = false;
  heard_frame_ = false;
  return {};
}

void Capture::attempt(std::int64_t now_ns) {
  if (wants_buffers_back()) {
    due_ns_ = now_ns + kReaderWait_ns;
    return;
  }
  const VideoError error = keeps_device_ ? begin(now_ns) : open(now_ns);
  if (is_ok(error)) return;
  if (error.error_number == ENODEV) ++counts_.unplugged;
  trouble(now_ns, error);
}

void Capture::trouble(std::int64_t now_ns, const VideoError& error) {
  ring_.stop();
  error_ = error;
  if (is_permanent(error)) return give_up(error);
  if (!in_trouble_) {
    in_trouble_ = true;
    trouble_since_ns_ = now_ns;
    attempts_ = 0;
  }
  if (now_ns - trouble_since_ns_ >= config_.give_up_ns) return give_up(error);
  state_ = CaptureState::kRestarting;
  keeps_device_ = handle_ >= 0 && attempts_ == 0 && is_of_stream(error.fault);
  due_ns_ = now_ns + back_off_ns(attempts_);
  ++attempts_;
  ++counts_.restarts;
}

void Capture::give_up(const VideoError& error) {
  ring_.stop();
  error_ = error;
  state_ = CaptureState::kFault;
}

void Capture::failed_call(std::int64_t now_ns, VideoFault otherwise, int error_number) {
  const bool is_gone = error_number == ENODEV || error_number == ENXIO;
  ++(is_gone ? counts_.unplugged : counts_.stream_errors);
  if (error_number == EBADMSG) otherwise = VideoFault::kAnswer;
  trouble(now_ns, {is_gone ? VideoFault::kUnplugged : otherwise, error_number});
}

bool Capture::next(std::int64_t now_ns, CapturedFrame& frame) {
  for (int i = 0; i < kMaxVideoBuffers && is_running(); ++i) {
    DequeuedBuffer buffer;
    if (const int e = ring_.dequeue(buffer); e != 0) {
      if (e != EAGAIN) failed_call(now_ns, VideoFault::kStream, e);
      return false;
    }
    heard_frame_ = true;
    count_sequence(buffer.sequence);
    if (!buffer.has_monotonic_stamp) {
      give_back(now_ns, buffer.index);
      trouble(now_ns, {VideoFault::kStampClock});
      return false;
    }
    const bool is_usable = is_good(now_ns, buffer);
    if (is_usable) note_good(now_ns);
    if (!is_usable || state_ == CaptureState::kSettling) {
      if (is_usable) ++counts_.settling;
      give_back(now_ns, buffer.index);
      continue;
    }
    ++counts_.frames;
    frame = {buffer.index, number_, buffer.stamp_ns + config_.stamp_to_mid_exposure_ns, buffer.image};
    return true;
  }
  return false;
}

void Capture::count_sequence(std::uint32_t sequence) {
  const std::uint32_t missing = has_sequence_ ? sequence - sequence_ - 1 : 0;
  constexpr std::uint32_t kBackwards = 1U << 31;
  const bool is_backwards = missing >= kBackwards;
  if (missing != 0) ++counts_.gaps;
  if (!is_backwards) counts_.lost += missing;
  number_ += is_backwards ? 1 : std::uint64_t{missing} + 1;
  sequence_ = sequence;
  has_sequence_ = true;
}

bool Capture::is_good(std::int64_t now_ns, const DequeuedBuffer& buffer) {
  if (buffer.is_flagged) {
    ++counts_.flagged;
    return false;
  }
  if (!buffer.is_whole) {
    ++counts_.incomplete;
    return false;
  }
  const std::int64_t age_ns = now_ns - buffer.stamp_ns;
  if (buffer.stamp_ns <= 0 || age_ns > kMaxStampAge_ns || age_ns < -kMaxStampLead_ns) {
    ++counts_.bad_stamps;
    return false;
  }
  return true;
}

void Capture::note_good(std::int64_t now_ns) {
  last_good_ns_ = now_ns;
  if (good_frames_ < kGoodFramesToRecover) ++good_frames_;
  if (!in_trouble_ || good_frames_ < kGoodFramesToRecover) return;
  in_trouble_ = false;
  if (attempts_ > 0) ++counts_.recoveries;
}

void Capture::give_back(std::int64_t now_ns, int buffer) {
  const int e = ring_.give_back(buffer);
  if (e != 0 && is_running()) failed_call(now_ns, VideoFault::kQueue, e);
}

std::int64_t Capture::patience_ns() const {
  return good_frames_ > 0 ? config_.stall_ns : config_.first_frame_ns;
}

void Capture::tend(std::int64_t now_ns, short happened) {
  if (state_ == CaptureState::kRestarting) {
    if (now_ns - trouble_since_ns_ >= config_.give_up_ns) {
      give_up(is_ok(error_) ? VideoError{VideoFault::kOpen} : error_);
    } else if (now_ns >= due_ns_) {
      attempt(now_ns);
    }
    return;
  }
  if (!is_running()) return;
  const bool heard_frame = heard_frame_;
  heard_frame_ = false;
  if ((happened & (POLLHUP | POLLNVAL)) != 0) {
    failed_call(now_ns, VideoFault::kUnplugged, ENODEV);
  } else if ((happened & POLLERR) != 0 && !heard_frame) {
    failed_call(now_ns, VideoFault::kStream, 0);  // it would say so for ever
  } else if (now_ns - last_good_ns_ >= patience_ns()) {
    ++counts_.stalls;
    trouble(now_ns, {VideoFault::kStalled, 0, 0, patience_ns(), now_ns - last_good_ns_});
  } else if (in_trouble_ && good_frames_ == 0 && now_ns - trouble_since_ns_ >= config_.give_up_ns) {
    give_up(is_ok(error_) ? VideoError{VideoFault::kStalled} : error_);
  } else if (state_ == CaptureState::kSettling && now_ns >= settled_ns_) {
    const VideoError error = controls_.lock(*system_, handle_);
    if (is_ok(error)) {
      state_ = CaptureState::kStreaming;
    } else {
      trouble(now_ns, error);
    }
  }
}

std::int64_t Capture::deadline_ns() const {
  if (state_ == CaptureState::kRestarting) return std::min(due_ns_, trouble_since_ns_ + config_.give_up_ns);
  if (!is_running()) return kNever_ns;
  std::int64_t deadline_ns = last_good_ns_ + patience_ns();
  if (state_ == CaptureState::kSettling) deadline_ns = std::min(deadline_ns, settled_ns_);
  if (in_trouble_ && good_frames_ == 0)
    deadline_ns = std::min(deadline_ns, trouble_since_ns_ + config_.give_up_ns);
  return deadline_ns;
}

}  // namespace vergence::v4l2
