// The plain solids: balls, bars and cards.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "algo/trigonometry.hpp"
#include "tools/render/mesh.hpp"

namespace vergence::render {
namespace {

// Triangles of a grid of columns x rows vertices, from vertex `first` on.
void add_grid(Mesh& mesh, std::uint32_t first, std::uint32_t columns, std::uint32_t rows) {
  for (std::uint32_t row = 0; row + 1 < rows; ++row) {
    for (std::uint32_t column = 0; column + 1 < columns; ++column) {
      const std::uint32_t a = first + row * columns + column;
      const std::uint32_t b = a + 1;
      const std::uint32_t c = a + columns;
      mesh.triangles.push_back({a, b, c});
      mesh.triangles.push_back({b, c + 1, c});
    }
  }
}

// Mean of the picture over a rectangle given in its pixels, linear light.
Rgb mean_colour(const tools::RgbImage& picture, double x0, double y0, double x1, double y1) {
  const auto bound = [](double v, int size) { return std::clamp(static_cast<int>(v), 0, size - 1); };
  const int left = bound(x0, picture.width_px);
  const int right = std::max(left, bound(std::ceil(x1) - 1, picture.width_px));
  const int top = bound(y0, picture.height_px);
  const int bottom = std::max(top, bound(std::ceil(y1) - 1, picture.height_px));
  Rgb sum;
  for (int y = top; y <= bottom; ++y) {
    for (int x = left; x <= right; ++x) {
      const std::uint8_t* p = picture.at(x, y);
      const auto linear = [](std::uint8_t v) { return decode_srgb(static_cast<float>(v) / 255); };
      sum += {linear(p[0]), linear(p[1]), linear(p[2])};
    }
  }
  return sum * (1 / static_cast<float>((right - left + 1) * (bottom - top + 1)));
}

}  // namespace

void Mesh::append(const Mesh& other) {
  if (!turns.empty() || !other.turns.empty()) {
    turns.resize(triangles.size(), Turn::kBoth);
    turns.insert(turns.end(), other.turns.begin(), other.turns.end());
    turns.resize(triangles.size() + other.triangles.size(), Turn::kBoth);
  }
  const auto first = static_cast<std::uint32_t>(vertices.size());
  vertices.insert(vertices.end(), other.vertices.begin(), other.vertices.end());
  for (const auto& t : other.triangles) triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  gloss = std::max(gloss, other.gloss);
}

void Mesh::move(const Vector3& by_mm) {
  for (Vertex& vertex : vertices) vertex.position_mm += by_mm;
}

void Mesh::press(double factor) {
  for (Vertex& vertex : vertices) {
    vertex.position_mm[2] *= factor;
    vertex.normal[2] /= factor;  // of a scaled surface: by the inverse
    vertex.normal.normalize();
  }
}

Mesh make_ball(const Vector3& centre_mm, double radius_mm, const Rgb& albedo) {
  constexpr std::uint32_t kAround = 224;
  constexpr std::uint32_t kRings = 112;
  Mesh mesh;
  mesh.gloss = 0.35F;
  for (std::uint32_t ring = 0; ring <= kRings; ++ring) {
    const auto polar = sin_cos(std::numbers::pi * ring / kRings);
    for (std::uint32_t i = 0; i <= kAround; ++i) {
      const auto turn = sin_cos(2 * std::numbers::pi * i / kAround);
      const Vector3 n(polar.sine * turn.cosine, polar.sine * turn.sine, polar.cosine);
      mesh.vertices.push_back({centre_mm + radius_mm * n, n, albedo, 1});
    }
  }
  add_grid(mesh, 0, kAround + 1, kRings + 1);
  for (const auto& [a, b, c] : mesh.triangles) {
    // At the poles corners coincide, and how they turn means nothing.
    const Vector3 normal = (mesh.vertices[b].position_mm - mesh.vertices[a].position_mm)
                               .cross(mesh.vertices[c].position_mm - mesh.vertices[a].position_mm);
    const double outwards = normal.dot(mesh.vertices[a].normal);
    mesh.turns.push_back(std::abs(outwards) < 1e-9 ? Turn::kBoth : outwards > 0 ? Turn::kLeft : Turn::kRight);
  }
  return mesh;
}

Mesh make_bar(const Vector3& from_mm, const Vector3& to_mm, double radius_mm, const Rgb& albedo) {
  constexpr std::uint32_t kAround = 48;
  constexpr std::uint32_t kAlong = 24;
  const Vector3 axis = (to_mm - from_mm).normalized();
  const Vector3 side = axis.cross(std::abs(axis[2]) < 0.9 ? Vector3(0, 0, 1) : Vector3(1, 0, 0)).normalized();
  const Vector3 third = axis.cross(side);
  Mesh mesh;
  mesh.gloss = 0.25F;
  for (std::uint32_t k = 0; k <= kAlong; ++k) {
    const Vector3 centre = from_mm + (to_mm - from_mm) * (static_cast<double>(k) / kAlong);
    for (std::uint32_t i = 0; i <= kAround; ++i) {
      const auto turn = sin_cos(2 * std::numbers::pi * i / kAround);
      const Vector3 n = turn.cosine * side + turn.sine * third;
      mesh.vertices.push_back({centre + radius_mm * n, n, albedo, 1});
    }
  }
  add_grid(mesh, 0, kAround + 1, kAlong + 1);
  return mesh;
}

Mesh make_card(double width_mm, double height_mm, const tools::RgbImage& picture, double cell_mm) {
  const auto columns = static_cast<std::uint32_t>(std::ceil(width_mm / cell_mm)) + 1;
  const auto rows = static_cast<std::uint32_t>(std::ceil(height_mm / cell_mm)) + 1;
  const double px_per_column = static_cast<double>(picture.width_px) / (columns - 1);
  const double px_per_row = static_cast<double>(picture.height_px) / (rows - 1);
  Mesh mesh;
  for (std::uint32_t row = 0; row < rows; ++row) {
    for (std::uint32_t column = 0; column < columns; ++column) {
      const Vector3 p(width_mm * (static_cast<double>(column) / (columns - 1) - 0.5),
                      height_mm * (static_cast<double>(row) / (rows - 1) - 0.5), 0);
      const Rgb colour = mean_colour(picture, (column - 0.5) * px_per_column, (row - 0.5) * px_per_row,
                                     (column + 0.5) * px_per_column, (row + 0.5) * px_per_row);
      mesh.vertices.push_back({p, Vector3(0, 0, -1), colour, 1});
    }
  }
  add_grid(mesh, 0, columns, rows);
  return mesh;
}

}  // namespace vergence::render
