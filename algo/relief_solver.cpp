// Gauss-Newton of a relief: the normal equations of pose and all depths together, their priors, and the fixed
// number of steps of conjugate gradients that solve them.
#include <Eigen/Cholesky>

#include "algo/relief_parts.hpp"

namespace vergence {
namespace {

constexpr double kEarlyTrend_rad = 0.03;  // instead of kTrend_rad, from nothing
constexpr int kConjugateSteps = 24;
constexpr int kFirstConjugateSteps = 12;  // from nothing

constexpr double kLeftRight = 0.5;  // weight of the third pairing: it repeats what the first two say

// Priors, in squared residuals over their scale.
constexpr double kSmoothness = 0.04;   // of neighbours' difference, a mm squared
constexpr double kEdge_mm = 4;         // beyond it a difference is an edge rather than a slope
constexpr double kFlatness = 0.0005;   // of each point
constexpr double kMeanError_mm = 0.5;  // the origin is at the mean depth of the visible surface
constexpr double kTrend_rad = 0.3;     // how far a target's surface as a whole may slope
constexpr double kTrust = 0.005;       // of what earlier frames knew of a point

}  // namespace

// Normal equations of what look() saw. The residuals of a point change with four numbers only, where it is in
// the left image and where in the right; so they are gathered in these (4 x 4), and only then taken to pose
// and depth.
void Relief::linearise() {
  H_.setZero();
  g_.setZero();
  for (int i = 0; i < points_; ++i) {
    const ReliefSample& l = left_[at(i)];
    const ReliefSample& r = right_[at(i)];
    const std::array<float, 4> photo = photo_[at(i)];
    double M[4][4] = {};
    double m[4] = {};
    for (unsigned c = 0; c < 3; ++c) {
      const double slope[4] = {l.slope_u[c], l.slope_v[c], r.slope_u[c], r.slope_v[c]};
      const auto add = [&](const Light& light, double residual, double seen, const double(&s)[4]) {
        const double share = 1 / (light.scale * light.scale + residual * residual);  // Cauchy
        const double w = seen * share;
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
      add(lr, l.value[c] - lr.gain * r.value[c] - lr.offset[c], kLeftRight * l.seen * r.seen,
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
  const double trend_rad = is_anew_ ? kEarlyTrend_rad : kTrend_rad;
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
  const int steps = is_anew_ ? kFirstConjugateSteps : kConjugateSteps;
  for (int step = 0; step < steps; ++step) {
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

}  // namespace vergence
