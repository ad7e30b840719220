// The names of devices.env, which is where to change them.
#pragma once

namespace vergence::rig {

inline constexpr const char* kCameras[] = {RIG_LEFT_CAMERA, RIG_RIGHT_CAMERA};  // left, right
inline constexpr const char* kDisplays[] = {RIG_LEFT_DISPLAY, RIG_RIGHT_DISPLAY};
inline constexpr int kCameraInput = RIG_CAMERA_INPUT;
inline constexpr int kDisplayOutput = RIG_DISPLAY_OUTPUT;
inline constexpr const char* kCan = RIG_CAN;
inline constexpr const char* kGpioChip = RIG_GPIO_CHIP;
// Of all lines by their offset, separated by blanks.
inline constexpr const char* kGpioLines = RIG_GPIO_LINES;

}  // namespace vergence::rig
