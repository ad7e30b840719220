#include "firmware_like/daemon/black_box.hpp"

#include <sched.h>

#include <algorithm>

namespace vergence {
namespace {

struct Yuv {
  std::uint8_t y;
  std::uint8_t cb;
  std::uint8_t cr;
};

std::uint8_t to_byte(int thousandths) {
  return static_cast<std::uint8_t>(std::clamp((thousandths + 500) / 1000, 0, 255));
}

Yuv of_rgb(int r, int g, int b) {
  return {to_byte(299 * r + 587 * g + 114 * b), to_byte(128'000 - 169 * r - 331 * g + 500 * b),
          to_byte(128'000 + 500 * r - 419 * g - 81 * b)};
}

// Packed 4:2:2: the chroma of a pixel is that of its pair.
Yuv packed_at(const std::uint8_t* row, int x, bool luma_first) {
  const auto pair = static_cast<std::size_t>(x / 2) * 4;
  const auto odd = static_cast<std::size_t>(x % 2) * 2;
  if (luma_first) return {row[pair + odd], row[pair + 1], row[pair + 3]};
  return {row[pair + odd + 1], row[pair], row[pair + 2]};
}

Yuv pixel_at(const ImageView& image, int x, int y) {
  const std::uint8_t* row = image.data + static_cast<std::size_t>(y) * image.stride_bytes;
  switch (image.format) {
    case PixelFormat::kRgb24: return of_rgb(row[3 * x], row[3 * x + 1], row[3 * x + 2]);
    case PixelFormat::kYuyv: return packed_at(row, x, true);
    case PixelFormat::kUyvy: return packed_at(row, x, false);
    case PixelFormat::kNv12: break;
  }
  const std::uint8_t* chroma = image.chroma + static_cast<std::size_t>(y / 2) * image.chroma_stride_bytes;
  return {row[x], chroma[x & ~1], chroma[x | 1]};
}

}  // namespace

void take_picture(const ImageView& image, BoxPicture& picture) {
  for (int y = 0; y < kBoxPictureHeight; ++y) {
    for (int x = 0; x < kBoxPictureWidth; ++x) {
      const Yuv pixel =
          pixel_at(image, x * image.width_px / kBoxPictureWidth, y * image.height_px / kBoxPictureHeight);
      const auto i = static_cast<std::size_t>(y) * kBoxPictureWidth + static_cast<std::size_t>(x);
      picture.luma[i] = pixel.y;
      picture.cb[i] = pixel.cb;
      picture.cr[i] = pixel.cr;
    }
  }
}

void BlackBox::record(const TelemetryRecord& record) {
  const State state = state_.load(std::memory_order_relaxed);
  if (state == State::kFrozen) return;
  records_[recorded_ % kBoxRecords] = record;
  ++recorded_;
  if (state == State::kTail && ++tail_ >= kBoxTailRecords) state_.store(State::kFrozen);
}

bool BlackBox::trigger(std::int64_t now_ns) {
  if (state_.load(std::memory_order_relaxed) != State::kRecording) return false;
  fault_ns_ = now_ns;
  tail_ = 0;
  state_.store(State::kTail);
  return true;
}

void BlackBox::look(const StereoFrame& frame) {
  if (frame.stamp_ns < next_picture_ns_) return;
  looking_.store(true);
  if (state_.load() != State::kFrozen) {
    next_picture_ns_ = frame.stamp_ns + kBoxPictureEvery_ns;
    BoxPair& pair = pairs_[looked_ % kBoxPictures];
    pair.sequence = frame.sequence;
    pair.stamp_ns = frame.stamp_ns;
    take_picture(frame.left, pair.left);
    take_picture(frame.right, pair.right);
    ++looked_;
  }
  looking_.store(false);
}

void BlackBox::release() {
  state_.store(State::kRecording);
}

std::size_t BlackBox::records() const {
  return static_cast<std::size_t>(std::min<std::uint64_t>(recorded_, kBoxRecords));
}

const TelemetryRecord& BlackBox::record_at(std::size_t i) const {
  return records_[(recorded_ - records() + i) % kBoxRecords];
}

std::size_t BlackBox::pairs() const {
  // A picture that was begun before the box froze is soon there: a fraction of a millisecond.
  while (looking_.load()) (void)::sched_yield();
  return static_cast<std::size_t>(std::min<std::uint64_t>(looked_, kBoxPictures));
}

const BoxPair& BlackBox::pair_at(std::size_t i) const {
  return pairs_[(looked_ - pairs() + i) % kBoxPictures];
}

}  // namespace vergence
