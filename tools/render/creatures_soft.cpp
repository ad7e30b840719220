// Those without bones: squid, jellyfish, octopus.
#include <numbers>

#include "algo/trigonometry.hpp"
#include "tools/render/creatures.hpp"

namespace vergence::render {
namespace {

Vector2 around(double degrees) {
  const auto [s, c] = sin_cos(degrees * std::numbers::pi / 180);
  return {c, s};
}

}  // namespace

void build_squid(Sculpture& s) {
  const auto mantle =
      s.paint(from_hsv(340, 0.52, 0.82), {{Pattern::kMottle, from_hsv(22, 0.68, 0.88), 18, 0.38},
                                          {Pattern::kSpots, from_hsv(290, 0.60, 0.55), 9, 0.20},
                                          {Pattern::kSpots, from_hsv(178, 0.55, 0.85), 13, 0.13}});
  const auto fin = s.paint(from_hsv(305, 0.38, 0.80),
                           {{Pattern::kStripes, from_hsv(265, 0.45, 0.68), 9, 0.40, {0.15, 0.99, 0}},
                            {Pattern::kRim, from_hsv(185, 0.55, 0.82), 3.0, 0.5}});
  const auto head =
      s.paint(from_hsv(18, 0.62, 0.88), {{Pattern::kSpots, from_hsv(345, 0.65, 0.60), 8, 0.25}});
  const auto arm = s.paint(from_hsv(38, 0.50, 0.95),
                           {{Pattern::kStripes, from_hsv(350, 0.62, 0.68), 11, 0.42, {0, 1, 0}}});
  const auto club = s.paint(from_hsv(355, 0.60, 0.75), {{Pattern::kSpots, from_hsv(50, 0.3, 0.98), 6, 0.25}});
  const auto white = s.paint(from_hsv(165, 0.40, 0.92));
  const auto pupil = s.paint({0.004F, 0.004F, 0.008F});
  s.plate({{0, -106},
           {16, -98},
           {32, -80},
           {41, -54},
           {38, -28},
           {24, -6},
           {0, 0},
           {-24, -6},
           {-38, -28},
           {-41, -54},
           {-32, -80},
           {-16, -98}},
          4, 7, fin, 0, 8);
  s.body({{0, -100, 0}, {0, -80, 0}, {0, -50, 0}, {0, -22, 0}, {0, 6, 0}}, {4, 13, 20, 21.5, 17}, mantle, 3);
  s.ellipsoid({0, 17, 0}, {16, 15, 15}, head, 3);
  const std::size_t first = s.parts();
  s.ellipsoid({14, 16, -5}, {7.5, 8.5, 7.5}, white, 1);
  s.ellipsoid({16.5, 16, -11}, {3.6, 4.6, 3.0}, pupil);
  s.limb({{3.5, 27, -8}, {5, 46, -11}, {3, 62, -10}, {6, 78, -8}}, 5.0, 1.3, arm, 4);
  s.limb({{9, 26, -4}, {16, 44, -5}, {16, 60, -3}, {23, 74, -2}}, 5.0, 1.3, arm, 4);
  s.limb({{12, 25, 3}, {25, 40, 4}, {30, 54, 4}, {38, 62, 5}}, 4.6, 1.3, arm, 4);
  s.limb({{6, 26, 6}, {12, 48, 8}, {10, 66, 8}, {15, 84, 7}}, 4.6, 1.3, arm, 4);
  s.limb({{10, 27, 0}, {19, 52, 1}, {25, 78, 1}, {19, 94, 0}}, 2.6, 2.2, arm, 3);
  s.mirror_from(first);
  s.ellipsoid({18, 99, 0}, {4.6, 10, 3.6}, club, 3, 14);
  s.ellipsoid({-18, 97, 0}, {4.6, 10, 3.6}, club, 3, -14);
}

void build_jellyfish(Sculpture& s) {
  // Seen from above its bell; the tentacles spread away from the viewer.
  const auto bell =
      s.paint(from_hsv(318, 0.52, 0.82),
              {{Pattern::kRings, from_hsv(285, 0.50, 0.66), 16, 0.40, {0, 0, 1}},
               {Pattern::kSpokes, from_hsv(24, 0.80, 0.92), 16, 0.30},
               {Pattern::kPatch, from_hsv(48, 0.75, 0.98), 8, 0.5, Vector3::UnitX(), {0, 0, -35}},
               {Pattern::kSpots, from_hsv(190, 0.3, 0.98), 8, 0.12}});
  const auto gonad =
      s.paint(from_hsv(200, 0.70, 0.80), {{Pattern::kMottle, from_hsv(170, 0.6, 0.75), 5, 0.4}});
  const auto frill = s.paint(from_hsv(232, 0.50, 0.80));
  const auto thread =
      s.paint(from_hsv(265, 0.48, 0.80), {{Pattern::kStripes, from_hsv(340, 0.5, 0.9), 12, 0.4, {0, 0, 1}}});
  const auto oral = s.paint(from_hsv(12, 0.55, 0.92));
  for (int i = 0; i < 16; ++i) {
    const Vector2 d = around(22.5 * i + 11);
    const Vector2 e = around(22.5 * i + 20);
    s.ellipsoid({34.5 * d[0], 34.5 * d[1], 2}, {6, 6, 5}, frill, 2);
    s.limb({{36 * d[0], 36 * d[1], 3},
            {41 * e[0], 41 * e[1], 20},
            {40 * d[0], 40 * d[1], 42},
            {46 * e[0], 46 * e[1], 66}},
           2.6, 1.0, thread, 2);
  }
  for (int i = 0; i < 4; ++i) {
    const Vector2 d = around(90.0 * i + 45);
    s.limb({{6 * d[0], 6 * d[1], 0}, {12 * d[0], 12 * d[1], 30}, {8 * d[0], 8 * d[1], 66}}, 6, 2, oral, 3);
  }
  s.ellipsoid({0, 0, 0}, {36, 36, 36}, bell, 2);
  for (int i = 0; i < 4; ++i) {
    const Vector2 d = around(90.0 * i + 45);
    s.ellipsoid({15 * d[0], 15 * d[1], -32.0}, {5.5, 7.0, 3.5}, gonad, 1, 90.0 * i + 45);
  }
}

void build_octopus(Sculpture& s) {
  const auto head = s.paint(from_hsv(6, 0.80, 0.82), {{Pattern::kMottle, from_hsv(330, 0.65, 0.58), 14, 0.35},
                                                      {Pattern::kSpots, from_hsv(38, 0.75, 0.98), 9, 0.20}});
  const auto arm = s.paint(from_hsv(16, 0.82, 0.85),
                           {{Pattern::kMottle, from_hsv(300, 0.45, 0.60), 13, 0.30},
                            {Pattern::kRings, from_hsv(352, 0.78, 0.58), 15, 0.32, {0, 0, 1}, {0, 10, 0}}});
  const auto sucker = s.paint(from_hsv(52, 0.40, 0.99));
  const auto white = s.paint(from_hsv(55, 0.70, 0.98));
  const auto pupil = s.paint({0.004F, 0.004F, 0.006F});
  const std::size_t first = s.parts();
  const auto tentacle = [&](const std::vector<Vector3>& p) {
    s.limb(p, 8.0, 1.8, arm, 4);
    for (std::size_t i = 1; i + 1 < p.size(); ++i) {
      const double r = 8.0 - 6.2 * static_cast<double>(i) / static_cast<double>(p.size() - 1);
      for (const double along : {-0.30, 0.0, 0.30}) {
        const Vector3 d = p[i + 1] - p[i - 1];
        const Vector3 side = Vector3(-d[1], d[0], 0).normalized() * (0.25 * r);
        s.ellipsoid(p[i] + along * d * 0.7 + side + Vector3(0, 0, -0.86 * r), Vector3(0.30, 0.30, 0.24) * r,
                    sucker, 0.5);
      }
    }
  };
  tentacle({{12, 4, 3}, {32, -4, 0}, {50, -16, 1}, {54, -34, 2}, {43, -40, 2}, {38, -31, 2}});
  tentacle({{14, 10, 4}, {36, 12, 0}, {55, 6, 2}, {66, 14, 3}, {60, 25, 3}, {52, 21, 3}});
  tentacle({{12, 16, 4}, {28, 28, 0}, {44, 36, 1}, {54, 50, 3}, {46, 62, 3}, {37, 57, 3}});
  tentacle({{5, 18, 4}, {11, 36, 0}, {20, 52, 1}, {17, 70, 3}, {6, 74, 3}, {4, 65, 3}});
  s.mirror_from(first);
  s.body({{0, 12, 2}, {0, -6, -2}, {0, -26, -3}, {0, -46, 0}}, {17, 17, 23, 17}, head, 5);
  s.ellipsoid({0, -36, -2}, {25, 29, 19}, head, 6);
  const std::size_t eyes = s.parts();
  s.ellipsoid({11.5, -4, -14}, {7, 7.5, 6}, white, 1.5);
  s.ellipsoid({11, -4, -19}, {4.6, 2.2, 2.2}, pupil);
  s.mirror_from(eyes);
}

}  // namespace vergence::render
