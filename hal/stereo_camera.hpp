// Two cameras that take pictures of the same instant.
#pragma once

#include <concepts>
#include <cstdint>

#include "algo/image.hpp"

namespace vergence {

// Valid until the next call of take(). The stamp is the middle of the exposure.
struct StereoFrame {
  std::uint64_t sequence = 0;  // counts pairs; a gap is a pair that was lost
  std::int64_t stamp_ns = 0;
  ImageView left;
  ImageView right;
};

enum class CameraState : std::uint8_t {
  kOk,
  kRestarting,  // no pictures for a moment; they are expected to come back
  kFault,       // they are not
};

// take() never waits: it answers true, and the newest pair, where there is one that was not taken yet.
template <typename T>
concept StereoCamera = requires(T& camera, StereoFrame& frame) {
  { camera.take(frame) } -> std::same_as<bool>;
  { camera.state() } -> std::same_as<CameraState>;
};

}  // namespace vergence
