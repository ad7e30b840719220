// Solids as smooth unions of simple parts, painted: what the sea creatures are modelled in.
//
// The distance is only approximate away from the surface; meshing needs its sign, and its zero set.
#pragma once

#include <cstdint>
#include <vector>

#include "algo/pose.hpp"
#include "tools/render/colour_math.hpp"
#include "tools/render/mesh.hpp"

namespace vergence::render {

enum class Pattern {
  kMottle,    // clouds of the second colour; `amount` in [0, 1] is how much of it
  kSpots,     // round spots about `scale_mm` apart, `amount` of that in radius
  kStripes,   // along `axis`, `scale_mm` a period, `amount` of it striped
  kRings,     // as stripes, but by distance from the line `axis` through `origin`
  kSpokes,    // `scale_mm` many rays around z through `origin`
  kGradient,  // from the base at `origin` to the second colour `scale_mm` further along `axis`
  kBand,      // once across `axis` through `origin`, `scale_mm` wide
  kPatch,     // the ball of radius `scale_mm` about `origin`
  kRim,       // in plates: the outermost `scale_mm`
};

struct Layer {
  Pattern pattern = Pattern::kMottle;
  Rgb colour;
  double scale_mm = 10;
  double amount = 0.5;
  Vector3 axis = Vector3::UnitX();
  Vector3 origin = Vector3::Zero();
};

// A base colour with layers over it, later ones on top.
struct Paint {
  Rgb base;
  std::vector<Layer> layers;
};

struct Part {
  enum class Shape {
    kEllipsoid,
    kCone,   // round cone from a (radius ra) to b (radius rb)
    kPlate,  // outline in x y, thin towards its edge, bent along z
  };
  Shape shape = Shape::kEllipsoid;
  Vector3 a = Vector3::Zero();  // centre of ellipsoids; of plates z is the middle plane
  Vector3 b = Vector3::Zero();
  Vector3 radii = Vector3::Ones();
  Matrix3 R = Matrix3::Identity();  // ellipsoid's axes in the sculpture
  double ra = 1;
  double rb = 1;
  std::vector<Vector2> outline;
  double edge_mm = 4;     // plates: over this distance from the outline the full thickness is reached
  Vector3 bend{0, 0, 0};  // plates: z of the middle = a.z + bend.x |x| + bend.y y + bend.z x^2
  double blend_mm = 0;    // width of the fillet with the parts before
  std::size_t paint = 0;
  Vector3 bound_centre = Vector3::Zero();
  double bound_radius = 0;
};

class Sculpture {
 public:
  std::size_t paint(Rgb base, std::vector<Layer> layers = {});

  // Turned about z by `turn_deg` (x towards y) and then tipped about y.
  void ellipsoid(const Vector3& centre, const Vector3& radii, std::size_t paint, double blend_mm = 0,
                 double turn_deg = 0);
  // A chain of round cones through the points, the radius going evenly from the first to the last, smooth.
  void limb(const std::vector<Vector3>& points, double first_radius, double last_radius, std::size_t paint,
            double blend_mm = 0);
  // With a radius of its own at each point.
  void body(const std::vector<Vector3>& points, const std::vector<double>& radii, std::size_t paint,
            double blend_mm = 0);
  // A closed smooth outline through the corners.
  void plate(const std::vector<Vector2>& corners, double z_mm, double thickness_mm, std::size_t paint,
             double blend_mm = 0, double edge_mm = 4, const Vector3& bend = Vector3(0, 0, 0));
  // Everything added since `first` once more, mirrored in x = 0.
  void mirror_from(std::size_t first);
  [[nodiscard]] std::size_t parts() const { return parts_.size(); }

  [[nodiscard]] double distance(const Vector3& p_mm) const;

  // The surface as triangles about `cell_mm` in size, scaled to fill exactly `size_mm` and centred on the
  // origin. `seed` is that of the patterns.
  [[nodiscard]] Mesh mesh(const Vector3& size_mm, double cell_mm, std::uint64_t seed);

 private:
  // In their order.
  using Parts = std::vector<const Part*>;

  void add(Part part);
  // Those of `among` that are felt within `reach_mm` of p: there, the distance to them is that to all, to the
  // bit.
  static void keep_near(const Parts& among, const Vector3& p_mm, double reach_mm, Parts& near);
  [[nodiscard]] static double distance(const Parts& parts, const Vector3& p_mm);
  [[nodiscard]] static Vector3 gradient(const Parts& parts, const Vector3& p_mm);
  [[nodiscard]] Rgb colour(const Vector3& p_mm) const;
  [[nodiscard]] Vertex vertex(const Vector3& near_mm, double cell_mm, const Parts& wide, Parts& narrow) const;

  std::vector<Paint> paints_;
  std::vector<Part> parts_;
  std::uint64_t seed_ = 1;
};

}  // namespace vergence::render
