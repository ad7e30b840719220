// Those seen from above: turtle, mobula, ribbontail ray, crab. In mm about life proportions; -y is ahead, -z
// towards the viewer.
#include <algorithm>
#include <cmath>

#include "tools/render/creatures.hpp"

namespace vergence::render {

void build_turtle(Sculpture& s) {
  const Rgb dark = from_hsv(205, 0.75, 0.42);
  const auto shell =
      s.paint(from_hsv(188, 0.80, 0.50), {{Pattern::kMottle, from_hsv(165, 0.70, 0.62), 12, 0.35},
                                          {Pattern::kSpots, from_hsv(55, 0.45, 0.95), 9, 0.20}});
  const auto ridge = s.paint(from_hsv(32, 0.80, 0.85), {{Pattern::kMottle, from_hsv(20, 0.8, 0.65), 6, 0.4}});
  const auto skin =
      s.paint(from_hsv(105, 0.62, 0.60), {{Pattern::kSpots, from_hsv(62, 0.60, 0.92), 6, 0.24},
                                          {Pattern::kMottle, from_hsv(130, 0.7, 0.40), 9, 0.25}});
  const auto flipper =
      s.paint(from_hsv(112, 0.60, 0.52), {{Pattern::kRim, from_hsv(62, 0.55, 0.90), 1.8, 0.5},
                                          {Pattern::kSpots, from_hsv(70, 0.60, 0.90), 6.5, 0.22}});
  const auto eye = s.paint({0.005F, 0.005F, 0.008F});
  const auto rim = s.paint(dark);

  s.plate({{0, -38},
           {20, -33},
           {33, -16},
           {35, 6},
           {27, 28},
           {10, 44},
           {0, 54},
           {-10, 44},
           {-27, 28},
           {-35, 6},
           {-33, -16},
           {-20, -33}},
          2, 12, rim, 0, 6);
  s.ellipsoid({0, 4, 0}, {31, 43, 14}, shell, 2);
  for (const double x : {-18.0, -9.0, 0.0, 9.0, 18.0}) {
    const auto on_shell = [](double u, double v) {
      const double z = 1 - u * u / (31.0 * 31.0) - (v - 4) * (v - 4) / (43.0 * 43.0);
      return Vector3(u, v, -14 * std::sqrt(std::max(z, 0.0)));
    };
    s.limb({on_shell(x * 0.6, -28), on_shell(x, -12), on_shell(x * 1.1, 6), on_shell(x * 0.85, 24),
            on_shell(x * 0.4, 38)},
           1.8, 1.2, ridge, 1.5);
  }
  s.limb({{0, -34, 1}, {0, -45, -1}, {0, -51, -1}}, 8, 9, skin, 4);
  s.ellipsoid({0, -52, -1}, {9.5, 10, 8}, skin, 3);
  const std::size_t first = s.parts();
  s.ellipsoid({7.2, -54, -5}, {2.6, 2.6, 2.6}, eye);
  s.plate({{24, -26}, {36, -34}, {54, -32}, {70, -14}, {77, 8}, {66, 2}, {52, -10}, {34, -12}, {25, -14}}, 2,
          8, flipper, 3, 7, {-0.04, 0, 0});
  s.plate({{18, 30}, {28, 32}, {37, 44}, {38, 54}, {28, 50}, {18, 42}}, 2, 6, flipper, 3, 5);
  s.mirror_from(first);
}

void build_mobula(Sculpture& s) {
  const auto back =
      s.paint(from_hsv(218, 0.78, 0.45), {{Pattern::kMottle, from_hsv(195, 0.75, 0.60), 16, 0.40},
                                          {Pattern::kSpots, from_hsv(180, 0.35, 0.95), 8, 0.14},
                                          {Pattern::kRim, from_hsv(330, 0.50, 0.80), 2.0, 0.5}});
  const auto shoulder =
      s.paint(from_hsv(48, 0.55, 0.95), {{Pattern::kMottle, from_hsv(20, 0.6, 0.85), 7, 0.35}});
  const auto horn = s.paint(from_hsv(262, 0.55, 0.55));
  const auto body =
      s.paint(from_hsv(225, 0.75, 0.38), {{Pattern::kMottle, from_hsv(285, 0.5, 0.50), 9, 0.4}});
  const auto tail =
      s.paint(from_hsv(210, 0.6, 0.40), {{Pattern::kStripes, from_hsv(45, 0.6, 0.9), 8, 0.35, {0, 1, 0}}});
  const auto eye = s.paint({0.006F, 0.006F, 0.01F});

  s.plate({{0, -26},
           {12, -25},
           {24, -18},
           {40, -10},
           {58, 8},
           {62, 19},
           {48, 12},
           {30, 14},
           {14, 22},
           {0, 26},
           {-14, 22},
           {-30, 14},
           {-48, 12},
           {-62, 19},
           {-58, 8},
           {-40, -10},
           {-24, -18},
           {-12, -25}},
          0, 12, back, 0, 22, {0, 0, 0.0018});
  s.ellipsoid({0, -4, -2}, {12, 23, 8.5}, body, 8);
  s.limb({{0, 18, -1}, {1, 32, 0}, {-2, 46, 0}, {3, 58, 0}}, 2.4, 1.2, tail, 3);
  s.plate({{-4, 21}, {0, 16}, {4, 21}, {2, 27}, {-2, 27}}, -4, 6, body, 2, 3);
  const std::size_t first = s.parts();
  s.ellipsoid({13, -11, -5}, {7.5, 4.5, 2.8}, shoulder, 1.0, 30);
  s.limb({{9, -21, -1}, {12, -30, -2}, {9, -38, -2}}, 3.4, 2.0, horn, 3);
  s.ellipsoid({12.5, -21.5, -4}, {2.6, 2.6, 2.6}, eye);
  s.mirror_from(first);
}

void build_ray(Sculpture& s) {
  // Disc to the left, tail to the right.
  const Rgb blue = from_hsv(212, 0.90, 0.90);
  const auto disc = s.paint(from_hsv(38, 0.78, 0.80), {{Pattern::kMottle, from_hsv(22, 0.80, 0.58), 15, 0.30},
                                                       {Pattern::kRim, from_hsv(75, 0.55, 0.70), 3.0, 0.5},
                                                       {Pattern::kSpots, blue, 11, 0.27}});
  const auto body = s.paint(from_hsv(30, 0.75, 0.68), {{Pattern::kSpots, blue, 10, 0.26},
                                                       {Pattern::kMottle, from_hsv(15, 0.75, 0.5), 8, 0.3}});
  const auto tail = s.paint(from_hsv(48, 0.65, 0.80),
                            {{Pattern::kStripes, from_hsv(205, 0.85, 0.80), 11, 0.45, {0.96, 0.28, 0}}});
  const auto ribbon =
      s.paint(from_hsv(275, 0.55, 0.60), {{Pattern::kRim, from_hsv(320, 0.5, 0.85), 1.2, 0.5}});
  const auto eye = s.paint(from_hsv(120, 0.6, 0.35));
  const auto pupil = s.paint({0.005F, 0.005F, 0.005F});
  s.plate({{-74, 0},
           {-70, -14},
           {-56, -32},
           {-36, -42},
           {-14, -38},
           {0, -24},
           {8, -10},
           {10, 0},
           {8, 10},
           {0, 24},
           {-14, 38},
           {-36, 42},
           {-56, 32},
           {-70, 14}},
          0, 9, disc, 0, 20);
  s.ellipsoid({-34, 0, -2}, {36, 15, 6.5}, body, 8);
  s.plate({{-2, -14}, {10, -22}, {20, -18}, {14, -8}, {4, -6}}, 0, 5, disc, 3, 4);
  s.plate({{-2, 14}, {10, 22}, {20, 18}, {14, 8}, {4, 6}}, 0, 5, disc, 3, 4);
  s.limb({{0, 0, -1}, {24, -4, -1}, {46, 6, 0}, {62, 4, 0}, {78, -6, 0}}, 6, 1.6, tail, 4);
  s.plate({{36, -3}, {48, -4}, {62, -8}, {80, -16}, {82, -8}, {70, 6}, {56, 14}, {44, 10}}, 0, 3, ribbon, 1,
          4);
  for (const double y : {-11.0, 11.0}) {
    s.ellipsoid({-53, y, -5}, {4.2, 3.8, 4.0}, eye, 1);
    s.ellipsoid({-54, y * 1.1, -7.6}, {1.9, 1.9, 1.9}, pupil);
  }
}

void build_crab(Sculpture& s) {
  const Rgb cream = from_hsv(48, 0.35, 0.98);
  const auto shell =
      s.paint(from_hsv(10, 0.85, 0.80),
              {{Pattern::kMottle, from_hsv(352, 0.85, 0.52), 16, 0.38},
               {Pattern::kSpots, from_hsv(46, 0.75, 0.98), 11, 0.20},
               {Pattern::kPatch, from_hsv(30, 0.85, 0.92), 11, 0.5, Vector3::UnitX(), {0, 6, -20}},
               {Pattern::kPatch, from_hsv(285, 0.55, 0.50), 6, 0.5, Vector3::UnitX(), {-22, -2, -17}},
               {Pattern::kPatch, from_hsv(285, 0.55, 0.50), 6, 0.5, Vector3::UnitX(), {22, -2, -17}}});
  const auto claw = s.paint(from_hsv(4, 0.88, 0.75), {{Pattern::kMottle, from_hsv(24, 0.88, 0.90), 11, 0.40},
                                                      {Pattern::kSpots, cream, 9, 0.15}});
  const auto finger =
      s.paint(from_hsv(42, 0.55, 0.95),
              {{Pattern::kGradient, from_hsv(340, 0.6, 0.35), 16, 0.5, {0, -1, 0}, {0, -72, 0}}});
  const auto arm = s.paint(from_hsv(18, 0.85, 0.82), {{Pattern::kSpots, from_hsv(280, 0.5, 0.50), 8, 0.26}});
  const auto leg = s.paint(from_hsv(26, 0.82, 0.88),
                           {{Pattern::kRings, from_hsv(268, 0.55, 0.55), 19, 0.40, {0, 0, 1}, {0, 8, 0}}});
  const auto tip = s.paint(from_hsv(205, 0.70, 0.62));
  const auto stalk = s.paint(from_hsv(55, 0.70, 0.85));
  const auto eye = s.paint({0.004F, 0.004F, 0.006F});
  const auto glint = s.paint({0.9F, 0.9F, 0.9F});

  s.ellipsoid({0, 9, -1}, {50, 34, 19}, shell, 0);
  s.ellipsoid({0, -4, 1}, {44, 25, 15}, shell, 10);
  for (const double x : {-40.0, -30.0, -20.0, 20.0, 30.0, 40.0}) {  // teeth of the front edge
    const double y = -26 + 0.011 * x * x;
    s.limb({{x * 0.95, y + 4, 0}, {x * 1.06, y - 5, -1}}, 4, 0.8, shell, 3);
  }
  const std::size_t first = s.parts();
  // Arm, hand and the two fingers of the claw.
  s.limb({{36, -10, 1}, {58, -20, -1}, {66, -38, -3}}, 8, 8, arm, 4);
  s.ellipsoid({60, -58, -4}, {16, 23, 13}, claw, 5, -18);
  s.limb({{68, -70, -4}, {66, -88, -3}, {52, -101, -2}}, 9, 2, finger, 5);
  s.limb({{54, -72, -4}, {44, -84, -3}, {44, -96, -2}}, 7, 1.8, finger, 4);
  // Walking legs.
  for (int i = 0; i < 4; ++i) {
    const double y = -2.0 + 11.5 * i;
    const double spread = -8.0 + 13.5 * i;
    const Vector3 hip(38 - 2.5 * i, y, 3);
    const Vector3 knee(64 - 4.0 * i, y - 4 + 0.62 * spread, -5);
    const Vector3 shin(80 - 6.5 * i, y + 8 + 0.95 * spread, 2);
    const Vector3 toe(88 - 9.5 * i, y + 20 + 1.05 * spread, 9);
    s.limb({hip, knee}, 5.6, 5.2, leg, 3);
    s.limb({knee, shin}, 4.8, 3.4, leg, 1);
    s.limb({shin, toe}, 3.2, 1.0, tip, 1);
  }
  s.limb({{11, -24, -6}, {13, -33, -11}}, 3.2, 3.2, stalk, 2);
  s.ellipsoid({13.2, -35, -13}, {5.2, 5.2, 5.2}, eye);
  s.ellipsoid({11.8, -36.6, -17.4}, {1.4, 1.4, 1.4}, glint);
  s.mirror_from(first);
}

}  // namespace vergence::render
