#include "tools/demo/pen.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace vergence::demo {
namespace {

constexpr double kPenTip_mm = 100;  // hangs so far ahead of the hand
constexpr double kGravity_mm_per_s2 = 9810;
constexpr double kAim_mm =
    8;  // the pen is dropped where it is expected to land nearer to the target's middle

// Whether a line down through a point meets the mesh.
bool meets(const render::Mesh& mesh, const Transform& T_M_S, const Vector3& p_S_mm) {
  const Vector3 from = T_M_S * p_S_mm;
  const Vector3 direction = T_M_S.R * Vector3(0, 0, 1);
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vector3 edge1 = mesh.vertices[b].position_mm - mesh.vertices[a].position_mm;
    const Vector3 edge2 = mesh.vertices[c].position_mm - mesh.vertices[a].position_mm;
    const Vector3 h = direction.cross(edge2);
    const double determinant = edge1.dot(h);
    if (std::abs(determinant) < 1e-12) continue;
    const Vector3 s = from - mesh.vertices[a].position_mm;
    const double u = s.dot(h) / determinant;
    const Vector3 q = s.cross(edge1);
    const double v = direction.dot(q) / determinant;
    if (u >= 0 && v >= 0 && u + v <= 1) return true;
  }
  return false;
}

}  // namespace

Transform pool_start() {
  Transform T;
  T.R << 0, 1, 0,  //
      1, 0, 0,     //
      0, 0, -1;
  T.t_mm = {-600, 0, 720};
  return T;
}

bool Pen::will_hit(const Transform& T_W_H, const Transform& T_W_M, const Vector3& drift_mm_per_s) {
  const Vector3 away = T_W_M.t_mm - T_W_H * Vector3(0, 0, kPenTip_mm);
  const double fall_s = std::sqrt(2 * std::max(0.0, -away[2]) / kGravity_mm_per_s2);
  return (away + fall_s * drift_mm_per_s).head<2>().norm() < kAim_mm;
}

void Pen::step(double t_s, const Transform& T_W_H, const Transform& T_W_M, const render::Mesh& mesh,
               bool let_go) {
  const Vector3 tip = T_S_W_ * (T_W_H * Vector3(0, 0, kPenTip_mm));
  const Vector3 velocity = last_tip_ ? Vector3((tip - *last_tip_) * 1000) : Vector3::Zero();
  last_tip_ = tip;
  if (!dropped_s && let_go) {
    dropped_s = t_s;
    from_ = tip;
    velocity_ = velocity;
  }
  if (!dropped_s || landed_s) return;
  const double fallen_s = t_s - *dropped_s;
  const Vector3 at =
      from_ + fallen_s * velocity_ + Vector3(0, 0, kGravity_mm_per_s2 * fallen_s * fallen_s / 2);
  const Transform T_S_M = T_S_W_ * T_W_M;
  if (at[2] < T_S_M.t_mm[2]) return;
  landed_s = t_s;
  miss_mm = (at - T_S_M.t_mm).head<2>().norm();
  hit = meets(mesh, T_S_M.inverse(), at);
}

}  // namespace vergence::demo
