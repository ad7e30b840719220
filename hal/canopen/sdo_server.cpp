#include "hal/canopen/sdo_server.hpp"

#include <algorithm>

#include "hal/canopen/bytes.hpp"
#include "hal/canopen/nmt.hpp"

namespace vergence::canopen {
namespace {

constexpr std::uint8_t kToggle = 0x10;
constexpr std::size_t kSegment = 7;

}  // namespace

void SdoServer::init(std::uint8_t node_id) {
  *this = {};
  node_id_ = node_id;
}

void SdoServer::put_object(CanFrame& answer) const {
  put_number(std::span(answer.data).subspan(1), 2, index_);
  answer.data[3] = sub_;
}

void SdoServer::abort(std::uint32_t code, CanFrame& answer) {
  transfer_ = Transfer::kNone;
  answer.data = {};
  answer.data[0] = 0x80;
  put_object(answer);
  put_number(std::span(answer.data).subspan(4), 4, code);
}

void SdoServer::start_write(const CanFrame& request, DriveObjects& objects, CanFrame& answer,
                            std::uint16_t& written) {
  const std::uint8_t command = request.data[0];
  const bool has_size = (command & 0x01) != 0;
  const auto field = std::span(request.data).subspan(4);
  if ((command & 0x02) != 0) {
    // Without a size the object's own counts.
    const std::size_t most = std::min<std::size_t>(4, objects.size(index_, sub_));
    const std::size_t size = has_size ? 4U - ((command >> 2) & 3U) : most;
    if (const std::uint32_t code = objects.write(index_, sub_, field.first(size)); code != kAbortNone) {
      return abort(code, answer);
    }
    written = index_;
    transfer_ = Transfer::kNone;
  } else {
    size_ = has_size ? get_number(field, 4) : 0;
    if (size_ > bytes_.size()) return abort(kAbortTooLong, answer);
    transfer_ = Transfer::kWrite;
    moved_ = 0;
    toggle_ = false;
  }
  answer.data[0] = 0x60;
  put_object(answer);
}

void SdoServer::write_segment(const CanFrame& request, DriveObjects& objects, CanFrame& answer,
                              std::uint16_t& written) {
  const std::uint8_t command = request.data[0];
  if (transfer_ != Transfer::kWrite) return abort(kAbortCommand, answer);
  if (((command & kToggle) != 0) != toggle_) return abort(kAbortToggle, answer);
  const std::size_t here = kSegment - ((command >> 1) & 7U);
  if (moved_ + here > bytes_.size()) return abort(kAbortTooLong, answer);
  for (std::size_t i = 0; i < here; ++i) bytes_[moved_ + i] = request.data[1 + i];
  moved_ += here;
  if ((command & 0x01) != 0) {
    if (size_ != 0 && moved_ != size_) return abort(kAbortLength, answer);
    const std::uint32_t code = objects.write(index_, sub_, std::span(bytes_).first(moved_));
    if (code != kAbortNone) return abort(code, answer);
    written = index_;
    transfer_ = Transfer::kNone;
  }
  answer.data[0] = static_cast<std::uint8_t>(0x20 | (toggle_ ? kToggle : 0));
  toggle_ = !toggle_;
}

void SdoServer::start_read(const DriveObjects& objects, CanFrame& answer) {
  std::span<const std::uint8_t> bytes;
  if (const std::uint32_t code = objects.read(index_, sub_, bytes); code != kAbortNone) {
    return abort(code, answer);
  }
  put_object(answer);
  size_ = bytes.size();
  std::copy(bytes.begin(), bytes.end(), bytes_.begin());
  if (size_ >= 1 && size_ <= 4) {
    answer.data[0] = static_cast<std::uint8_t>(0x43 | (4 - size_) << 2);
    std::copy(bytes.begin(), bytes.end(), answer.data.begin() + 4);
    transfer_ = Transfer::kNone;
    return;
  }
  answer.data[0] = 0x41;
  put_number(std::span(answer.data).subspan(4), 4, static_cast<std::uint32_t>(size_));
  transfer_ = Transfer::kRead;
  moved_ = 0;
  toggle_ = false;
}

void SdoServer::read_segment(const CanFrame& request, CanFrame& answer) {
  if (transfer_ != Transfer::kRead) return abort(kAbortCommand, answer);
  if (((request.data[0] & kToggle) != 0) != toggle_) return abort(kAbortToggle, answer);
  const std::size_t here = std::min(kSegment, size_ - moved_);
  for (std::size_t i = 0; i < here; ++i) answer.data[1 + i] = bytes_[moved_ + i];
  moved_ += here;
  const bool is_last = moved_ == size_;
  answer.data[0] =
      static_cast<std::uint8_t>((toggle_ ? kToggle : 0) | (kSegment - here) << 1 | (is_last ? 0x01 : 0));
  toggle_ = !toggle_;
  if (is_last) transfer_ = Transfer::kNone;
}

bool SdoServer::receive(const CanFrame& request, DriveObjects& objects, CanFrame& answer,
                        std::uint16_t& written) {
  written = 0;
  if (request.id != kSdoRequestCobId + node_id_ || request.size != 8 || request.is_remote ||
      request.is_error) {
    return false;
  }
  answer = {};
  answer.id = kSdoResponseCobId + node_id_;
  answer.size = 8;
  const auto command = static_cast<std::uint8_t>(request.data[0] >> 5);
  if (command == 1 || command == 2) {
    index_ = static_cast<std::uint16_t>(get_number(std::span(request.data).subspan(1), 2));
    sub_ = request.data[3];
  }
  switch (command) {
    case 0: write_segment(request, objects, answer, written); return true;
    case 1: start_write(request, objects, answer, written); return true;
    case 2: start_read(objects, answer); return true;
    case 3: read_segment(request, answer); return true;
    case 4: transfer_ = Transfer::kNone; return false;  // the client aborts
    default: abort(kAbortCommand, answer); return true;
  }
}

}  // namespace vergence::canopen
