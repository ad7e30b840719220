#include "algo/relief.hpp"

#include <Eigen/Cholesky>
#include <cmath>

#include "algo/hue.hpp"

namespace vergence {
namespace {

constexpr float kChromaWeight = 2;

// The frames of learning: coarse first, so that depths are pulled in from far.
constexpr int kCoarseFrames = 7;   // at quarter resolution
constexpr int kMiddleFrames = 11;  // and up to here at half
constexpr int kLearningFrames = 60;
constexpr int kEarliestAdoption = 13;
constexpr int kBetterInARow = 3;
constexpr double kClearlyBetter = 0.85;  // of the cost of the model in use
constexpr double kLeastGain = 0.2;       // of the cost, where 3 is no likeness at all
constexpr double kAnyBetter = 0.995;     // once there is a relief

constexpr int kLeastPoints = 64;
constexpr double kLeastTarget = 0.3;   // of S_in
constexpr double kLeastSpread_mm = 1;  // a relief less deep is noise

constexpr double kMaxRelief_mm = 80;
constexpr double kMaxStep_mm = 8;
constexpr double kMaxTurn_rad = 0.05;
constexpr int kPoseSteps = 2;
constexpr int kSteps = 3;
constexpr double kShare = 0.6;
constexpr double kEarlyTrend_rad = 0.03;
constexpr int kConjugateSteps = 24;

// Depths tried at first.
constexpr int kSweepFrames = 5;
constexpr int kFlatHypothesis = kReliefHypotheses / 2;  // the one in the middle
constexpr int kSweepPerFrame = kReliefHypotheses / kSweepFrames;
static_assert(kSweepFrames * kSweepPerFrame == kReliefHypotheses);
constexpr int kSweepLevel = 1;
constexpr int kSweepRounds = 3;
constexpr double kSweepStep_mm = 3;

// Priors, in squared residuals over their scale.
constexpr double kSmoothness = 0.04;   // of neighbours' difference, a mm squared
constexpr double kEdge_mm = 4;         // beyond it a difference is an edge rather than a slope
constexpr double kFlatness = 0.0005;   // of each point
constexpr double kMeanError_mm = 0.5;  // the origin is at the mean depth of the visible surface
constexpr double kTrend_rad = 0.3;     // how far a target's surface as a whole may slope
constexpr double kTrust = 0.005;       // of what earlier frames knew of a point

unsigned at(int i) {
  return static_cast<unsigned>(i);
}

double clamped(double value, double low, double high) {
  const double at_least = value > low ? value : low;  // NaN becomes low
  return at_least < high ? at_least : high;
}

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

std::array<float, 4> photo_colour(const PhotoModel& model, int level, int i) {
  const PointColours& colours = model.colour[at(level)];
  return {static_cast<float>(colours.luma[at(i)]) - 128.0F,
          kChromaWeight * (static_cast<float>(colours.cb[at(i)]) - 128.0F),
          kChromaWeight * (static_cast<float>(colours.cr[at(i)]) - 128.0F), 0.0F};
}

// How a point moves with its relief, a mm of z: along its ray of the photo.
Vector3 ray_of(const PhotoModel& model, double x_mm, double y_mm) {
  const Vector3 from_centre = Vector3{x_mm, y_mm, 0} - model.optical_centre_mm;
  return from_centre / from_centre[2];
}

Vector3 limited(const Vector3& step, double limit) {
  const double length = std::sqrt(step.squaredNorm());
  return length > limit ? Vector3(step * (limit / length)) : step;
}

// As in refinement: the increment is [translation; rotation vector] in the target frame.
void move_by(const Vector6& step, Transform& T) {
  const Vector3 move = limited(step.head<3>(), kMaxStep_mm);
  const Vector3 turn = limited(step.tail<3>(), kMaxTurn_rad);
  T = T * Transform{rotation_from_quaternion_vector(turn * 0.5), move};
  T.R = rotation_from_quaternion_vector(quaternion_vector_from_rotation(T.R));
}

}  // namespace

const char* to_string(ReliefState state) {
  switch (state) {
    case ReliefState::kFlat: return "flat";
    case ReliefState::kLearning: return "learning";
    case ReliefState::kAdopted: return "adopted";
  }
  return "unknown";
}

bool Relief::learning() const {
  return frames_ < kLearningFrames && points_ >= kLeastPoints;
}

void Relief::drop() {
  if (state_ == ReliefState::kAdopted) return;
  state_ = ReliefState::kFlat;
  frames_ = 0;
  better_ = 0;
  T_M_C_ = Transform{};
  z_mm_.fill(0);
  known_.fill(0);
  trust_.fill(0);
}

void Relief::start(const PhotoModel& flat) {
  points_ = flat.inner < kMaxReliefPoints ? flat.inner : kMaxReliefPoints;
  state_ = ReliefState::kFlat;
  drop();
  target_points_ = 0;
  const int tolerance = hue_tolerance_steps(20);
  for (int i = 0; i < points_; ++i) {
    x_mm_[at(i)] = flat.x_mm[at(i)];
    y_mm_[at(i)] = flat.y_mm[at(i)];
    const bool like_background = hue_distance(flat.hue[at(i)], flat.background_hue) <= tolerance;
    const bool target = flat.masked ? flat.weight[at(i)] != 0 : !like_background;
    is_target_[at(i)] = target ? 1 : 0;
    target_points_ += is_target_[at(i)];
  }
  // A target of the background's own colour is not told from it by hue.
  if (target_points_ < kLeastTarget * points_) {
    for (int i = 0; i < points_; ++i) is_target_[at(i)] = 1;
    target_points_ = points_;
  }
  for (int i = 0; i < points_; ++i) {
    std::array<double, kReliefNeighbours> nearest;
    nearest.fill(1e30);
    auto& mine = neighbour_[at(i)];
    mine.fill(static_cast<std::int16_t>(i));
    for (int j = 0; j < points_; ++j) {
      if (j == i) continue;
      const double dx = x_mm_[at(j)] - x_mm_[at(i)];
      const double dy = y_mm_[at(j)] - y_mm_[at(i)];
      double squared = dx * dx + dy * dy;
      auto index = static_cast<std::int16_t>(j);
      for (unsigned k = 0; k < kReliefNeighbours; ++k) {
        if (squared >= nearest[k]) continue;
        const double swap = nearest[k];
        nearest[k] = squared;
        squared = swap;
        const std::int16_t swap_index = mine[k];
        mine[k] = index;
        index = swap_index;
      }
    }
  }
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

// Normal equations of what look() saw. The residuals of a point change with four numbers only, where it is in
// the left image and where in the right; so they are gathered in these (4 x 4), and only then taken to pose
// and depth.
void Relief::linearise(const PhotoModel& model, int level) {
  H_.setZero();
  g_.setZero();
  for (int i = 0; i < points_; ++i) {
    const ReliefSample& l = left_[at(i)];
    const ReliefSample& r = right_[at(i)];
    const std::array<float, 4> photo = photo_colour(model, level, i);
    double M[4][4] = {};
    double m[4] = {};
    double trust = 0;
    for (unsigned c = 0; c < 3; ++c) {
      const double slope[4] = {l.slope_u[c], l.slope_v[c], r.slope_u[c], r.slope_v[c]};
      const auto add = [&](const Light& light, double residual, double seen, const double(&s)[4]) {
        const double share = 1 / (light.scale * light.scale + residual * residual);  // Cauchy
        const double w = seen * share;
        trust += w * light.scale * light.scale;
        for (int a = 0; a < 4; ++a) {
          for (int b = 0; b <= a; ++b) M[a][b] += w * s[a] * s[b];
          m[a] -= w * s[a] * residual;
        }
      };
      const Light& pl = light_[0];
      const Light& pr = light_[1];
      const Light& lr = light_[2];
      add(pl, l.value[c] - pl.gain * photo[c] - pl.offset[c], l.seen, {slope[0], slope[1], 0, 0});
      add(pr, r.value[c] - pr.gain * photo[c] - pr.offset[c], r.seen, {0, 0, slope[2], slope[3]});
      add(lr, l.value[c] - lr.gain * r.value[c] - lr.offset[c], l.seen * r.seen,
          {slope[0], slope[1], -lr.gain * slope[2], -lr.gain * slope[3]});
    }
    for (int a = 0; a < 4; ++a) {
      for (int b = a + 1; b < 4; ++b) M[a][b] = M[b][a];
    }
    const std::array<double, 7>* rows[4] = {&l.du, &l.dv, &r.du, &r.dv};
    double MJ[4][7];
    for (int a = 0; a < 4; ++a) {
      for (unsigned k = 0; k < 7; ++k) {
        double sum = 0;
        for (int b = 0; b < 4; ++b) sum += M[a][b] * (*rows[b])[k];
        MJ[a][k] = sum;
      }
    }
    for (unsigned k = 0; k < 7; ++k) {
      double pull = 0;
      for (int a = 0; a < 4; ++a) pull += (*rows[a])[k] * m[a];
      const unsigned last = k < 6 ? k : 6;
      for (unsigned j = 0; j <= last; ++j) {
        double sum = 0;
        for (int a = 0; a < 4; ++a) sum += (*rows[a])[j] * MJ[a][k];
        if (k < 6) {
          H_(j, k) += sum;
        } else if (j < 6) {
          coupling_[j][at(i)] = sum;
        } else {
          data_[at(i)] = sum;
        }
      }
      if (k < 6) {
        g_[k] += pull;
      } else {
        pull_[at(i)] = pull;
      }
    }
    trust_[at(i)] += 0.2 * (trust / 9 - trust_[at(i)]);
  }
  H_.triangularView<Eigen::StrictlyLower>() = H_.transpose();
  for (int k = 0; k < 6; ++k) H_(k, k) += 1e-6 * H_(k, k) + 1e-9;
}

Vector6 Relief::solve_pose() const {
  return H_.ldlt().solve(g_);
}

// The priors' share of the normal equations of the z.
void Relief::add_priors() {
  double mean = 0;
  double mx = 0;
  double my = 0;
  double xx = 0;
  double yy = 0;
  for (int i = 0; i < points_; ++i) {
    const double w = is_target_[at(i)];
    mean += w * z_mm_[at(i)];
    mx += w * z_mm_[at(i)] * x_mm_[at(i)];
    my += w * z_mm_[at(i)] * y_mm_[at(i)];
    xx += w * x_mm_[at(i)] * x_mm_[at(i)];
    yy += w * y_mm_[at(i)] * y_mm_[at(i)];
  }
  const double n = target_points_ > 1 ? target_points_ : 1;
  // (mean z / sigma)^2 = (sum z)^2 / (n sigma)^2; the slope sum(z x) / sum(x x) likewise.
  mean_bond_ = 1 / (n * n * kMeanError_mm * kMeanError_mm);
  const double trend_rad = frames_ < kCoarseFrames ? kEarlyTrend_rad : kTrend_rad;
  trend_bond_x_ = 1 / ((xx + 1) * (xx + 1) * trend_rad * trend_rad);
  trend_bond_y_ = 1 / ((yy + 1) * (yy + 1) * trend_rad * trend_rad);
  for (int i = 0; i < points_; ++i) {
    const double w = is_target_[at(i)];
    const double diagonal = kFlatness + 1e-6;
    stiffness_[at(i)] = data_[at(i)] + diagonal + kTrust * known_[at(i)];
    pull_[at(i)] -= diagonal * z_mm_[at(i)] + w * (mean_bond_ * mean + trend_bond_x_ * mx * x_mm_[at(i)] +
                                                   trend_bond_y_ * my * y_mm_[at(i)]);
  }
  for (int i = 0; i < points_; ++i) {
    for (unsigned k = 0; k < kReliefNeighbours; ++k) {
      const auto j = static_cast<unsigned>(neighbour_[at(i)][k]);
      const double difference = z_mm_[at(i)] - z_mm_[j];
      const double ratio = difference / kEdge_mm;
      const double bond = kSmoothness * 0.5 / (1 + ratio * ratio);
      bond_[at(i)][k] = bond;
      pull_[at(i)] -= bond * difference;
      pull_[j] += bond * difference;
    }
  }
}

void Relief::multiply(const Vector6& pose, const Points& z, Vector6& out_pose, Points& out_z) const {
  out_pose = H_ * pose;
  double mean = 0;
  double mx = 0;
  double my = 0;
  for (int i = 0; i < points_; ++i) {
    const double value = z[at(i)];
    double sum = stiffness_[at(i)] * value;
    for (unsigned k = 0; k < 6; ++k) {
      out_pose[k] += coupling_[k][at(i)] * value;
      sum += coupling_[k][at(i)] * pose[k];
    }
    out_z[at(i)] = sum;
    const double weighted = is_target_[at(i)] * value;
    mean += weighted;
    mx += weighted * x_mm_[at(i)];
    my += weighted * y_mm_[at(i)];
  }
  mean *= mean_bond_;
  mx *= trend_bond_x_;
  my *= trend_bond_y_;
  for (int i = 0; i < points_; ++i) {
    out_z[at(i)] += is_target_[at(i)] * (mean + mx * x_mm_[at(i)] + my * y_mm_[at(i)]);
    for (unsigned k = 0; k < kReliefNeighbours; ++k) {
      const auto j = static_cast<unsigned>(neighbour_[at(i)][k]);
      const double flow = bond_[at(i)][k] * (z[at(i)] - z[j]);
      out_z[at(i)] += flow;
      out_z[j] -= flow;
    }
  }
}

// Conjugate gradients over pose and all z, a fixed number of steps. Leaves the z in dz_mm_.
Vector6 Relief::solve_jointly() {
  const Eigen::LDLT<Matrix6> pose_block(H_);
  Points& scale = data_;  // no longer needed
  for (int i = 0; i < points_; ++i) {
    double diagonal = stiffness_[at(i)];
    for (unsigned k = 0; k < kReliefNeighbours; ++k) diagonal += 2 * bond_[at(i)][k];
    scale[at(i)] = 1 / diagonal;
  }
  Vector6 pose = Vector6::Zero();
  Vector6 residual_pose = g_;
  Vector6 scaled_pose = pose_block.solve(residual_pose);
  Vector6 direction_pose = scaled_pose;
  double old = residual_pose.dot(scaled_pose);
  for (int i = 0; i < points_; ++i) {
    dz_mm_[at(i)] = 0;
    residual_[at(i)] = pull_[at(i)];
    direction_[at(i)] = scale[at(i)] * residual_[at(i)];
    old += residual_[at(i)] * direction_[at(i)];
  }
  for (int step = 0; step < kConjugateSteps; ++step) {
    Vector6 product_pose;
    multiply(direction_pose, direction_, product_pose, product_);
    double curvature = direction_pose.dot(product_pose);
    for (int i = 0; i < points_; ++i) curvature += direction_[at(i)] * product_[at(i)];
    const double length = curvature > 0 ? old / curvature : 0;
    pose += length * direction_pose;
    residual_pose -= length * product_pose;
    scaled_pose = pose_block.solve(residual_pose);
    double now = residual_pose.dot(scaled_pose);
    for (int i = 0; i < points_; ++i) {
      dz_mm_[at(i)] += length * direction_[at(i)];
      residual_[at(i)] -= length * product_[at(i)];
      now += residual_[at(i)] * residual_[at(i)] * scale[at(i)];
    }
    const double turn = old > 0 ? now / old : 0;
    direction_pose = scaled_pose + turn * direction_pose;
    for (int i = 0; i < points_; ++i) {
      direction_[at(i)] = scale[at(i)] * residual_[at(i)] + turn * direction_[at(i)];
    }
    old = now;
  }
  return pose;
}

// Tries some depths for all points at once, and keeps how badly each explains each point. After the last,
// every point starts from the depth that its neighbourhood likes best: far enough into the valley for
// Gauss-Newton.
void Relief::sweep(const StereoRig& rig, const ColourPyramid& left, const ColourPyramid& right,
                   const PhotoModel& model, const Transform& T_H_M) {
  Points& depth = product_;
  depth.fill(0);
  look(rig, left, right, kSweepLevel, model, depth, T_H_M);
  const std::array<Light, 3> flat_light = light_;
  for (int n = 0; n < kSweepPerFrame; ++n) {
    const int h = frames_ * kSweepPerFrame + n;
    depth.fill(kSweepStep_mm * (h - kFlatHypothesis));
    look(rig, left, right, kSweepLevel, model, depth, T_H_M);
    for (int i = 0; i < points_; ++i) {
      const ReliefSample& l = left_[at(i)];
      const ReliefSample& r = right_[at(i)];
      const std::array<float, 4> photo = photo_colour(model, kSweepLevel, i);
      double sum = 0;
      for (unsigned c = 0; c < 3; ++c) {
        const auto add = [&](const Light& light, double a, double b, double seen) {
          const double residual = (a - light.gain * b - light.offset[c]) / light.scale;
          const double squared = residual * residual;
          sum += seen > 0 ? squared / (1 + squared) : 1;
        };
        add(flat_light[0], l.value[c], photo[c], l.seen);
        add(flat_light[1], r.value[c], photo[c], r.seen);
        add(flat_light[2], l.value[c], r.value[c], l.seen * r.seen);
      }
      sweep_[at(h)][at(i)] = static_cast<float>(is_target_[at(i)] * sum);
    }
  }
  ++frames_;
  if (frames_ < kSweepFrames) return;
  for (auto& costs : sweep_) {
    for (int round = 0; round < kSweepRounds; ++round) {
      for (int i = 0; i < points_; ++i) {
        double sum = costs[at(i)];
        double weight = is_target_[at(i)];
        for (const std::int16_t j : neighbour_[at(i)]) {
          sum += costs[at(j)];
          weight += is_target_[at(j)];
        }
        product_[at(i)] = weight > 0 ? sum / weight : 0;
      }
      for (int i = 0; i < points_; ++i)
        costs[at(i)] = static_cast<float>(is_target_[at(i)] * product_[at(i)]);
    }
  }
  for (int i = 0; i < points_; ++i) {
    int best = kFlatHypothesis;  // flat, where nothing tells
    for (int h = 0; h < kReliefHypotheses; ++h) {
      if (sweep_[at(h)][at(i)] < sweep_[at(best)][at(i)]) best = h;
    }
    z_mm_[at(i)] = kSweepStep_mm * (best - kFlatHypothesis);
  }
}

bool Relief::observe(const StereoRig& rig, const ColourPyramid& left, const ColourPyramid& right,
                     const PhotoModel& model, const Transform& T_H_M) {
  if (!learning()) return false;
  if (state_ == ReliefState::kFlat) state_ = ReliefState::kLearning;
  if (frames_ < kSweepFrames) {
    sweep(rig, left, right, model, T_H_M);
    return false;
  }
  const int level = frames_ < kCoarseFrames ? 2 : (frames_ < kMiddleFrames ? 1 : 0);

  // The model in use explains this frame so well:
  Points& in_use = product_;
  for (int i = 0; i < points_; ++i) in_use[at(i)] = model.z_mm[at(i)];
  look(rig, left, right, level, model, in_use, T_H_M);
  const double cost_in_use = cost();
  // And what was learned from earlier ones, after its pose has settled on this one:
  Transform T_H_C = T_H_M * T_M_C_;
  for (int step = 0; step < kPoseSteps; ++step) {
    look(rig, left, right, level, model, z_mm_, T_H_C);
    linearise(model, level);
    move_by(solve_pose(), T_H_C);
  }
  look(rig, left, right, level, model, z_mm_, T_H_C);
  const bool adopted = state_ == ReliefState::kAdopted;
  const double limit = adopted ? kAnyBetter : kClearlyBetter;
  ratio_ = cost() / (cost_in_use + 1e-9);
  const bool better = (ratio_ < limit) & (adopted | (cost_in_use - cost() > kLeastGain));
  better_ = better ? better_ + 1 : 0;

  const int steps = frames_ < kMiddleFrames ? kSteps : 1;
  for (int step = 0; step < steps; ++step) {
    look(rig, left, right, level, model, z_mm_, T_H_C);
    linearise(model, level);
    for (int i = 0; i < points_; ++i) known_[at(i)] += 0.2 * (data_[at(i)] - known_[at(i)]);
    add_priors();
    move_by(solve_jointly(), T_H_C);
    const double share = frames_ < kMiddleFrames ? 1 : kShare;
    for (int i = 0; i < points_; ++i) {
      const double dz = clamped(dz_mm_[at(i)], -kMaxStep_mm, kMaxStep_mm);
      z_mm_[at(i)] = clamped(z_mm_[at(i)] + share * dz, -kMaxRelief_mm, kMaxRelief_mm);
    }
  }
  T_M_C_ = T_H_M.inverse() * T_H_C;
  double squares = 0;
  for (int i = 0; i < points_; ++i) squares += is_target_[at(i)] * z_mm_[at(i)] * z_mm_[at(i)];
  spread_mm_ = std::sqrt(squares / (target_points_ > 1 ? target_points_ : 1));
  ++frames_;
  return frames_ >= kEarliestAdoption && better_ >= kBetterInARow && spread_mm_ >= kLeastSpread_mm;
}

void Relief::adopt(PhotoModel& model, Transform& T_H_M) {
  for (int i = 0; i < points_; ++i) {
    const Vector3 ray = ray_of(model, x_mm_[at(i)], y_mm_[at(i)]);
    const Vector3 p = Vector3{x_mm_[at(i)], y_mm_[at(i)], 0} + z_mm_[at(i)] * ray;
    model.x_mm[at(i)] = static_cast<float>(p[0]);
    model.y_mm[at(i)] = static_cast<float>(p[1]);
    model.z_mm[at(i)] = static_cast<float>(p[2]);
    model.weight[at(i)] = is_target_[at(i)] > 0 ? 1 : 0;
  }
  state_ = ReliefState::kAdopted;
  better_ = 0;
  T_H_M = T_H_M * T_M_C_;
  T_M_C_ = Transform{};
}

}  // namespace vergence
