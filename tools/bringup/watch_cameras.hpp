// Gathers what the camera checks judge, with the controller's own capturing.
#pragma once

#include <cstdint>
#include <functional>

#include "hal/v4l2/v4l2_config.hpp"
#include "hal/v4l2/video_device.hpp"
#include "tools/bringup/camera_checks.hpp"

namespace vergence::tools {

// Opens both as the controller would, waits until they stream, watches them for so long, and closes them. A
// camera that is not there is waited for at most two seconds. now_ns: the clock of the system's poll().
[[nodiscard]] CameraObservation watch_cameras(v4l2::VideoSystem& system,
                                              const v4l2::StereoVideoConfig& config, double seconds,
                                              const std::function<std::int64_t()>& now_ns);

}  // namespace vergence::tools
