// Draws meshes into a picture: every pixel holds several samples, each with its own depth, so that edges are
// smooth and lie where they should.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "algo/camera_model.hpp"
#include "tools/render/light.hpp"
#include "tools/render/linear_image.hpp"
#include "tools/render/mesh.hpp"
#include "tools/render/sample_grid.hpp"

namespace vergence::render {

struct Placed {
  const Mesh* mesh = nullptr;
  Transform T_W;       // pose of the mesh in the world
  bool target = true;  // counts for masks and depths
};

// Draws the meshes over `image`, which holds what is behind them. Triangles nearer than 10 mm are left out.
// T_W_C: pose of the camera in the world; camera.T_H_C is not used.
void draw(const CameraModel& camera, const Transform& T_W_C, std::span<const Placed> meshes,
          const Light& light, Sampling sampling, LinearImage& image, Visibility* visibility = nullptr);

// Does the same, and keeps its memory for the next picture.
class Rasteriser {
 public:
  void draw(const CameraModel& camera, const Transform& T_W_C, std::span<const Placed> meshes,
            const Light& light, Sampling sampling, LinearImage& image, Visibility* visibility = nullptr);

 private:
  void project_corners(const CameraModel& camera, const Transform& T_C_M, const Mesh& mesh);
  void draw_mesh(const Placed& placed, const Transform& T_W_C, const Light& light, std::size_t first);

  std::vector<Corner> corners_;  // of all meshes
  // Of the mesh in hand, made when a triangle is seen.
  std::vector<Rgb> colours_;
  std::vector<std::uint8_t> has_colour_;
  SampleGrid grid_;
};

}  // namespace vergence::render
