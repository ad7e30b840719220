// The pose of the target, frame after frame: hue planes, prediction by motion feed-forward, evolution, and
// what the outcome is worth [3.5, 3.6.4, 5.4].
//
// Per frame: begin_frame() once, evolve() as often as the budget allows, end_frame() once. The budget lies
// with the caller: a number of generations (deterministic) or a clock.
#pragma once

#include <cstdint>

#include "algo/camera_model.hpp"
#include "algo/fitness.hpp"
#include "algo/image.hpp"
#include "algo/rm_ga.hpp"
#include "algo/status.hpp"
#include "algo/target_model.hpp"

namespace vergence {

enum class TargetKind : std::uint8_t {
  kMarker,
  kPhoto,
};

enum class Method : std::uint8_t {
  kVergence,  // this library's way
  kThesis,    // votes of hue alone, binary genes, no gate, planar model: for comparison
};

enum class TrackState : std::uint8_t {
  kSearching,  // not found yet
  kTracking,
  kLost,  // was tracked, or was searched for in vain
};

[[nodiscard]] const char* to_string(TrackState state);

struct TrackerSettings {
  Method method = Method::kVergence;
  std::uint64_t seed = 1;
  SearchBox box;
  GaSettings ga;
  HueLimits hue_limits;
};

// Defaults of a method for a kind of target: coding, mutation rate, saturation gate.
[[nodiscard]] TrackerSettings default_settings(Method method, TargetKind kind);

// What is known of the own motion when a frame was taken.
struct FrameMotion {
  double t_s = 0;
  Transform T_W_H;   // pose of the hand; constant where the hand stands still or is unknown
  Transform T_H_CL;  // pose of the left camera in the hand at this frame
  Transform T_H_CR;  // and of the right
};

struct Estimate {
  Pose pose;              // T_H_M: the target in the hand frame
  double fitness = 0;     // Eq. 3.22 or 5.19 at that pose
  double confidence = 0;  // in [0, 1]
  TrackState state = TrackState::kSearching;
  int generations = 0;           // evolved in this frame
  std::int64_t evaluations = 0;  // poses evaluated in this frame
};

}  // namespace vergence
