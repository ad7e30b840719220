// The evaluator written plainly: one sample at a time, straight from the equations. It is the oracle of the
// vector code, and the reference its speed is compared with.
#pragma once

#include <algorithm>
#include <cmath>

#include "algo/camera_model.hpp"
#include "algo/fitness.hpp"
#include "algo/hue.hpp"
#include "algo/target_model.hpp"

namespace vergence::reference {

// Hue code at image coordinates (u, v) in pixels, kHueOutside beside the image.
inline std::uint8_t hue_at(const HuePlane& plane, float u, float v) {
  const auto within = [](float x, int size) { return x >= -0.5F && x < static_cast<float>(size) - 0.5F; };
  if (!within(u, plane.width_px) || !within(v, plane.height_px)) return kHueOutside;
  const int column = static_cast<int>(std::nearbyint(u));  // ties to even
  const int row = static_cast<int>(std::nearbyint(v));
  return plane.code[static_cast<std::size_t>(row * plane.width_px + column)];
}

inline void distort(const CameraModel& camera, float& x, float& y) {
  float k[5];
  std::copy(camera.distortion.begin(), camera.distortion.end(), k);
  const float xx = x * x;
  const float yy = y * y;
  const float xy2 = 2.0F * (x * y);
  const float r2 = xx + yy;
  const float radial = ((k[4] * r2 + k[1]) * r2 + k[0]) * r2 + 1.0F;
  const float xd = x * radial + (k[2] * xy2 + k[3] * (r2 + 2.0F * xx));
  const float yd = y * radial + (k[2] * (r2 + 2.0F * yy) + k[3] * xy2);
  x = xd;
  y = yd;
}

inline std::int32_t marker_votes(const MarkerModel& model, const CameraModel& camera, const HuePlane& plane,
                                 const Transform& T_C_M) {
  std::int32_t votes = 0;
  for (unsigned b = 0; b < static_cast<unsigned>(model.balls); ++b) {
    const Vector3 centre = T_C_M * model.ball[b].centre_mm;
    const bool visible = centre[2] >= kMinDepth_mm;
    const double inverse = visible ? 1.0 / centre[2] : 0.0;
    const double x0 = centre[0] * inverse;
    const double y0 = centre[1] * inverse;
    const double r = model.ball[b].radius_mm * inverse;
    for (int i = 0; i < model.inner_samples + model.outer_samples; ++i) {
      const float px = model.pattern_x[static_cast<unsigned>(i)];
      const float py = model.pattern_y[static_cast<unsigned>(i)];
      std::uint8_t seen = kHueOutside;
      if (visible && camera.has_distortion()) {
        float x = static_cast<float>(x0) + static_cast<float>(r) * px;
        float y = static_cast<float>(y0) + static_cast<float>(r) * py;
        distort(camera, x, y);
        seen = hue_at(plane, x * static_cast<float>(camera.fx_px) + static_cast<float>(camera.cx_px),
                      y * static_cast<float>(camera.fy_px) + static_cast<float>(camera.cy_px));
      } else if (visible) {
        seen = hue_at(
            plane,
            static_cast<float>(camera.fx_px * x0 + camera.cx_px) + static_cast<float>(camera.fx_px * r) * px,
            static_cast<float>(camera.fy_px * y0 + camera.cy_px) + static_cast<float>(camera.fy_px * r) * py);
      }
      const int p = hue_distance(seen, model.hue[b]) <= model.tolerance[b] ? 1 : -1;
      votes += i < model.inner_samples ? p : -p;
    }
  }
  return votes;
}

inline std::int32_t photo_votes(const PhotoModel& model, const CameraModel& camera, const HuePlane& plane,
                                const Transform& T_C_M) {
  const PhotoVotes& w = model.votes;
  const int in_tolerance = hue_tolerance_steps(w.in_tolerance_deg);
  const int background_tolerance = hue_tolerance_steps(w.background_tolerance_deg);
  const int out_tolerance = hue_tolerance_steps(w.out_tolerance_deg);
  const bool distorted = camera.has_distortion();
  float P[3][4];
  for (int column = 0; column < 4; ++column) {
    const auto entry = [&](int row) { return column < 3 ? T_C_M.R(row, column) : T_C_M.t_mm[row]; };
    const double depth = entry(2);
    P[0][column] = static_cast<float>(distorted ? entry(0) : camera.fx_px * entry(0) + camera.cx_px * depth);
    P[1][column] = static_cast<float>(distorted ? entry(1) : camera.fy_px * entry(1) + camera.cy_px * depth);
    P[2][column] = static_cast<float>(depth);
  }
  std::int32_t votes = 0;
  for (unsigned i = 0; i < static_cast<unsigned>(model.points()); ++i) {
    const auto row = [&](int r) {
      return (P[r][0] * model.x_mm[i] + P[r][1] * model.y_mm[i]) + (P[r][2] * model.z_mm[i] + P[r][3]);
    };
    std::uint8_t seen = kHueOutside;
    const float depth = row(2);
    if (depth >= static_cast<float>(kMinDepth_mm)) {
      const float inverse = 1.0F / depth;
      float u = row(0) * inverse;
      float v = row(1) * inverse;
      if (distorted) {
        distort(camera, u, v);
        u = u * static_cast<float>(camera.fx_px) + static_cast<float>(camera.cx_px);
        v = v * static_cast<float>(camera.fy_px) + static_cast<float>(camera.cy_px);
      }
      seen = hue_at(plane, u, v);
    }
    if (static_cast<int>(i) < model.inner) {
      if (hue_distance(seen, model.hue[i]) <= in_tolerance) {
        votes += w.in_match;
      } else if (hue_distance(seen, model.background_hue) <= background_tolerance) {
        votes += w.in_background;
      } else {
        votes += w.in_other;
      }
    } else {
      votes += hue_distance(seen, model.background_hue) <= out_tolerance ? w.out_background : w.out_other;
    }
  }
  return votes;
}

}  // namespace vergence::reference
