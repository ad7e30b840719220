// Outcome of an operation in the controller, which knows no exceptions.
#pragma once

#include <cstdint>

namespace vergence {

enum class Status : std::uint8_t {
  kOk,
  kBadCamera,      // focal length not positive, or image size zero or above the static limit
  kBadModel,       // radius, distance, sample count or tolerance outside its range
  kBadRoi,         // rectangle empty or not inside the photo
  kTooManyPoints,  // more points than the static limit
  kNoHue,          // too few points of the photo have a hue
  kBadSearchBox,   // half range not positive, or not finite, or e outside the unit ball
  kBadImage,       // size or format of an image is not the rig's
  kBadLimits,      // a limit of motion not positive or not finite, or a range empty
  kBadArm,         // joint count, link, joint limit or fixed transform of the arm outside its range
  kBadNumber,      // a pose, joint angle or velocity not finite, or beyond what any arm does
  kBadGains,       // a gain, noise or time constant of the control not finite or outside its range
};

// What happened, in words, for people.
[[nodiscard]] const char* describe(Status status);

}  // namespace vergence
