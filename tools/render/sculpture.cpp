#include "tools/render/sculpture.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "algo/trigonometry.hpp"
#include "tools/render/random.hpp"
#include "tools/render/surface_nets.hpp"

namespace vergence::render {
namespace {

double ellipsoid_distance(const Part& part, const Vector3& p) {
  const Vector3 q = part.R.transpose() * (p - part.a);
  const Vector3 scaled = q.cwiseQuotient(part.radii);
  const double k0 = scaled.norm();
  const double k1 = scaled.cwiseQuotient(part.radii).norm();
  return k1 > 0 ? k0 * (k0 - 1) / k1 : -part.radii.minCoeff();
}

// Nearest point of the axis, radius there: exact where the radii agree, close to it where they nearly do.
double cone_distance(const Part& part, const Vector3& p) {
  const Vector3 ab = part.b - part.a;
  const double t = std::clamp((p - part.a).dot(ab) / ab.squaredNorm(), 0.0, 1.0);
  return (p - part.a - t * ab).norm() - (part.ra + t * (part.rb - part.ra));
}

// Signed distance to a closed polygon, negative inside.
double outline_distance(const std::vector<Vector2>& outline, const Vector2& p) {
  double nearest = (p - outline[0]).squaredNorm();
  bool inside = false;
  for (std::size_t i = 0, j = outline.size() - 1; i < outline.size(); j = i++) {
    const Vector2 edge = outline[j] - outline[i];
    const Vector2 w = p - outline[i];
    const double t = std::clamp(w.dot(edge) / edge.squaredNorm(), 0.0, 1.0);
    nearest = std::min(nearest, (w - t * edge).squaredNorm());
    const bool crosses = (outline[i][1] > p[1]) != (outline[j][1] > p[1]);
    if (crosses && p[0] < edge[0] * (p[1] - outline[i][1]) / edge[1] + outline[i][0]) inside = !inside;
  }
  return inside ? -std::sqrt(nearest) : std::sqrt(nearest);
}

double plate_distance(const Part& part, const Vector3& p) {
  const double d = outline_distance(part.outline, p.head<2>());
  const double middle =
      part.a[2] + part.bend[0] * std::abs(p[0]) + part.bend[1] * p[1] + part.bend[2] * p[0] * p[0];
  const double depth = std::clamp(-d / part.edge_mm, 0.0, 1.0);
  // Round in section, never thinner than a fifth.
  const double half = part.ra * (0.2 + 0.8 * std::sqrt(depth * (2 - depth)));
  const double dz = std::abs(p[2] - middle) - half;
  if (d <= 0 || dz <= 0) return std::max(d, dz * 0.8);
  return std::sqrt(d * d + dz * dz);
}

double part_distance(const Part& part, const Vector3& p) {
  switch (part.shape) {
    case Part::Shape::kEllipsoid: return ellipsoid_distance(part, p);
    case Part::Shape::kCone: return cone_distance(part, p);
    case Part::Shape::kPlate: break;
  }
  return plate_distance(part, p);
}

// Minimum with a fillet `width` wide.
double smooth_min(double a, double b, double width) {
  if (width <= 0) return std::min(a, b);
  const double h = std::max(width - std::abs(a - b), 0.0) / width;
  return std::min(a, b) - h * h * width / 4;
}

constexpr double kFar_mm = 1e9;
constexpr double kSlope_mm = 0.15;  // to either side, for the surface's slope
constexpr double kRoom_mm = 8;      // over the surface, looked at for how open it is

// Adds a part to the distance to all before it.
void join(double& d, const Part& part, const Vector3& p_mm) {
  const double reach = d + part.blend_mm + part.bound_radius;
  if (reach > 0 && (p_mm - part.bound_centre).squaredNorm() > reach * reach) return;
  d = smooth_min(d, part_distance(part, p_mm), part.blend_mm);
}

// How much of a layer's colour shows at p.
double layer_weight(const Layer& layer, const Vector3& p, double edge_depth_mm, std::uint64_t seed) {
  constexpr double kSoft_mm = 0.7;  // of edges; about the size of a triangle
  const Vector3 q = p - layer.origin;
  const double period = layer.scale_mm;
  const auto stripe = [&](double along) {
    const double phase = along / period - std::floor(along / period);
    const double from_middle = std::abs(phase - 0.5) * period;
    const double half = layer.amount * period / 2;
    return 1 - smooth_step(half - kSoft_mm, half + kSoft_mm, from_middle);
  };
  const double wobble = 0.12 * period * value_noise(p / (0.8 * period), seed + 7);
  switch (layer.pattern) {
    case Pattern::kMottle: {
      const double noise = 0.5 + 0.9 * fractal_noise(p / period, seed, 3);
      return smooth_step(0.42, 0.58, noise + layer.amount - 0.5);
    }
    case Pattern::kSpots: {
      const double d = nearest_point_distance(p / period, seed) * period;
      const double r = layer.amount * period;
      return 1 - smooth_step(r - kSoft_mm, r + kSoft_mm, d);
    }
    case Pattern::kStripes: return stripe(q.dot(layer.axis) + wobble);
    case Pattern::kRings: return stripe((q - layer.axis * q.dot(layer.axis)).norm() + 0.5 * wobble);
    case Pattern::kSpokes: {
      // A rational angle: no arc tangent needed. Runs from 0 to 4 around the circle.
      const double s = std::abs(q[0]) + std::abs(q[1]);
      if (s <= 0) return 0;
      const double quarter = q[1] / s;
      const double angle = q[0] >= 0 ? 1 + quarter : 3 - quarter;
      const double phase = angle * period / 4;
      const double from_middle = std::abs(phase - std::floor(phase) - 0.5);
      return 1 - smooth_step(layer.amount / 2 - 0.06, layer.amount / 2 + 0.06, from_middle);
    }
    case Pattern::kGradient: return smooth_step(0, period, q.dot(layer.axis));
    case Pattern::kBand: {
      const double half = period / 2;
      return 1 - smooth_step(half - kSoft_mm, half + kSoft_mm, std::abs(q.dot(layer.axis) + wobble));
    }
    case Pattern::kPatch:
      return 1 - smooth_step(period - kSoft_mm, period + kSoft_mm, q.norm() + wobble * 0.3);
    case Pattern::kRim: return 1 - smooth_step(period - kSoft_mm, period + kSoft_mm, edge_depth_mm);
  }
  return 0;
}

// Points of a closed (or open) Catmull-Rom curve through the given ones, `steps` to a span.
template <typename Vector>
std::vector<Vector> smooth_curve(const std::vector<Vector>& points, int steps, bool closed) {
  const auto n = static_cast<int>(points.size());
  const auto at = [&](int i) -> const Vector& {
    return points[static_cast<std::size_t>(closed ? ((i % n) + n) % n : std::clamp(i, 0, n - 1))];
  };
  std::vector<Vector> curve;
  for (int i = 0; i < (closed ? n : n - 1); ++i) {
    for (int k = 0; k < steps; ++k) {
      const double t = static_cast<double>(k) / steps;
      const Vector a = 2 * at(i);
      const Vector b = at(i + 1) - at(i - 1);
      const Vector c = 2 * at(i - 1) - 5 * at(i) + 4 * at(i + 1) - at(i + 2);
      const Vector d = 3 * (at(i) - at(i + 1)) + at(i + 2) - at(i - 1);
      curve.push_back((a + t * (b + t * (c + t * d))) / 2);
    }
  }
  if (!closed) curve.push_back(points.back());
  return curve;
}

}  // namespace

std::size_t Sculpture::paint(Rgb base, std::vector<Layer> layers) {
  paints_.push_back({base, std::move(layers)});
  return paints_.size() - 1;
}

void Sculpture::add(Part part) {
  switch (part.shape) {
    case Part::Shape::kEllipsoid:
      part.bound_centre = part.a;
      part.bound_radius = part.radii.maxCoeff();
      break;
    case Part::Shape::kCone:
      part.bound_centre = (part.a + part.b) / 2;
      part.bound_radius = (part.b - part.a).norm() / 2 + std::max(part.ra, part.rb);
      break;
    case Part::Shape::kPlate: {
      Vector3 low = Vector3::Constant(1e9);
      Vector3 high = -low;
      for (const Vector2& p : part.outline) {
        const double z =
            part.a[2] + part.bend[0] * std::abs(p[0]) + part.bend[1] * p[1] + part.bend[2] * p[0] * p[0];
        low = low.cwiseMin(Vector3(p[0], p[1], z - part.ra));
        high = high.cwiseMax(Vector3(p[0], p[1], z + part.ra));
      }
      part.bound_centre = (low + high) / 2;
      part.bound_radius = (high - low).norm() / 2;
    }
  }
  parts_.push_back(std::move(part));
}

void Sculpture::ellipsoid(const Vector3& centre, const Vector3& radii, std::size_t paint, double blend_mm,
                          double turn_deg) {
  Part part;
  part.a = centre;
  part.radii = radii;
  const auto [s, c] = sin_cos(turn_deg * std::numbers::pi / 180);
  part.R << c, -s, 0, s, c, 0, 0, 0, 1;
  part.blend_mm = blend_mm;
  part.paint = paint;
  add(part);
}

void Sculpture::limb(const std::vector<Vector3>& points, double first_radius, double last_radius,
                     std::size_t paint, double blend_mm) {
  std::vector<double> radii;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double t = static_cast<double>(i) / static_cast<double>(points.size() - 1);
    radii.push_back(first_radius + t * (last_radius - first_radius));
  }
  body(points, radii, paint, blend_mm);
}

void Sculpture::body(const std::vector<Vector3>& points, const std::vector<double>& radii, std::size_t paint,
                     double blend_mm) {
  // The radius rides along as a fourth coordinate.
  std::vector<Eigen::Vector4d> corners;
  for (std::size_t i = 0; i < points.size(); ++i) {
    corners.push_back({points[i][0], points[i][1], points[i][2], radii[i]});
  }
  const std::vector<Eigen::Vector4d> curve = smooth_curve(corners, points.size() > 2 ? 4 : 1, false);
  for (std::size_t i = 0; i + 1 < curve.size(); ++i) {
    Part part;
    part.shape = Part::Shape::kCone;
    part.a = curve[i].head<3>();
    part.b = curve[i + 1].head<3>();
    part.ra = std::max(curve[i][3], 0.3);
    part.rb = std::max(curve[i + 1][3], 0.3);
    part.blend_mm = i == 0 ? blend_mm : std::max(blend_mm / 2, 1.0);
    part.paint = paint;
    add(part);
  }
}

void Sculpture::plate(const std::vector<Vector2>& corners, double z_mm, double thickness_mm,
                      std::size_t paint, double blend_mm, double edge_mm, const Vector3& bend) {
  Part part;
  part.shape = Part::Shape::kPlate;
  part.outline = smooth_curve(corners, 4, true);
  part.a = Vector3(0, 0, z_mm);
  part.ra = thickness_mm / 2;
  part.bend = bend;
  part.edge_mm = edge_mm;
  part.blend_mm = blend_mm;
  part.paint = paint;
  add(part);
}

void Sculpture::mirror_from(std::size_t first) {
  const Matrix3 flip = Vector3(-1, 1, 1).asDiagonal();
  const std::size_t end = parts_.size();
  for (std::size_t i = first; i < end; ++i) {
    Part part = parts_[i];
    part.a = flip * part.a;
    part.b = flip * part.b;
    part.R = flip * part.R * flip;
    part.bound_centre = flip * part.bound_centre;
    for (Vector2& p : part.outline) p[0] = -p[0];
    parts_.push_back(std::move(part));
  }
}

void Sculpture::keep_near(const Parts& among, const Vector3& p_mm, double reach_mm, Parts& near) {
  // Distances, and those to the middles of bounds, change by less than twice the way.
  const double slack = 4 * reach_mm;
  near.clear();
  double d = kFar_mm;
  for (const Part* part : among) {
    const double felt = d + part->blend_mm;
    if ((p_mm - part->bound_centre).norm() > felt + part->bound_radius + slack) continue;
    join(d, *part, p_mm);
    if (part_distance(*part, p_mm) <= felt + slack) near.push_back(part);
  }
}

double Sculpture::distance(const Vector3& p_mm) const {
  double d = kFar_mm;
  for (const Part& part : parts_) join(d, part, p_mm);
  return d;
}

double Sculpture::distance(const Parts& parts, const Vector3& p_mm) {
  double d = kFar_mm;
  for (const Part* part : parts) join(d, *part, p_mm);
  return d;
}

Rgb Sculpture::colour(const Vector3& p_mm) const {
  constexpr double kSeam_mm = 0.8;  // over which neighbouring parts' colours mix
  struct Nearest {
    double d = kFar_mm;
    const Part* part = nullptr;
  } first, second;
  for (const Part& part : parts_) {
    // The bounds of the others do not hold for what `part_distance` takes for their distance.
    if (part.shape == Part::Shape::kCone) {
      const double reach = first.d + kSeam_mm + part.bound_radius;
      if (reach < 0 || (p_mm - part.bound_centre).squaredNorm() > reach * reach) continue;
    }
    const double d = part_distance(part, p_mm);
    if (d < first.d) {
      if (first.part != nullptr && first.part->paint != part.paint) second = first;
      first = {d, &part};
    } else if (d < second.d && part.paint != first.part->paint) {
      second = {d, &part};
    }
  }
  const auto painted = [&](const Part& part) {
    const Paint& paint = paints_[part.paint];
    const double edge_depth =
        part.shape == Part::Shape::kPlate ? -outline_distance(part.outline, p_mm.head<2>()) : kFar_mm;
    Rgb colour = paint.base;
    std::uint64_t seed = hash(seed_, part.paint);
    for (const Layer& layer : paint.layers) {
      colour = mix(colour, layer.colour, static_cast<float>(layer_weight(layer, p_mm, edge_depth, seed)));
      seed += 101;
    }
    return colour;
  };
  Rgb colour = painted(*first.part);
  if (second.part != nullptr && second.d - first.d < kSeam_mm) {
    colour =
        mix(colour, painted(*second.part), static_cast<float>(0.5 * (1 - (second.d - first.d) / kSeam_mm)));
  }
  // Skin is never quite even.
  return colour * static_cast<float>(1 + 0.16 * fractal_noise(p_mm / 5, seed_ + 5, 3));
}

Vector3 Sculpture::gradient(const Parts& parts, const Vector3& p) {
  constexpr double h = kSlope_mm;
  Vector3 g;
  for (int i = 0; i < 3; ++i) {
    Vector3 step = Vector3::Zero();
    step[i] = h;
    g[i] = distance(parts, p + step) - distance(parts, p - step);
  }
  const double norm = g.norm();
  return norm > 0 ? Vector3(g / norm) : Vector3(0, 0, -1);
}

// The nearest point of the surface, as it looks there. `wide` is what is felt in the room over it as well.
Vertex Sculpture::vertex(const Vector3& near_mm, double cell_mm, const Parts& wide, Parts& narrow) const {
  constexpr int kSteps = 2;
  keep_near(wide, near_mm, kSteps * 0.5 * cell_mm + 2 * kSlope_mm, narrow);
  Vector3 p = near_mm;
  for (int i = 0; i < kSteps; ++i) {
    const Vector3 step = distance(narrow, p) * gradient(narrow, p);
    p -= step * std::min(1.0, 0.5 * cell_mm / std::max(step.norm(), 1e-9));
  }
  const Vector3 normal = gradient(narrow, p);
  // Openness: how much less room there is along the normal than over a plane.
  double closed = 0;
  double weight = 0.5;
  for (const double h : {2.0, 4.0, kRoom_mm}) {
    closed += weight * std::max(0.0, h - distance(wide, p + h * normal)) / h;
    weight *= 0.7;
  }
  return {p, normal, colour(p), static_cast<float>(std::max(0.15, 1 - closed))};
}

Mesh Sculpture::mesh(const Vector3& size_mm, double cell_mm, std::uint64_t seed) {
  seed_ = seed;
  Parts all;
  Vector3 low = Vector3::Constant(kFar_mm);
  Vector3 high = -low;
  for (const Part& part : parts_) {
    low = low.cwiseMin((part.bound_centre.array() - part.bound_radius).matrix());
    high = high.cwiseMax((part.bound_centre.array() + part.bound_radius).matrix());
    all.push_back(&part);
  }
  const Vector3 margin = Vector3::Constant(2 * cell_mm);
  Parts near;
  const Field field{
      [&](const Vector3& p) { return distance(near, p); },
      [&](const Vector3& p, double reach_mm) { keep_near(all, p, reach_mm, near); },
  };
  const Surface surface = surface_nets(field, low - margin, high + margin, cell_mm);

  Mesh mesh;
  mesh.triangles = surface.triangles;
  mesh.vertices.reserve(surface.points.size());
  low = Vector3::Constant(kFar_mm);
  high = -low;
  Parts narrow;
  for (const Vector3& point : surface.points) {
    keep_near(all, point, kRoom_mm + 2 * cell_mm, near);
    mesh.vertices.push_back(vertex(point, cell_mm, near, narrow));
    low = low.cwiseMin(mesh.vertices.back().position_mm);
    high = high.cwiseMax(mesh.vertices.back().position_mm);
  }

  const Vector3 scale = size_mm.cwiseQuotient(high - low);
  for (Vertex& vertex : mesh.vertices) {
    vertex.position_mm = (vertex.position_mm - (low + high) / 2).cwiseProduct(scale);
    vertex.normal = vertex.normal.cwiseQuotient(scale).normalized();
  }
  mesh.gloss = 0.2F;
  return mesh;
}

}  // namespace vergence::render
