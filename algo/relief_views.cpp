// What the three views of a relief see of its points, and how they agree: left, right, photo.
#include <cmath>
#include <cstddef>

#include "algo/relief_parts.hpp"

namespace vergence {
namespace {

constexpr float kChromaWeight = 2;

std::array<float, 4> colour_of(ColourPixel pixel) {
  return {static_cast<float>(pixel & 0xFF) - 128.0F,
          kChromaWeight * (static_cast<float>((pixel >> 8) & 0xFF) - 128.0F),
          kChromaWeight * (static_cast<float>((pixel >> 16) & 0xFF) - 128.0F), 0.0F};
}

// Colour and slopes at (u, v), bilinear, slopes from central differences. Needs a border of one pixel.
void sample_colour(const ColourLevel& image, double u, double v, ReliefSample& out) {
  const int x = static_cast<int>(u);
  const int y = static_cast<int>(v);
  const auto fu = static_cast<float>(u - x);
  const auto fv = static_cast<float>(v - y);
  std::array<float, 4> c[4][4];  // [row][column], from (x - 1, y - 1)
  for (int j = 0; j < 4; ++j) {
    const ColourPixel* row = image.pixel + static_cast<std::ptrdiff_t>(y - 1 + j) * image.width_px + (x - 1);
    for (int i = 0; i < 4; ++i) c[j][i] = colour_of(row[i]);
  }
  const float w00 = (1 - fu) * (1 - fv);
  const float w10 = fu * (1 - fv);
  const float w01 = (1 - fu) * fv;
  const float w11 = fu * fv;
  for (unsigned k = 0; k < 4; ++k) {
    out.value[k] = c[1][1][k] * w00 + c[1][2][k] * w10 + c[2][1][k] * w01 + c[2][2][k] * w11;
    out.slope_u[k] = 0.5F * ((c[1][2][k] - c[1][0][k]) * w00 + (c[1][3][k] - c[1][1][k]) * w10 +
                             (c[2][2][k] - c[2][0][k]) * w01 + (c[2][3][k] - c[2][1][k]) * w11);
    out.slope_v[k] = 0.5F * ((c[2][1][k] - c[0][1][k]) * w00 + (c[2][2][k] - c[0][2][k]) * w10 +
                             (c[3][1][k] - c[1][1][k]) * w01 + (c[3][2][k] - c[1][2][k]) * w11);
  }
}

// Distorted normalized coordinates and their derivative, OpenCV's five coefficients.
void distort(const CameraModel& camera, double x, double y, Vector2& xy, Eigen::Matrix2d& derivative) {
  const auto& [k1, k2, p1, p2, k3] = camera.distortion;
  const double r2 = x * x + y * y;
  const double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  const double radial_slope = k1 + r2 * (2 * k2 + r2 * 3 * k3);  // d radial / d r2
  xy = {x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
        y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y};
  derivative << radial + 2 * x * x * radial_slope + 2 * p1 * y + 6 * p2 * x,
      2 * x * y * radial_slope + 2 * p1 * x + 2 * p2 * y,  //
      2 * x * y * radial_slope + 2 * p1 * x + 2 * p2 * y,
      radial + 2 * y * y * radial_slope + 6 * p1 * y + 2 * p2 * x;
}

}  // namespace

std::array<float, 4> photo_colour(const PhotoModel& model, int level, int i) {
  const PointColours& colours = model.colour[at(level)];
  return {static_cast<float>(colours.luma[at(i)]) - 128.0F,
          kChromaWeight * (static_cast<float>(colours.cb[at(i)]) - 128.0F),
          kChromaWeight * (static_cast<float>(colours.cr[at(i)]) - 128.0F), 0.0F};
}

Vector3 ray_of(const PhotoModel& model, double x_mm, double y_mm) {
  const Vector3 from_centre = Vector3{x_mm, y_mm, 0} - model.optical_centre_mm;
  return from_centre / from_centre[2];
}

void Relief::sample(const PhotoModel& model, const Points& z_mm, const View& view, const Transform& T_H_M,
                    std::array<ReliefSample, kMaxReliefPoints>& samples) const {
  const Transform T_C_M = target_in_camera(view.camera, T_H_M);
  const double last_u = view.image.width_px - 2.001;
  const double last_v = view.image.height_px - 2.001;
  for (int i = 0; i < points_; ++i) {
    ReliefSample& sample = samples[at(i)];
    const Vector3 ray = ray_of(model, x_mm_[at(i)], y_mm_[at(i)]);
    const Vector3 p = Vector3{x_mm_[at(i)], y_mm_[at(i)], 0} + z_mm[at(i)] * ray;
    const Vector3 pc = T_C_M * p;
    const bool in_front = pc[2] >= kMinDepth_mm;
    const double inverse = 1 / (in_front ? pc[2] : kMinDepth_mm);
    const double x = pc[0] * inverse;
    const double y = pc[1] * inverse;
    Vector2 xy;
    Eigen::Matrix2d lens;
    distort(view.camera, x, y, xy, lens);
    const double u = view.camera.fx_px * xy[0] + view.camera.cx_px;
    const double v = view.camera.fy_px * xy[1] + view.camera.cy_px;
    const bool visible = in_front & (u >= 1) & (v >= 1) & (u <= last_u) & (v <= last_v);
    sample.seen = visible ? is_target_[at(i)] : 0.0;
    sample_colour(view.image, clamped(u, 1, last_u), clamped(v, 1, last_v), sample);
    Eigen::Matrix<double, 2, 3> to_pixel;
    to_pixel << inverse, 0, -x * inverse, 0, inverse, -y * inverse;
    const Eigen::Matrix<double, 2, 3> A = lens * to_pixel * T_C_M.R;
    const auto row = [&](int r, double focal_px) -> std::array<double, 7> {
      const Vector3 a = focal_px * A.row(r).transpose();
      return {a[0],
              a[1],
              a[2],
              p[1] * a[2] - p[2] * a[1],
              p[2] * a[0] - p[0] * a[2],
              p[0] * a[1] - p[1] * a[0],
              a.dot(ray)};
    };
    sample.du = row(0, view.camera.fx_px);
    sample.dv = row(1, view.camera.fy_px);
  }
}

// a = gain b + offset over the points that are seen.
template <class A, class B, class Seen>
Relief::Light Relief::fit_light(A&& a, B&& b, Seen&& seen) const {
  constexpr double kNoise = 4;  // spread of a bare wall
  double n = 0;
  std::array<double, 3> sum_a{};
  std::array<double, 3> sum_b{};
  double aa = 0;
  double bb = 0;
  double ab = 0;
  for (int i = 0; i < points_; ++i) {
    const double w = seen(i);
    const std::array<float, 4> va = a(i);
    const std::array<float, 4> vb = b(i);
    n += w;
    for (unsigned c = 0; c < 3; ++c) {
      const double ca = va[c];
      const double cb = vb[c];
      sum_a[c] += w * ca;
      sum_b[c] += w * cb;
      aa += w * ca * ca;
      bb += w * cb * cb;
      ab += w * ca * cb;
    }
  }
  Light light;
  const double count = n > 1 ? n : 1;
  for (unsigned c = 0; c < 3; ++c) {
    aa -= sum_a[c] * sum_a[c] / count;
    bb -= sum_b[c] * sum_b[c] / count;
    ab -= sum_a[c] * sum_b[c] / count;
  }
  light.gain = clamped(ab / (bb + 1e-6), 0.05, 20);
  for (unsigned c = 0; c < 3; ++c) light.offset[c] = (sum_a[c] - light.gain * sum_b[c]) / count;
  double deviation = 0;
  for (int i = 0; i < points_; ++i) {
    const double w = seen(i);
    const std::array<float, 4> va = a(i);
    const std::array<float, 4> vb = b(i);
    for (unsigned c = 0; c < 3; ++c) {
      const double r = va[c] - light.gain * vb[c] - light.offset[c];
      deviation += w * (r < 0 ? -r : r);
    }
  }
  deviation /= 3 * count;
  light.scale = 1.5 * deviation + 0.5;
  light.cost = deviation / (std::sqrt(aa > 0 ? aa / (3 * count) : 0) + kNoise);
  return light;
}

void Relief::fit_lights(const PhotoModel& model, int level) {
  const auto left = [this](int i) { return left_[at(i)].value; };
  const auto right = [this](int i) { return right_[at(i)].value; };
  const auto photo = [&](int i) { return photo_colour(model, level, i); };
  const auto left_seen = [this](int i) { return left_[at(i)].seen; };
  const auto right_seen = [this](int i) { return right_[at(i)].seen; };
  const auto both_seen = [this](int i) { return left_[at(i)].seen * right_[at(i)].seen; };
  light_[0] = fit_light(left, photo, left_seen);
  light_[1] = fit_light(right, photo, right_seen);
  light_[2] = fit_light(left, right, both_seen);
}

void Relief::look(const StereoRig& rig, const ColourPyramid& left, const ColourPyramid& right, int level,
                  const PhotoModel& model, const Points& z_mm, const Transform& T_H_M) {
  sample(model, z_mm, {camera_at_level(rig.left, level), level_of(left, level)}, T_H_M, left_);
  sample(model, z_mm, {camera_at_level(rig.right, level), level_of(right, level)}, T_H_M, right_);
  fit_lights(model, level);
}

double Relief::cost() const {
  return light_[0].cost + light_[1].cost + light_[2].cost;
}

}  // namespace vergence
