#include "algo/status.hpp"

namespace vergence {

const char* describe(Status status) {
  switch (status) {
    case Status::kOk: return "ok";
    case Status::kBadCamera: return "the camera's focal length or image size is not usable";
    case Status::kBadModel:
      return "a radius, distance, sample count or tolerance of the model is outside its range";
    case Status::kBadRoi: return "the rectangle around the target is empty or reaches outside the photo";
    case Status::kTooManyPoints: return "the model has more points than the static limit";
    case Status::kNoHue:
      return "too few points of the target have a hue: the photo is grey, too dark or too bright";
    case Status::kBadSearchBox:
      return "the search box is empty, not finite or reaches outside the unit quaternions";
    case Status::kBadImage: return "the image has another size or format than the rig";
    case Status::kBadLimits:
      return "a limit of motion is not positive or not finite, its range is empty, or its jerk is too low";
    case Status::kBadArm:
      return "a joint count, link, joint limit or fixed transform of the arm is outside its range";
    case Status::kBadNumber:
      return "a pose, joint angle or velocity is not finite, or beyond what any arm does";
    case Status::kBadGains:
      return "a gain, noise or time constant of the control is not finite or outside its range";
  }
  return "unknown status";
}

}  // namespace vergence
