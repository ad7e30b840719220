#include "tools/render/rasteriser.hpp"

#include <algorithm>

namespace vergence::render {
namespace {

constexpr double kNear_mm = 10;

// The light as it falls on a mesh, in the mesh's frame.
struct Lit {
  Lit(const Transform& T_W_C, const Placed& placed, const Light& light)
      : mesh(*placed.mesh), viewer(placed.T_W.inverse() * T_W_C.t_mm), local(light) {
    local.towards_lamp = placed.T_W.R.transpose() * light.towards_lamp;
  }
  [[nodiscard]] Rgb colour(std::uint32_t i) const {
    const Vertex& vertex = mesh.vertices[i];
    return shade(local, vertex.albedo, vertex.openness, mesh.gloss, vertex.normal,
                 (viewer - vertex.position_mm).normalized());
  }

  const Mesh& mesh;
  Vector3 viewer;
  Light local;
};

}  // namespace

void Rasteriser::project_corners(const CameraModel& camera, const Transform& T_C_M, const Mesh& mesh) {
  for (const Vertex& vertex : mesh.vertices) {
    Corner corner;
    const Vector3 p = T_C_M * vertex.position_mm;
    if (p[2] >= kNear_mm && project(camera, p, corner.uv_px)) corner.inverse_depth = 1 / p[2];
    corners_.push_back(corner);
  }
}

void Rasteriser::draw_mesh(const Placed& placed, const Transform& T_W_C, const Light& light,
                           std::size_t first) {
  const Mesh& mesh = *placed.mesh;
  const Lit lit(T_W_C, placed, light);
  const Corner* corners = &corners_[first];
  colours_.resize(mesh.vertices.size());
  has_colour_.assign(mesh.vertices.size(), 0);
  const bool has_turns = !mesh.turns.empty();
  for (std::size_t k = 0; k < mesh.triangles.size(); ++k) {
    const auto& t = mesh.triangles[k];
    const Corner& a = corners[t[0]];
    const Corner& b = corners[t[1]];
    const Corner& c = corners[t[2]];
    if (!(a.inverse_depth > 0 && b.inverse_depth > 0 && c.inverse_depth > 0)) continue;
    grid_.add(a, b, c, has_turns ? mesh.turns[k] : Turn::kBoth, placed.target, [&](const Rgb*(&colours)[3]) {
      for (std::size_t i = 0; i < 3; ++i) {
        if (has_colour_[t[i]] == 0) {
          colours_[t[i]] = lit.colour(t[i]);
          has_colour_[t[i]] = 1;
        }
        colours[i] = &colours_[t[i]];
      }
    });
  }
}

void Rasteriser::draw(const CameraModel& camera, const Transform& T_W_C, std::span<const Placed> meshes,
                      const Light& light, Sampling sampling, LinearImage& image, Visibility* visibility) {
  if (visibility != nullptr) {
    visibility->coverage.assign(image.data.size(), 0);
    visibility->depth_mm.assign(image.data.size(), 0);
  }
  corners_.clear();
  for (const Placed& placed : meshes) project_corners(camera, T_W_C.inverse() * placed.T_W, *placed.mesh);
  Vector2 low(1e9, 1e9);
  Vector2 high(-1e9, -1e9);
  for (const Corner& corner : corners_) {
    if (corner.inverse_depth <= 0) continue;
    low = low.cwiseMin(corner.uv_px);
    high = high.cwiseMax(corner.uv_px);
  }
  const auto bound = [](double v, int size) {
    return static_cast<int>(std::clamp(v, 0.0, static_cast<double>(size)));
  };
  grid_.start(bound(low[0] - 1, image.width_px), bound(low[1] - 1, image.height_px),
              bound(high[0] + 2, image.width_px), bound(high[1] + 2, image.height_px), sampling);
  std::size_t first = 0;
  for (const Placed& placed : meshes) {
    draw_mesh(placed, T_W_C, light, first);
    first += placed.mesh->vertices.size();
  }
  grid_.resolve(image, visibility);
}

void draw(const CameraModel& camera, const Transform& T_W_C, std::span<const Placed> meshes,
          const Light& light, Sampling sampling, LinearImage& image, Visibility* visibility) {
  Rasteriser().draw(camera, T_W_C, meshes, light, sampling, image, visibility);
}

}  // namespace vergence::render
