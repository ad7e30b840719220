#include "algo/refine.hpp"

#include <Eigen/Cholesky>
#include <cmath>

namespace vergence {
namespace {

constexpr double kMaxStep_mm = 15;
constexpr double kMaxStep_rad = 0.15;
constexpr double kChromaWeight = 2;

using Vector10 = Eigen::Matrix<double, 10, 1>;
using Matrix10 = Eigen::Matrix<double, 10, 10>;

Vector3 colour_of(ColourPixel pixel) {
  return {static_cast<double>(pixel & 0xFF) - 128,
          kChromaWeight * (static_cast<double>((pixel >> 8) & 0xFF) - 128),
          kChromaWeight * (static_cast<double>((pixel >> 16) & 0xFF) - 128)};
}

double clamped(double value, double low, double high) {
  const double at_least = value > low ? value : low;  // NaN becomes low
  return at_least < high ? at_least : high;
}

// Colour and slopes at (u, v), bilinear, slopes from central differences. Needs a border of one pixel.
void sample_colour(const ColourLevel& image, double u, double v, RefineSample& out) {
  const int x = static_cast<int>(u);
  const int y = static_cast<int>(v);
  const double fu = u - x;
  const double fv = v - y;
  Vector3 c[4][4];  // [row][column], from (x - 1, y - 1)
  for (int j = 0; j < 4; ++j) {
    const ColourPixel* row = image.pixel + static_cast<std::ptrdiff_t>(y - 1 + j) * image.width_px + (x - 1);
    for (int i = 0; i < 4; ++i) c[j][i] = colour_of(row[i]);
  }
  const auto blend = [&](const Vector3& a00, const Vector3& a10, const Vector3& a01,
                         const Vector3& a11) -> Vector3 {
    return (a00 * (1 - fu) + a10 * fu) * (1 - fv) + (a01 * (1 - fu) + a11 * fu) * fv;
  };
  out.value = blend(c[1][1], c[1][2], c[2][1], c[2][2]);
  out.slope_u = 0.5 * blend(c[1][2] - c[1][0], c[1][3] - c[1][1], c[2][2] - c[2][0], c[2][3] - c[2][1]);
  out.slope_v = 0.5 * blend(c[2][1] - c[0][1], c[2][2] - c[0][2], c[3][1] - c[1][1], c[3][2] - c[1][2]);
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

void sample_points(const PhotoModel& model, int points, const CameraModel& camera, const ColourLevel& image,
                   const Transform& T_H_M, RefineSample* samples) {
  const Transform T_C_M = target_in_camera(camera, T_H_M);
  for (int i = 0; i < points; ++i) {
    const auto k = static_cast<unsigned>(i);
    RefineSample& sample = samples[i];
    const Vector3 p{model.x_mm[k], model.y_mm[k], model.z_mm[k]};
    const Vector3 pc = T_C_M * p;
    // What is not in the image is sampled at its border all the same and gets no weight: equal work for all.
    const bool in_front = pc[2] >= kMinDepth_mm;
    const double inverse = 1 / (in_front ? pc[2] : kMinDepth_mm);
    const double x = pc[0] * inverse;
    const double y = pc[1] * inverse;
    Vector2 xy;
    Eigen::Matrix2d lens;
    distort(camera, x, y, xy, lens);
    const double u = camera.fx_px * xy[0] + camera.cx_px;
    const double v = camera.fy_px * xy[1] + camera.cy_px;
    const double last_u = image.width_px - 2.001;
    const double last_v = image.height_px - 2.001;
    sample.visible = in_front & (u >= 1) & (v >= 1) & (u <= last_u) & (v <= last_v);
    sample_colour(image, clamped(u, 1, last_u), clamped(v, 1, last_v), sample);
    // p_C changes by R (dt - p x dw); so does the ray, and so the pixel.
    Eigen::Matrix<double, 2, 3> ray;
    ray << inverse, 0, -x * inverse, 0, inverse, -y * inverse;
    const Eigen::Matrix<double, 2, 3> A = lens * ray * T_C_M.R;
    const auto row = [&](int r, double focal_px) {
      const Vector3 a = focal_px * A.row(r).transpose();
      Vector6 g;
      g << a, p[1] * a[2] - p[2] * a[1], p[2] * a[0] - p[0] * a[2], p[0] * a[1] - p[1] * a[0];
      return g;
    };
    sample.du = row(0, camera.fx_px);
    sample.dv = row(1, camera.fy_px);
  }
}

// One pairing: how b explains a, a = gain b + offset, over points with weight one (seen) or zero.
struct Pairing {
  double gain;
  Vector3 offset;
  double deviation;  // mean absolute residual
  double spread;     // standard deviation of a
  bool usable;
};

template <class A, class B, class Seen>
Pairing fit_light(int points, A&& a, B&& b, Seen&& seen) {
  double n = 0;
  Vector3 sum_a = Vector3::Zero();
  Vector3 sum_b = Vector3::Zero();
  double aa = 0;
  double bb = 0;
  double ab = 0;
  for (int i = 0; i < points; ++i) {
    const double w = seen(i);
    n += w;
    sum_a += w * a(i);
    sum_b += w * b(i);
    aa += w * a(i).squaredNorm();
    bb += w * b(i).squaredNorm();
    ab += w * a(i).dot(b(i));
  }
  Pairing pair{};
  pair.usable = n >= 16;
  const double count = n > 1 ? n : 1;
  const double gain = (ab - sum_a.dot(sum_b) / count) / (bb - sum_b.squaredNorm() / count + 1e-6);
  pair.gain = clamped(gain, 0.05, 20);
  pair.offset = (sum_a - pair.gain * sum_b) / count;
  double deviation = 0;
  for (int i = 0; i < points; ++i) {
    deviation += seen(i) * (a(i) - pair.gain * b(i) - pair.offset).cwiseAbs().sum();
  }
  pair.deviation = deviation / (3 * count);
  const double variance = (aa - sum_a.squaredNorm() / count) / (3 * count);
  pair.spread = std::sqrt(variance > 0 ? variance : 0);
  return pair;
}

// Adds a pairing's normal equations in the six pose unknowns, its gain and offsets eliminated (Schur
// complement).
template <class A, class B, class Seen, class Row>
void add_pairing(int points, A&& a, B&& b, Seen&& seen, Row&& row, Matrix6& H, Vector6& g) {
  constexpr double kUnitOfGain = 50;  // brings the gain's column to the size of the others
  const Pairing pair = fit_light(points, a, b, seen);
  const double scale = 1.5 * pair.deviation + 0.5;  // residuals much beyond it count little
  Matrix10 N = Matrix10::Zero();
  Vector10 q = Vector10::Zero();
  for (int i = 0; i < points; ++i) {
    const auto& values = b(i);
    const Vector3 residuals = a(i) - pair.gain * values - pair.offset;
    for (int c = 0; c < 3; ++c) {
      const double r = residuals[c];
      const double w = seen(i) / (scale * scale + r * r);  // Cauchy
      Eigen::Matrix<double, 8, 1> J;
      J << row(i, c, pair.gain), -values[c] / kUnitOfGain, -1;
      const Eigen::Matrix<double, 8, 1> wJ = w * J;
      // Columns 0..6 are common; column 7 of J is the offset of channel c, at 7 + c.
      for (int k = 0; k < 7; ++k) {
        for (int l = 0; l <= k; ++l) N(k, l) += wJ[k] * J[l];
        N(7 + c, k) += wJ[7] * J[k];
        q[k] -= wJ[k] * r;
      }
      N(7 + c, 7 + c) += wJ[7] * J[7];
      q[7 + c] -= wJ[7] * r;
    }
  }
  if (!pair.usable) return;
  N.triangularView<Eigen::StrictlyUpper>() = N.transpose();
  Eigen::Matrix4d L = N.bottomRightCorner<4, 4>();
  for (int k = 0; k < 4; ++k) L(k, k) += 1e-6 * L(k, k) + 1e-9;
  const Eigen::LDLT<Eigen::Matrix4d> light(L);
  const Eigen::Matrix<double, 4, 6> E = N.bottomLeftCorner<4, 6>();
  H += N.topLeftCorner<6, 6>() - E.transpose() * light.solve(E);
  g += q.head<6>() - E.transpose() * light.solve(Eigen::Vector4d(q.tail<4>()));
}

// What both functions below work on: one level of everything.
struct Level {
  Level(const PhotoModel& photo_model, const StereoRig& rig, const ColourPyramid& left,
        const ColourPyramid& right, int level, int wanted_points, RefineWorkspace& space)
      : model(photo_model),
        colours(photo_model.colour[static_cast<unsigned>(level)]),
        camera_left(camera_at_level(rig.left, level)),
        camera_right(camera_at_level(rig.right, level)),
        image_left(level_of(left, level)),
        image_right(level_of(right, level)),
        workspace(space) {
    const int limited = wanted_points < kMaxRefinePoints ? wanted_points : kMaxRefinePoints;
    points = limited < model.inner ? limited : model.inner;
  }

  void sample(const Transform& T_H_M) const {
    sample_points(model, points, camera_left, image_left, T_H_M, workspace.left.data());
    sample_points(model, points, camera_right, image_right, T_H_M, workspace.right.data());
  }

  [[nodiscard]] const RefineSample& left(int i) const { return workspace.left[static_cast<unsigned>(i)]; }
  [[nodiscard]] const RefineSample& right(int i) const { return workspace.right[static_cast<unsigned>(i)]; }
  [[nodiscard]] Vector3 photo(int i) const {
    const auto k = static_cast<unsigned>(i);
    return {colours.luma[k] - 128.0, kChromaWeight * (colours.cb[k] - 128.0),
            kChromaWeight * (colours.cr[k] - 128.0)};
  }

  // Calls f(a, b, seen, row of the residual's slope) for each of the three pairings.
  template <class F>
  void for_each_pairing(F&& f) const {
    const auto slope = [](const RefineSample& s, int c) -> Vector6 {
      return s.slope_u[c] * s.du + s.slope_v[c] * s.dv;
    };
    const auto value_left = [this](int i) -> const Vector3& { return left(i).value; };
    const auto value_right = [this](int i) -> const Vector3& { return right(i).value; };
    const auto of_photo = [this](int i) { return photo(i); };
    f(
        value_left, of_photo, [this](int i) { return left(i).visible ? 1.0 : 0.0; },
        [&](int i, int c, double) { return slope(left(i), c); });
    f(
        value_right, of_photo, [this](int i) { return right(i).visible ? 1.0 : 0.0; },
        [&](int i, int c, double) { return slope(right(i), c); });
    f(
        value_left, value_right, [this](int i) { return left(i).visible && right(i).visible ? 1.0 : 0.0; },
        [&](int i, int c, double gain) -> Vector6 { return slope(left(i), c) - gain * slope(right(i), c); });
  }

  const PhotoModel& model;
  const PointColours& colours;
  CameraModel camera_left;
  CameraModel camera_right;
  ColourLevel image_left;
  ColourLevel image_right;
  RefineWorkspace& workspace;
  int points;
};

Vector3 limited(const Vector3& step, double limit) {
  const double length = std::sqrt(step.squaredNorm());
  return length > limit ? Vector3(step * (limit / length)) : step;
}

}  // namespace

double alignment_cost(const PhotoModel& model, const StereoRig& rig, const ColourPyramid& left,
                      const ColourPyramid& right, int level, int points, RefineWorkspace& workspace,
                      const Transform& T_H_M) {
  constexpr double kNoise = 4;       // spread of a bare wall
  constexpr double kUnusable = 1.0;  // as bad as an unrelated place
  const Level at(model, rig, left, right, level, points, workspace);
  at.sample(T_H_M);
  double cost = 0;
  at.for_each_pairing([&](auto&& a, auto&& b, auto&& seen, auto&&) {
    const Pairing pair = fit_light(at.points, a, b, seen);
    cost += pair.usable ? pair.deviation / (pair.spread + kNoise) : kUnusable;
  });
  return cost;
}

void refine_photo_pose(const PhotoModel& model, const StereoRig& rig, const ColourPyramid& left,
                       const ColourPyramid& right, const RefinePass& pass, RefineWorkspace& workspace,
                       Transform& T_H_M) {
  const Level at(model, rig, left, right, pass.level, pass.points, workspace);
  for (int iteration = 0; iteration < pass.iterations; ++iteration) {
    at.sample(T_H_M);
    Matrix6 H = Matrix6::Zero();
    Vector6 g = Vector6::Zero();
    at.for_each_pairing(
        [&](auto&& a, auto&& b, auto&& seen, auto&& row) { add_pairing(at.points, a, b, seen, row, H, g); });
    for (int k = 0; k < 6; ++k) H(k, k) += 1e-4 * H(k, k) + 1e-9;
    const Vector6 step = H.ldlt().solve(g);
    const Vector3 move = limited(step.head<3>(), kMaxStep_mm);
    const Vector3 turn = limited(step.tail<3>(), kMaxStep_rad);
    // A small turn w is the quaternion vector w / 2, to third order; exactness does not matter to an
    // iteration.
    T_H_M = T_H_M * Transform{rotation_from_quaternion_vector(turn * 0.5), move};
    // Rounding must not build up: back through the quaternion to an exact rotation.
    T_H_M.R = rotation_from_quaternion_vector(quaternion_vector_from_rotation(T_H_M.R));
  }
}

}  // namespace vergence
