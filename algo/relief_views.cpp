// What the three views of a relief see of its points, and how they agree: left, right, photo.
#include <cmath>

#include "algo/colour_sampling-inl.hpp"
#include "algo/facing-inl.hpp"
#include "algo/projection-inl.hpp"
#include "algo/relief_parts.hpp"

HWY_BEFORE_NAMESPACE();
namespace vergence {
namespace {

constexpr float kChromaWeight = 2;

// Distorted normalized coordinates, OpenCV's five coefficients.
Vector2 distorted(const CameraModel& camera, double x, double y) {
  const auto& [k1, k2, p1, p2, k3] = camera.distortion;
  const double r2 = x * x + y * y;
  const double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  return {x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
          y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y};
}

// And their derivative.
Eigen::Matrix2d distortion_slope(const CameraModel& camera, double x, double y) {
  const auto& [k1, k2, p1, p2, k3] = camera.distortion;
  const double r2 = x * x + y * y;
  const double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  const double radial_slope = k1 + r2 * (2 * k2 + r2 * 3 * k3);  // d radial / d r2
  Eigen::Matrix2d derivative;
  derivative << radial + 2 * x * x * radial_slope + 2 * p1 * y + 6 * p2 * x,
      2 * x * y * radial_slope + 2 * p1 * x + 2 * p2 * y,  //
      2 * x * y * radial_slope + 2 * p1 * x + 2 * p2 * y,
      radial + 2 * y * y * radial_slope + 6 * p1 * y + 2 * p2 * x;
  return derivative;
}

// Where a camera sees a point of the target frame.
struct Place {
  double x;  // normalized, before the lens
  double y;
  double inverse_depth;
  double u_px;  // in the image, or at its border where it is not
  double v_px;
  bool visible;
};

struct Eye {
  Eye(const CameraModel& at_level, const ColourLevel& image, const Transform& T_H_M)
      : camera(at_level),
        last_u(image.width_px - 2.001),
        last_v(image.height_px - 2.001),
        T_C_M(target_in_camera(at_level, T_H_M)) {}

  [[nodiscard]] Place place_of(const Vector3& p) const {
    const Vector3 pc = T_C_M * p;
    const bool in_front = pc[2] >= kMinDepth_mm;
    const double inverse = 1 / (in_front ? pc[2] : kMinDepth_mm);
    const double x = pc[0] * inverse;
    const double y = pc[1] * inverse;
    const Vector2 xy = distorted(camera, x, y);
    const double u = camera.fx_px * xy[0] + camera.cx_px;
    const double v = camera.fy_px * xy[1] + camera.cy_px;
    const bool visible = in_front & (u >= 1) & (v >= 1) & (u <= last_u) & (v <= last_v);
    return {x, y, inverse, clamped(u, 1, last_u), clamped(v, 1, last_v), visible};
  }

  const CameraModel& camera;
  double last_u;
  double last_v;
  Transform T_C_M;
};

}  // namespace

std::array<float, 4> photo_colour(const PhotoModel& model, int level, int i) {
  const PointColours& colours = model.colour[at(level)];
  return {static_cast<float>(colours.luma[at(i)]) - 128.0F,
          kChromaWeight * (static_cast<float>(colours.cb[at(i)]) - 128.0F),
          kChromaWeight * (static_cast<float>(colours.cr[at(i)]) - 128.0F), 0.0F};
}

Vector3 Relief::point(int i, double z_mm) const {
  return {x_mm_[at(i)] + z_mm * ray_x_[at(i)], y_mm_[at(i)] + z_mm * ray_y_[at(i)], z_mm};
}

void Relief::sample(const Points& z_mm, const View& view, const Transform& T_H_M,
                    std::array<ReliefSample, kMaxReliefPoints>& samples) const {
  const Eye eye(view.camera, view.image, T_H_M);
  const Facing facing(eye.T_C_M);
  alignas(16) std::array<float, kMaxReliefPoints> faces;
  for (int i = 0; i < points_; i += kLanes) hn::Store(facing.of(view.normals, at(i)), d4, &faces[at(i)]);
  for (int i = 0; i < points_; ++i) {
    ReliefSample& sample = samples[at(i)];
    const Vector3 p = point(i, z_mm[at(i)]);
    const Place place = eye.place_of(p);
    sample.seen = place.visible ? is_target_[at(i)] * static_cast<double>(faces[at(i)]) : 0.0;
    sample_colour(view.image, static_cast<float>(place.u_px), static_cast<float>(place.v_px),
                  sample.value.data(), sample.slope_u.data(), sample.slope_v.data());
    const double inverse = place.inverse_depth;
    Eigen::Matrix<double, 2, 3> to_pixel;
    to_pixel << inverse, 0, -place.x * inverse, 0, inverse, -place.y * inverse;
    const Eigen::Matrix<double, 2, 3> A =
        distortion_slope(view.camera, place.x, place.y) * to_pixel * eye.T_C_M.R;
    const Vector3 ray = {ray_x_[at(i)], ray_y_[at(i)], 1};
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

void Relief::sample_colours(double z_mm, const View& view, const Transform& T_H_M,
                            std::array<ReliefSample, kMaxReliefPoints>& samples) const {
  const Transform T_C_M = target_in_camera(view.camera, T_H_M);
  const Facing facing(T_C_M);
  V4 R[3][3];
  V4 t[3];
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) R[r][c] = set(T_C_M.R(r, c));
    t[r] = set(T_C_M.t_mm[r]);
  }
  const V4 off = set(z_mm);
  const V4 nearest = set(kMinDepth_mm);
  const V4 first = set(1);
  const V4 last_u = set(view.image.width_px - 2.01);
  const V4 last_v = set(view.image.height_px - 2.01);
  for (int i = 0; i < points_; i += kLanes) {
    const V4 z = hn::Add(hn::Load(d4, &about_mm_[at(i)]), off);
    const V4 px = hn::Add(hn::Load(d4, &flat_x_mm_[at(i)]), hn::Mul(z, hn::Load(d4, &flat_ray_x_[at(i)])));
    const V4 py = hn::Add(hn::Load(d4, &flat_y_mm_[at(i)]), hn::Mul(z, hn::Load(d4, &flat_ray_y_[at(i)])));
    V4 c[3];
    for (int r = 0; r < 3; ++r) {
      c[r] = hn::Add(hn::Add(hn::Mul(R[r][0], px), hn::Mul(R[r][1], py)), hn::Add(hn::Mul(R[r][2], z), t[r]));
    }
    const auto in_front = hn::Ge(c[2], nearest);
    const V4 inverse = hn::Div(first, hn::IfThenElse(in_front, c[2], nearest));
    V4 x = hn::Mul(c[0], inverse);
    V4 y = hn::Mul(c[1], inverse);
    HWY_NAMESPACE::distort(d4, view.camera, x, y);
    const V4 u = hn::Add(hn::Mul(set(view.camera.fx_px), x), set(view.camera.cx_px));
    const V4 v = hn::Add(hn::Mul(set(view.camera.fy_px), y), set(view.camera.cy_px));
    const auto visible = hn::And(in_front, hn::And(hn::And(hn::Ge(u, first), hn::Le(u, last_u)),
                                                   hn::And(hn::Ge(v, first), hn::Le(v, last_v))));
    alignas(16) float at_u[kLanes];
    alignas(16) float at_v[kLanes];
    alignas(16) float seen[kLanes];
    hn::Store(hn::IfThenElse(visible, u, first), d4, at_u);
    hn::Store(hn::IfThenElse(visible, v, first), d4, at_v);
    hn::Store(hn::IfThenElseZero(visible, facing.of(view.normals, at(i))), d4, seen);
    for (int lane = 0; lane < kLanes; ++lane) {
      ReliefSample& sample = samples[at(i + lane)];
      sample.seen = is_target_[at(i + lane)] * static_cast<double>(seen[lane]);
      sample_value(view.image, at_u[lane], at_v[lane], sample.value.data());
    }
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
  for (int i = 0; i < points_; ++i) photo_[at(i)] = photo_colour(model, level, i);
  const auto left = [this](int i) { return left_[at(i)].value; };
  const auto right = [this](int i) { return right_[at(i)].value; };
  const auto photo = [this](int i) { return photo_[at(i)]; };
  const auto left_seen = [this](int i) { return left_[at(i)].seen; };
  const auto right_seen = [this](int i) { return right_[at(i)].seen; };
  const auto both_seen = [this](int i) { return left_[at(i)].seen * right_[at(i)].seen; };
  const auto fit_photo = [&] {
    light_[0] = fit_light(left, photo, left_seen);
    light_[1] = fit_light(right, photo, right_seen);
  };
  fit_photo();
  relight();
  fit_photo();
  light_[2] = fit_light(left, right, both_seen);
}

// Where the lamp has moved since the photo, shading drags points along with it: takes out of photo_ what
// varies slowly over the target. Both eyes see one surface, and have one say.
void Relief::relight() {
  constexpr double kStiffness = 3;  // of a node, in squared scales of residuals
  shade_.reset();
  double variance = 0;
  for (unsigned eye = 0; eye < 2; ++eye) {
    const Light& light = light_[eye];
    const double squared_scale = light.scale * light.scale;
    variance += 0.5 * squared_scale;
    for (int i = 0; i < points_; ++i) {
      const ReliefSample& sample = eye == 0 ? left_[at(i)] : right_[at(i)];
      const std::array<float, 4>& photo = photo_[at(i)];
      std::array<double, 3> residual;
      double squares = 0;
      for (unsigned c = 0; c < 3; ++c) {
        residual[c] = static_cast<double>(sample.value[c]) - light.gain * static_cast<double>(photo[c]) -
                      light.offset[c];
        squares += residual[c] * residual[c];
      }
      const double weight = sample.seen * squared_scale / (squared_scale + squares);  // Cauchy
      shade_.add(i, photo, light.gain, residual, weight);
    }
  }
  shade_.solve(kStiffness * variance);
  for (int i = 0; i < points_; ++i) photo_[at(i)] = shade_.relit(i, photo_[at(i)]);
}

void Relief::look(const StereoRig& rig, const ColourPyramid& left, const ColourPyramid& right, int level,
                  const PhotoModel& model, const Points& z_mm, const Transform& T_H_M) {
  sample(z_mm, {camera_at_level(rig.left, level), level_of(left, level), model.normals}, T_H_M, left_);
  sample(z_mm, {camera_at_level(rig.right, level), level_of(right, level), model.normals}, T_H_M, right_);
  fit_lights(model, level);
}

void Relief::glance(const StereoRig& rig, const ColourPyramid& left, const ColourPyramid& right, int level,
                    const PhotoModel& model, double z_mm, const Transform& T_H_M) {
  sample_colours(z_mm, {camera_at_level(rig.left, level), level_of(left, level), model.normals}, T_H_M,
                 left_);
  sample_colours(z_mm, {camera_at_level(rig.right, level), level_of(right, level), model.normals}, T_H_M,
                 right_);
}

Relief::PairingCosts Relief::costs() const {
  return {light_[0].cost, light_[1].cost, light_[2].cost};
}

double Relief::cost() const {
  return light_[0].cost + light_[1].cost + light_[2].cost;
}

}  // namespace vergence
HWY_AFTER_NAMESPACE();
