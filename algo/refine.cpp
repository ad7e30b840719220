// Dense alignment. Points go four at a time in single precision, in vectors of four lanes on every machine:
// sums of floats depend on their order, so the order must not depend on the width of the vectors.
#include "algo/refine.hpp"

#include <hwy/highway.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <cstddef>

#include "algo/colour_sampling-inl.hpp"
#include "algo/facing-inl.hpp"
#include "algo/pose_covariance.hpp"

HWY_BEFORE_NAMESPACE();
namespace vergence {
namespace {

constexpr double kMaxStep_mm = 15;
constexpr double kMaxStep_rad = 0.15;
constexpr int kChannels = 3;
constexpr int kMinPoints = 16;  // that a pairing must see to have a say

// Pose, gain, and an offset a channel.
constexpr int kUnknowns = 10;
using Vector10 = Eigen::Matrix<double, kUnknowns, 1>;
using Matrix10 = Eigen::Matrix<double, kUnknowns, kUnknowns>;

double sum_of(V4 v) {
  alignas(16) float lane[kLanes];
  hn::Store(v, d4, lane);
  return (double{lane[0]} + double{lane[1]}) + (double{lane[2]} + double{lane[3]});
}

double clamped(double value, double low, double high) {
  const double at_least = value > low ? value : low;  // NaN becomes low
  return at_least < high ? at_least : high;
}

// ---- Sampling -------------------------------------------------------------------------------------------

// A camera before a posed model, in single precision.
struct View {
  View(const CameraModel& at_level, const ColourLevel& level, const Transform& T_C_M)
      : camera(at_level), image(level), facing(T_C_M), distorted(at_level.has_distortion()) {
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) R[r][c] = set(T_C_M.R(r, c));
      t[r] = set(T_C_M.t_mm[r]);
    }
  }

  const CameraModel& camera;
  ColourLevel image;
  Facing facing;
  bool distorted;
  V4 R[3][3];
  V4 t[3];
};

// Where a camera sees four points, and how that changes with the pose increment.
struct Projection {
  // Written out, because GCC compiles an implicit one without the vector target of this file.
  Projection() {}  // NOLINT(modernize-use-equals-default,cppcoreguidelines-pro-type-member-init)
  V4 u;
  V4 v;
  V4 du[6];
  V4 dv[6];
  hn::Mask<D4> in_front;
};

// Distorted normalized coordinates and their derivative (symmetric but for its diagonal), OpenCV's five
// coefficients.
void distort(const CameraModel& camera, V4& x, V4& y, V4& dxx, V4& dxy, V4& dyy) {
  const auto& [k1, k2, p1, p2, k3] = camera.distortion;
  const V4 one = set(1);
  const V4 xx = hn::Mul(x, x);
  const V4 yy = hn::Mul(y, y);
  const V4 xy = hn::Mul(x, y);
  const V4 r2 = hn::Add(xx, yy);
  const V4 radial =
      hn::Add(one, hn::Mul(r2, hn::Add(set(k1), hn::Mul(r2, hn::Add(set(k2), hn::Mul(r2, set(k3)))))));
  // 2 d radial / d r2
  const V4 slope = hn::Add(set(2 * k1), hn::Mul(r2, hn::Add(set(4 * k2), hn::Mul(r2, set(6 * k3)))));
  const V4 px = hn::Mul(set(2 * p1), x);
  const V4 py = hn::Mul(set(2 * p1), y);
  const V4 qx = hn::Mul(set(2 * p2), x);
  const V4 qy = hn::Mul(set(2 * p2), y);
  dxx = hn::Add(hn::Add(radial, hn::Mul(xx, slope)), hn::Add(py, hn::Mul(set(3), qx)));
  dxy = hn::Add(hn::Mul(xy, slope), hn::Add(px, qy));
  dyy = hn::Add(hn::Add(radial, hn::Mul(yy, slope)), hn::Add(hn::Mul(set(3), py), qx));
  const V4 xd = hn::Add(hn::Mul(x, radial),
                        hn::Add(hn::Mul(py, x), hn::Mul(set(p2), hn::Add(r2, hn::Mul(set(2), xx)))));
  const V4 yd = hn::Add(hn::Mul(y, radial),
                        hn::Add(hn::Mul(qx, y), hn::Mul(set(p1), hn::Add(r2, hn::Mul(set(2), yy)))));
  x = xd;
  y = yd;
}

Projection project_four(const View& view, const PhotoModel& model, int i) {
  const auto k = static_cast<std::size_t>(i);
  const V4 p[3] = {hn::LoadU(d4, model.x_mm.data() + k), hn::LoadU(d4, model.y_mm.data() + k),
                   hn::LoadU(d4, model.z_mm.data() + k)};
  V4 c[3];
  for (int r = 0; r < 3; ++r) {
    c[r] = hn::Add(hn::Add(hn::Mul(view.R[r][0], p[0]), hn::Mul(view.R[r][1], p[1])),
                   hn::Add(hn::Mul(view.R[r][2], p[2]), view.t[r]));
  }
  Projection result;
  const V4 nearest = set(kMinDepth_mm);
  result.in_front = hn::Ge(c[2], nearest);
  const V4 inverse = hn::Div(set(1), hn::IfThenElse(result.in_front, c[2], nearest));
  V4 x = hn::Mul(c[0], inverse);
  V4 y = hn::Mul(c[1], inverse);
  // p_C changes by R (dt - p x dw); so does the ray, (R_0 - x R_2) / z and (R_1 - y R_2) / z, and so the
  // pixel.
  V4 ray_u[3];
  V4 ray_v[3];
  for (int j = 0; j < 3; ++j) {
    ray_u[j] = hn::Mul(inverse, hn::Sub(view.R[0][j], hn::Mul(x, view.R[2][j])));
    ray_v[j] = hn::Mul(inverse, hn::Sub(view.R[1][j], hn::Mul(y, view.R[2][j])));
  }
  if (view.distorted) {
    V4 dxx;
    V4 dxy;
    V4 dyy;
    distort(view.camera, x, y, dxx, dxy, dyy);
    for (int j = 0; j < 3; ++j) {
      const V4 along_u = hn::Add(hn::Mul(dxx, ray_u[j]), hn::Mul(dxy, ray_v[j]));
      ray_v[j] = hn::Add(hn::Mul(dxy, ray_u[j]), hn::Mul(dyy, ray_v[j]));
      ray_u[j] = along_u;
    }
  }
  const V4 fx = set(view.camera.fx_px);
  const V4 fy = set(view.camera.fy_px);
  result.u = hn::Add(hn::Mul(fx, x), set(view.camera.cx_px));
  result.v = hn::Add(hn::Mul(fy, y), set(view.camera.cy_px));
  const auto fill = [&](V4* g, const V4* ray, V4 focal) {
    for (int j = 0; j < 3; ++j) g[j] = hn::Mul(focal, ray[j]);
    for (int j = 0; j < 3; ++j) {  // p x g
      const int a = (j + 1) % 3;
      const int b = (j + 2) % 3;
      g[3 + j] = hn::Sub(hn::Mul(p[a], g[b]), hn::Mul(p[b], g[a]));
    }
  };
  fill(result.du, ray_u, fx);
  fill(result.dv, ray_v, fy);
  return result;
}

void sample_points(const PhotoModel& model, int points, const View& view, RefineSamples& samples) {
  const V4 last_u = set(view.image.width_px - 2.01);
  const V4 last_v = set(view.image.height_px - 2.01);
  const V4 first = set(1);
  const hn::FixedTag<std::uint8_t, kLanes> d8;
  const hn::FixedTag<std::int32_t, kLanes> d32;
  for (int i = 0; i < points; i += kLanes) {
    const auto k = static_cast<std::size_t>(i);
    const Projection at = project_four(view, model, i);
    const auto visible = hn::And(at.in_front, hn::And(hn::And(hn::Ge(at.u, first), hn::Le(at.u, last_u)),
                                                      hn::And(hn::Ge(at.v, first), hn::Le(at.v, last_v))));
    const V4 of_target = hn::ConvertTo(d4, hn::PromoteTo(d32, hn::LoadU(d8, model.weight.data() + k)));
    const V4 weight = hn::Mul(of_target, view.facing.of(model.normals, k));
    hn::Store(hn::IfThenElseZero(visible, weight), d4, samples.weight.data() + k);
    // What is not in the image is sampled at its border all the same and gets no weight: equal work for all.
    alignas(16) float u[kLanes];
    alignas(16) float v[kLanes];
    hn::Store(hn::IfThenElse(visible, at.u, first), d4, u);
    hn::Store(hn::IfThenElse(visible, at.v, first), d4, v);
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const std::size_t at4 = 4 * (k + lane);
      sample_colour(view.image, u[lane], v[lane], samples.value.data() + at4, samples.slope_u.data() + at4,
                    samples.slope_v.data() + at4);
    }
  }
}

// The channels of four points that stand four floats a point.
void load_channels(const float* at, V4 (&channel)[kChannels]) {
  V4 unused;
  hn::LoadInterleaved4(d4, at, channel[0], channel[1], channel[2], unused);
}

// ---- Pairings -------------------------------------------------------------------------------------------

// How b explains a, a = gain b + offset, over points with a weight.
struct Pairing {
  double gain = 1;
  double offset[kChannels] = {};
  double deviation = 0;  // mean absolute residual
  double spread = 0;     // standard deviation of a
  double points = 0;     // seen
  [[nodiscard]] bool usable() const { return points >= kMinPoints; }
};

enum PairingName {
  kLeftPhoto,
  kRightPhoto,
  kLeftRight,
  kPairings
};

// One level of everything that is aligned.
struct Level {
  Level(const PhotoModel& photo_model, const StereoRig& rig, const ColourPyramid& left,
        const ColourPyramid& right, const RefinePass& pass, RefineWorkspace& space)
      : model(photo_model),
        camera_left(camera_at_level(rig.left, pass.level)),
        camera_right(camera_at_level(rig.right, pass.level)),
        image_left(level_of(left, pass.level)),
        image_right(level_of(right, pass.level)),
        workspace(space) {
    const int limited = pass.points < kMaxRefinePoints ? pass.points : kMaxRefinePoints;
    points = (limited < model.inner ? limited : model.inner) / kLanes * kLanes;
    const PointColours& colours = model.colour[static_cast<unsigned>(pass.level)];
    for (int i = 0; i < points; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const auto packed =
          static_cast<ColourPixel>(colours.luma[k] | (colours.cb[k] << 8) | (colours.cr[k] << 16));
      hn::Store(colour_of(packed), d4, workspace.photo.data() + 4 * k);
    }
  }

  [[nodiscard]] View left(const Transform& T_H_M) const {
    return {camera_left, image_left, target_in_camera(camera_left, T_H_M)};
  }
  [[nodiscard]] View right(const Transform& T_H_M) const {
    return {camera_right, image_right, target_in_camera(camera_right, T_H_M)};
  }

  // The two sides of a pairing at four points, and their common weight.
  void load(int pairing, int i, V4 (&a)[kChannels], V4 (&b)[kChannels], V4& weight) const {
    const auto k = static_cast<std::size_t>(i);
    const RefineSamples& first = pairing == kRightPhoto ? workspace.right : workspace.left;
    load_channels(first.value.data() + 4 * k, a);
    load_channels((pairing == kLeftRight ? workspace.right.value : workspace.photo).data() + 4 * k, b);
    weight = hn::Load(d4, first.weight.data() + k);
    if (pairing == kLeftRight) weight = hn::Mul(weight, hn::Load(d4, workspace.right.weight.data() + k));
  }

  const PhotoModel& model;
  CameraModel camera_left;
  CameraModel camera_right;
  ColourLevel image_left;
  ColourLevel image_right;
  RefineWorkspace& workspace;
  int points;
};

Pairing fit_light(const Level& level, int name) {
  V4 a[kChannels];
  V4 b[kChannels];
  V4 weight;
  V4 n = hn::Zero(d4);
  V4 sum_a[kChannels] = {hn::Zero(d4), hn::Zero(d4), hn::Zero(d4)};
  V4 sum_b[kChannels] = {hn::Zero(d4), hn::Zero(d4), hn::Zero(d4)};
  for (int i = 0; i < level.points; i += kLanes) {
    level.load(name, i, a, b, weight);
    n = hn::Add(n, weight);
    for (int c = 0; c < kChannels; ++c) {
      sum_a[c] = hn::Add(sum_a[c], hn::Mul(weight, a[c]));
      sum_b[c] = hn::Add(sum_b[c], hn::Mul(weight, b[c]));
    }
  }
  Pairing pair;
  pair.points = sum_of(n);
  const double count = pair.points > 1 ? pair.points : 1;
  double mean_a[kChannels];
  double mean_b[kChannels];
  V4 centre_a[kChannels];
  V4 centre_b[kChannels];
  for (int c = 0; c < kChannels; ++c) {
    mean_a[c] = sum_of(sum_a[c]) / count;
    mean_b[c] = sum_of(sum_b[c]) / count;
    centre_a[c] = set(mean_a[c]);
    centre_b[c] = set(mean_b[c]);
  }
  V4 aa = hn::Zero(d4);
  V4 bb = hn::Zero(d4);
  V4 ab = hn::Zero(d4);
  for (int i = 0; i < level.points; i += kLanes) {
    level.load(name, i, a, b, weight);
    for (int c = 0; c < kChannels; ++c) {
      const V4 x = hn::Sub(a[c], centre_a[c]);
      const V4 y = hn::Sub(b[c], centre_b[c]);
      const V4 wx = hn::Mul(weight, x);
      aa = hn::Add(aa, hn::Mul(wx, x));
      ab = hn::Add(ab, hn::Mul(wx, y));
      bb = hn::Add(bb, hn::Mul(hn::Mul(weight, y), y));
    }
  }
  pair.gain = clamped(sum_of(ab) / (sum_of(bb) + 1e-6), 0.05, 20);
  V4 offset[kChannels];
  for (int c = 0; c < kChannels; ++c) {
    pair.offset[c] = mean_a[c] - pair.gain * mean_b[c];
    offset[c] = set(pair.offset[c]);
  }
  const V4 gain = set(pair.gain);
  V4 deviation = hn::Zero(d4);
  for (int i = 0; i < level.points; i += kLanes) {
    level.load(name, i, a, b, weight);
    V4 sum = hn::Zero(d4);
    for (int c = 0; c < kChannels; ++c) {
      sum = hn::Add(sum, hn::Abs(hn::Sub(hn::Sub(a[c], hn::Mul(gain, b[c])), offset[c])));
    }
    deviation = hn::Add(deviation, hn::Mul(weight, sum));
  }
  pair.deviation = sum_of(deviation) / (kChannels * count);
  pair.spread = std::sqrt(sum_of(aa) / (kChannels * count));
  return pair;
}

// Normal equations of one pairing: pose and gain are common to the channels, an offset belongs to one.
struct NormalSums {
  static constexpr int kCommon = 7;
  V4 common[kCommon * (kCommon + 1) / 2];  // lower triangle, by rows
  V4 offset[kChannels][kCommon + 1];       // last: of the offset with itself
  V4 slope[kCommon];                       // of the cost
  V4 slope_offset[kChannels];
  V4 squares;  // weighted, of the residuals

  NormalSums() {
    const V4 zero = hn::Zero(d4);
    for (V4& v : common) v = zero;
    for (auto& channel : offset) {
      for (V4& v : channel) v = zero;
    }
    for (V4& v : slope) v = zero;
    for (V4& v : slope_offset) v = zero;
    squares = zero;
  }

  HWY_INLINE void add(int channel, const V4 (&J)[kCommon], V4 residual, V4 weight) {
    V4 wJ[kCommon];
    for (int k = 0; k < kCommon; ++k) wJ[k] = hn::Mul(weight, J[k]);
    int at = 0;
    for (int k = 0; k < kCommon; ++k) {
      for (int l = 0; l <= k; ++l, ++at) common[at] = hn::Add(common[at], hn::Mul(wJ[k], J[l]));
    }
    // The derivative with respect to the channel's offset is -1.
    for (int k = 0; k < kCommon; ++k) {
      offset[channel][k] = hn::Sub(offset[channel][k], wJ[k]);
      slope[k] = hn::Sub(slope[k], hn::Mul(wJ[k], residual));
    }
    offset[channel][kCommon] = hn::Add(offset[channel][kCommon], weight);
    const V4 wr = hn::Mul(weight, residual);
    slope_offset[channel] = hn::Add(slope_offset[channel], wr);
    squares = hn::Add(squares, hn::Mul(wr, residual));
  }

  // Adds the pose's part, gain and offsets eliminated (Schur complement).
  void reduce_into(Matrix6& H, Vector6& g) const {
    Matrix10 N = Matrix10::Zero();
    Vector10 q;
    int at = 0;
    for (int k = 0; k < kCommon; ++k) {
      for (int l = 0; l <= k; ++l, ++at) N(k, l) = sum_of(common[at]);
      q[k] = sum_of(slope[k]);
    }
    for (int c = 0; c < kChannels; ++c) {
      for (int k = 0; k <= kCommon; ++k) N(kCommon + c, k < kCommon ? k : kCommon + c) = sum_of(offset[c][k]);
      q[kCommon + c] = sum_of(slope_offset[c]);
    }
    N.triangularView<Eigen::StrictlyUpper>() = N.transpose();
    Eigen::Matrix4d L = N.bottomRightCorner<4, 4>();
    for (int k = 0; k < 4; ++k) L(k, k) += 1e-6 * L(k, k) + 1e-9;
    const Eigen::LDLT<Eigen::Matrix4d> light(L);
    const Eigen::Matrix<double, 4, 6> E = N.bottomLeftCorner<4, 6>();
    H += N.topLeftCorner<6, 6>() - E.transpose() * light.solve(E);
    g += q.head<6>() - E.transpose() * light.solve(Eigen::Vector4d(q.tail<4>()));
  }
};

struct NormalEquations {
  Matrix6 H = Matrix6::Zero();
  Vector6 g = Vector6::Zero();
  double squares = 0;    // sum of weighted squared residuals
  double residuals = 0;  // how many
  std::array<double, kPairings> cost{};
};

double cost_of(const Pairing& pair) {
  constexpr double kNoise = 4;       // spread of a bare wall
  constexpr double kUnusable = 1.0;  // as bad as an unrelated place
  return pair.usable() ? pair.deviation / (pair.spread + kNoise) : kUnusable;
}

// The slopes of a camera's colours with the pose increment.
void pose_slopes(const Projection& at, const RefineSamples& samples, int i, V4 (&J)[kChannels][6]) {
  V4 slope_u[kChannels];
  V4 slope_v[kChannels];
  load_channels(samples.slope_u.data() + 4 * static_cast<std::size_t>(i), slope_u);
  load_channels(samples.slope_v.data() + 4 * static_cast<std::size_t>(i), slope_v);
  for (int c = 0; c < kChannels; ++c) {
    for (int k = 0; k < 6; ++k) {
      J[c][k] = hn::Add(hn::Mul(slope_u[c], at.du[k]), hn::Mul(slope_v[c], at.dv[k]));
    }
  }
}

NormalEquations linearize(const Level& level, const Transform& T_H_M) {
  constexpr double kUnitOfGain = 50;  // brings the gain's column to the size of the others
  const View left = level.left(T_H_M);
  const View right = level.right(T_H_M);
  sample_points(level.model, level.points, left, level.workspace.left);
  sample_points(level.model, level.points, right, level.workspace.right);
  NormalEquations result;
  Pairing pairs[kPairings];
  V4 gain[kPairings];
  V4 offset[kPairings][kChannels];
  V4 scale_squared[kPairings];
  for (int name = 0; name < kPairings; ++name) {
    const Pairing& pair = pairs[name] = fit_light(level, name);
    result.cost[static_cast<unsigned>(name)] = cost_of(pair);
    gain[name] = set(pair.gain);
    for (int c = 0; c < kChannels; ++c) offset[name][c] = set(pair.offset[c]);
    const double scale = 1.5 * pair.deviation + 0.5;  // residuals much beyond it count little
    scale_squared[name] = set(scale * scale);
  }
  const V4 unit = set(-1 / kUnitOfGain);
  NormalSums sums[kPairings];
  for (int i = 0; i < level.points; i += kLanes) {
    V4 J_left[kChannels][6];
    V4 J_right[kChannels][6];
    pose_slopes(project_four(left, level.model, i), level.workspace.left, i, J_left);
    pose_slopes(project_four(right, level.model, i), level.workspace.right, i, J_right);
    for (int name = 0; name < kPairings; ++name) {
      V4 a[kChannels];
      V4 b[kChannels];
      V4 seen;
      level.load(name, i, a, b, seen);
      for (int c = 0; c < kChannels; ++c) {
        const V4 residual = hn::Sub(hn::Sub(a[c], hn::Mul(gain[name], b[c])), offset[name][c]);
        const V4 weight =  // Cauchy
            hn::Div(seen, hn::Add(scale_squared[name], hn::Mul(residual, residual)));
        V4 J[NormalSums::kCommon];
        for (int k = 0; k < 6; ++k) {
          J[k] = name == kRightPhoto  ? J_right[c][k]
                 : name == kLeftPhoto ? J_left[c][k]
                                      : hn::Sub(J_left[c][k], hn::Mul(gain[name], J_right[c][k]));
        }
        J[6] = hn::Mul(unit, b[c]);
        sums[name].add(c, J, residual, weight);
      }
    }
  }
  for (int name = 0; name < kPairings; ++name) {
    if (!pairs[name].usable()) continue;
    sums[name].reduce_into(result.H, result.g);
    result.squares += sum_of(sums[name].squares);
    result.residuals += kChannels * pairs[name].points;
  }
  return result;
}

Vector3 limited(const Vector3& step, double limit) {
  const double length = std::sqrt(step.squaredNorm());
  return length > limit ? Vector3(step * (limit / length)) : step;
}

}  // namespace

double alignment_cost(const PhotoModel& model, const StereoRig& rig, const ColourPyramid& left,
                      const ColourPyramid& right, const RefinePass& pass, RefineWorkspace& workspace,
                      const Transform& T_H_M) {
  const Level level(model, rig, left, right, pass, workspace);
  sample_points(model, level.points, level.left(T_H_M), workspace.left);
  sample_points(model, level.points, level.right(T_H_M), workspace.right);
  double cost = 0;
  for (int name = 0; name < kPairings; ++name) cost += cost_of(fit_light(level, name));
  return cost;
}

Alignment assess_alignment(const PhotoModel& model, const StereoRig& rig, const ColourPyramid& left,
                           const ColourPyramid& right, const RefinePass& pass, RefineWorkspace& workspace,
                           const Transform& T_H_M) {
  // Neighbouring points share noise and model errors, and the third pairing repeats the noise of the other
  // two: the residuals are worth fewer independent ones (docs/refine.md).
  constexpr double kResidualsForOne = 60;
  const Level level(model, rig, left, right, pass, workspace);
  NormalEquations normal = linearize(level, T_H_M);
  Alignment result;
  result.pairing_cost = normal.cost;
  result.cost = normal.cost[0] + normal.cost[1] + normal.cost[2];
  const double variance =
      normal.residuals > 0 ? kResidualsForOne * normal.squares / normal.residuals : kResidualsForOne;
  // A prior of a metre and a radian or so: what nothing fixes stays finite.
  for (int k = 0; k < 6; ++k) normal.H(k, k) += variance * (k < 3 ? 1e-6 : 1.0);
  const Matrix6 information = normal.H / variance;
  result.covariance = pose_covariance(information, T_H_M);
  return result;
}

void refine_photo_pose(const PhotoModel& model, const StereoRig& rig, const ColourPyramid& left,
                       const ColourPyramid& right, const RefinePass& pass, RefineWorkspace& workspace,
                       Transform& T_H_M) {
  const Level level(model, rig, left, right, pass, workspace);
  for (int iteration = 0; iteration < pass.iterations; ++iteration) {
    NormalEquations normal = linearize(level, T_H_M);
    for (int k = 0; k < 6; ++k) normal.H(k, k) += 1e-4 * normal.H(k, k) + 1e-9;
    const Vector6 step = normal.H.ldlt().solve(normal.g);
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
HWY_AFTER_NAMESPACE();
