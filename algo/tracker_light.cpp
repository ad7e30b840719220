// Hues that follow the light: learned from pixels of the target, handed to the votes.
#include "algo/tracker_parts.hpp"

namespace vergence {

// Learns, from the pixels that show the target, how the light shifts its hues.
void Tracker::follow_light(const Transform& T_H_M) {
  const bool tracked = state_ == TrackState::kTracking;
  if (tracked && kind_ == TargetKind::kMarker) {
    observe_light(marker_, marker_hue_, marker_sight(true), marker_sight(false), marker_fit_, light_);
  }
  if (tracked && kind_ == TargetKind::kPhoto) {
    for (const bool of_left : {true, false}) {
      const CameraModel& camera = of_left ? rig_.left : rig_.right;
      const HuePlane& plane = of_left ? hue_left_ : hue_right_;
      const Transform T_C_M = target_in_camera(camera, T_H_M);
      for (unsigned i = 0; i < at(photo_.inner); ++i) {
        Vector2 uv{-1, -1};
        const Vector3 p = T_C_M * Vector3(photo_.x_mm[i], photo_.y_mm[i], photo_.z_mm[i]);
        const bool inside = project(camera, p, uv) && uv[0] >= 0 && uv[1] >= 0 &&
                            uv[0] <= plane.width_px - 1 && uv[1] <= plane.height_px - 1;
        const int index = inside
                              ? static_cast<int>(uv[1] + 0.5) * plane.width_px + static_cast<int>(uv[0] + 0.5)
                              : plane.outside_index();
        light_.observe(hue_sector(photo_hue_[i]), photo_hue_[i], plane.code[at(index)]);
      }
    }
  }
  light_.end_frame(tracked);
  expect_light();
}

void Tracker::expect_light() {
  for (int ball = 0; ball < marker_.balls; ++ball) {
    marker_.hue[at(ball)] = light_.expected(ball, marker_hue_[at(ball)]);
  }
  for (unsigned i = 0; i < at(photo_.points()); ++i) {
    photo_.hue[i] = light_.expected(hue_sector(photo_hue_[i]), photo_hue_[i]);
  }
  photo_.background_hue = light_.expected(hue_sector(photo_background_hue_), photo_background_hue_);
}

}  // namespace vergence
