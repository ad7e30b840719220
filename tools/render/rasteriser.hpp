// Draws meshes into a picture: every pixel holds several samples, each with its own depth, so that edges are
// smooth and lie where they should.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "algo/camera_model.hpp"
#include "tools/render/light.hpp"
#include "tools/render/linear_image.hpp"
#include "tools/render/mesh.hpp"

namespace vergence::render {

// Samples of a pixel: a rotated grid of 4, an eight-rooks pattern of 8, or 16. Their mean is the pixel's
// centre.
enum class Sampling {
  k4 = 4,
  k8 = 8,
  k16 = 16,
};

struct Placed {
  const Mesh* mesh = nullptr;
  Transform T_W;       // pose of the mesh in the world
  bool target = true;  // counts for masks and depths
};

// What the camera sees of the target, per pixel.
struct Visibility {
  std::vector<float> coverage;  // share of the pixel's samples on the target
  std::vector<float> depth_mm;  // their mean depth; 0 where none
};

// Draws the meshes over `image`, which holds what is behind them. Triangles nearer than 10 mm are left out.
// T_W_C: pose of the camera in the world; camera.T_H_C is not used.
void draw(const CameraModel& camera, const Transform& T_W_C, std::span<const Placed> meshes,
          const Light& light, Sampling sampling, LinearImage& image, Visibility* visibility = nullptr);

}  // namespace vergence::render
