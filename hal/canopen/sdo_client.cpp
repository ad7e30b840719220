#include "hal/canopen/sdo_client.hpp"

#include <algorithm>

#include "hal/canopen/bytes.hpp"
#include "hal/canopen/nmt.hpp"

namespace vergence::canopen {
namespace {

// Command specifiers: the upper three bits of the first byte.
constexpr std::uint8_t kSpecifier = 0xE0;
constexpr std::uint8_t kWriteSegmentDone = 0x20;
constexpr std::uint8_t kWriteStarted = 0x60;
constexpr std::uint8_t kReadStarted = 0x40;
constexpr std::uint8_t kReadSegmentHere = 0x00;
constexpr std::uint8_t kAbort = 0x80;

constexpr std::uint8_t kToggle = 0x10;
constexpr std::uint8_t kExpedited = 0x02;
constexpr std::uint8_t kSizeIndicated = 0x01;
constexpr std::uint8_t kLastSegment = 0x01;
constexpr std::size_t kSegment = 7;

}  // namespace

void SdoClient::init(std::uint8_t node_id, std::int64_t timeout_ns) {
  *this = {};
  node_id_ = node_id;
  timeout_ns_ = timeout_ns;
}

void SdoClient::ask(std::uint8_t command, std::int64_t now_ns) {
  request_ = {};
  request_.id = kSdoRequestCobId + node_id_;
  request_.size = 8;
  request_.data[0] = command;
  to_send_ = true;
  asked_ns_ = now_ns;
}

void SdoClient::put_object() {
  put_number(std::span(request_.data).subspan(1), 2, index_);
  request_.data[3] = sub_;
}

void SdoClient::begin(Phase phase, std::uint16_t index, std::uint8_t sub, std::int64_t now_ns) {
  state_ = SdoState::kBusy;
  phase_ = phase;
  index_ = index;
  sub_ = sub;
  toggle_ = false;
  last_segment_ = false;
  abort_code_ = kAbortNone;
  moved_ = 0;
  announced_ = 0;
  ask(kReadStarted, now_ns);  // 0x40 asks to read as well as it answers
  put_object();
}

bool SdoClient::write(std::uint16_t index, std::uint8_t sub, std::span<const std::uint8_t> bytes,
                      std::int64_t now_ns) {
  if (state_ == SdoState::kBusy || bytes.empty() || bytes.size() > kMaxSdoBytes) return false;
  std::copy(bytes.begin(), bytes.end(), bytes_.begin());
  size_ = bytes.size();
  begin(Phase::kInitWrite, index, sub, now_ns);
  if (size_ <= 4) {
    request_.data[0] = static_cast<std::uint8_t>(0x23 | (4 - size_) << 2);
    std::copy(bytes.begin(), bytes.end(), request_.data.begin() + 4);
  } else {
    request_.data[0] = 0x21;
    put_number(std::span(request_.data).subspan(4), 4, static_cast<std::uint32_t>(size_));
  }
  return true;
}

bool SdoClient::read(std::uint16_t index, std::uint8_t sub, std::int64_t now_ns) {
  if (state_ == SdoState::kBusy) return false;
  size_ = 0;
  begin(Phase::kInitRead, index, sub, now_ns);
  return true;
}

void SdoClient::put_segment(std::int64_t now_ns) {
  const std::size_t now = std::min(kSegment, size_ - moved_);
  last_segment_ = moved_ + now == size_;
  const std::size_t empty = kSegment - now;
  ask(static_cast<std::uint8_t>((toggle_ ? kToggle : 0) | empty << 1 | (last_segment_ ? kLastSegment : 0)),
      now_ns);
  for (std::size_t i = 0; i < now; ++i) request_.data[1 + i] = bytes_[moved_ + i];
  moved_ += now;
}

void SdoClient::finish() {
  state_ = SdoState::kDone;
  to_send_ = false;
}

// By us; the node is told.
void SdoClient::abort(std::uint32_t code) {
  state_ = SdoState::kAborted;
  abort_code_ = code;
  ask(kAbort, asked_ns_);
  put_object();
  put_number(std::span(request_.data).subspan(4), 4, code);
}

bool SdoClient::is_about_object(const CanFrame& frame) const {
  return get_number(std::span(frame.data).subspan(1), 2) == index_ && frame.data[3] == sub_;
}

void SdoClient::on_read_started(const CanFrame& frame, std::int64_t now_ns) {
  const std::uint8_t command = frame.data[0];
  if ((command & kExpedited) != 0) {
    // Without its size, an object counts as the four bytes there are.
    size_ = (command & kSizeIndicated) != 0 ? 4U - ((command >> 2) & 3U) : 4U;
    for (std::size_t i = 0; i < size_; ++i) bytes_[i] = frame.data[4 + i];
    return finish();
  }
  if ((command & kSizeIndicated) != 0) announced_ = get_number(std::span(frame.data).subspan(4), 4);
  if (announced_ > kMaxSdoBytes) return abort(kAbortMemory);
  phase_ = Phase::kReadSegment;
  ask(0x60, now_ns);
}

void SdoClient::on_read_segment(const CanFrame& frame, std::int64_t now_ns) {
  const std::uint8_t command = frame.data[0];
  if (((command & kToggle) != 0) != toggle_) return abort(kAbortToggle);
  const std::size_t here = kSegment - ((command >> 1) & 7U);
  if (size_ + here > kMaxSdoBytes) return abort(kAbortMemory);
  for (std::size_t i = 0; i < here; ++i) bytes_[size_ + i] = frame.data[1 + i];
  size_ += here;
  if (announced_ != 0 && size_ > announced_) return abort(kAbortTooLong);
  if ((command & kLastSegment) != 0) {
    if (announced_ != 0 && size_ < announced_) return abort(kAbortTooShort);
    return finish();
  }
  toggle_ = !toggle_;
  ask(static_cast<std::uint8_t>(0x60 | (toggle_ ? kToggle : 0)), now_ns);
}

void SdoClient::receive(const CanFrame& frame, std::int64_t now_ns) {
  if (state_ != SdoState::kBusy || to_send_ || frame.id != kSdoResponseCobId + node_id_ || frame.size != 8 ||
      frame.is_remote || frame.is_error) {
    return;
  }
  const std::uint8_t specifier = frame.data[0] & kSpecifier;
  if (specifier == kAbort) {
    if (!is_about_object(frame)) return;
    state_ = SdoState::kAborted;
    abort_code_ = get_number(std::span(frame.data).subspan(4), 4);
    return;
  }
  switch (phase_) {
    case Phase::kInitWrite:
      if (specifier != kWriteStarted) return abort(kAbortCommand);
      if (!is_about_object(frame)) return;
      if (size_ <= 4) return finish();
      phase_ = Phase::kWriteSegment;
      return put_segment(now_ns);
    case Phase::kWriteSegment:
      if (specifier != kWriteSegmentDone) return abort(kAbortCommand);
      if (((frame.data[0] & kToggle) != 0) != toggle_) return abort(kAbortToggle);
      if (last_segment_) return finish();
      toggle_ = !toggle_;
      return put_segment(now_ns);
    case Phase::kInitRead:
      if (specifier != kReadStarted) return abort(kAbortCommand);
      if (is_about_object(frame)) on_read_started(frame, now_ns);
      return;
    case Phase::kReadSegment:
      if (specifier != kReadSegmentHere) return abort(kAbortCommand);
      return on_read_segment(frame, now_ns);
  }
}

void SdoClient::process(std::int64_t now_ns, const FrameSink& sink) {
  if (state_ == SdoState::kBusy && now_ns - asked_ns_ > timeout_ns_) abort(kAbortTimeout);
  if (to_send_ && sink.send(request_)) to_send_ = false;
}

}  // namespace vergence::canopen
