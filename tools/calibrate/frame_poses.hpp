// Where the target was seen, frame by frame, with the cameras' stamps.
#pragma once

#include <filesystem>
#include <vector>

#include "tools/calibrate/hand_poses.hpp"

namespace vergence::calibrate {

struct FramePoses {
  std::filesystem::path file;
  std::vector<TimedPose> poses;  // by rising time
};

// Of frames.csv (t_s,x_mm,y_mm,z_mm,e1,e2,e3), or of frames.jsonl as `vergence estimate --json` writes it: of
// that the tracked frames, at the stamps of stamps.csv (frame,t_s) where the folder has one, else at their
// t_s. Throws InputError.
[[nodiscard]] FramePoses read_frame_poses(const std::filesystem::path& directory);

}  // namespace vergence::calibrate
