// Triangle meshes with a colour at each vertex: what the rasteriser draws.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "algo/pose.hpp"
#include "tools/io/image_file.hpp"
#include "tools/render/colour_math.hpp"

namespace vergence::render {

struct Vertex {
  Vector3 position_mm;
  Vector3 normal;      // unit, outwards
  Rgb albedo;          // linear reflectance
  float openness = 1;  // of the hemisphere over it: 1 free, 0 in a crevice
};

// How a triangle's corners go round in a picture, x right and y down, that shows the side which is seen.
enum class Turn : std::uint8_t {
  kLeft,   // (b - a) x (c - a) points out of the mesh
  kRight,  // into it
  kBoth,   // either side is seen
};

struct Mesh {
  std::vector<Vertex> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;  // either winding
  // Of each triangle, where the mesh has an inside that is not seen; empty: all are seen from both sides.
  // Creatures do without, as their thinnest parts pass through themselves here and there.
  std::vector<Turn> turns;
  float gloss = 0;  // strength of the highlight

  void append(const Mesh& other);
  void move(const Vector3& by_mm);
  void press(double factor);  // scales z about 0
};

// Sphere whose flat facets are nowhere more than `radius / 2500` inside of it.
[[nodiscard]] Mesh make_ball(const Vector3& centre_mm, double radius_mm, const Rgb& albedo);

// Round bar between two points.
[[nodiscard]] Mesh make_bar(const Vector3& from_mm, const Vector3& to_mm, double radius_mm,
                            const Rgb& albedo);

// A printed card in the plane z = 0, centred, the picture filling it; seen from -z.
[[nodiscard]] Mesh make_card(double width_mm, double height_mm, const tools::RgbImage& picture,
                             double cell_mm);

}  // namespace vergence::render
