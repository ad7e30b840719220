// Those seen from the side: seahorse, coelacanth, moray, dolphin, anemonefish. Heads to the left or up.
#include "tools/render/creatures.hpp"

namespace vergence::render {
namespace {

// White, iris and pupil, looking towards the viewer at z.
void add_eye(Sculpture& s, const Vector3& at, double radius, const Rgb& iris) {
  const auto outer = s.paint(iris);
  const auto pupil = s.paint({0.004F, 0.004F, 0.006F});
  const auto glint = s.paint({0.9F, 0.9F, 0.9F});
  s.ellipsoid(at, {radius, radius, radius * 0.6}, outer, 0.5);
  s.ellipsoid(at + Vector3(0, 0, -radius * 0.42), {radius * 0.58, radius * 0.58, radius * 0.42}, pupil);
  s.ellipsoid(at + Vector3(-radius * 0.2, -radius * 0.22, -radius * 0.80),
              {radius * 0.16, radius * 0.16, radius * 0.12}, glint);
}

}  // namespace

void build_seahorse(Sculpture& s) {
  const auto skin = s.paint(from_hsv(48, 0.85, 0.92),
                            {{Pattern::kGradient, from_hsv(24, 0.88, 0.88), 60, 0.5, {0, 1, 0}, {0, -5, 0}},
                             {Pattern::kStripes, from_hsv(14, 0.85, 0.62), 7, 0.26, {0.12, 0.99, 0}},
                             {Pattern::kSpots, from_hsv(190, 0.6, 0.80), 10, 0.13}});
  const auto belly =
      s.paint(from_hsv(56, 0.45, 0.98), {{Pattern::kStripes, from_hsv(30, 0.75, 0.8), 5.5, 0.3, {0, 1, 0}}});
  const auto head = s.paint(from_hsv(44, 0.85, 0.92), {{Pattern::kMottle, from_hsv(20, 0.85, 0.75), 8, 0.3}});
  const auto crown = s.paint(from_hsv(338, 0.65, 0.75));
  const auto fin = s.paint(from_hsv(285, 0.45, 0.75),
                           {{Pattern::kStripes, from_hsv(325, 0.5, 0.9), 4, 0.45, {0.2, 0.98, 0}}});
  // Head looks left; body an S; tail curls forward.
  s.body({{2, -40, 0},
          {7, -28, 0},
          {6, -12, 0},
          {2, 4, 0},
          {3, 20, 0},
          {7, 34, 0},
          {7, 46, 0},
          {0, 54, 0},
          {-8, 51, 0},
          {-8, 43, 0},
          {-2, 42, 0}},
         {8, 9.5, 12, 12.5, 9, 6.5, 5, 4, 3.2, 2.6, 2}, skin, 3);
  s.ellipsoid({-3.5, -3, -2}, {9, 15, 9.5}, belly, 3, 8);
  s.ellipsoid({-1, -49, 0}, {10.5, 9.5, 9}, head, 4, 12);
  s.limb({{-8, -46, 0}, {-18, -41.5, 0}, {-22, -40, 0}}, 4.4, 3.2, head, 3);
  s.ellipsoid({-23, -39.6, 0}, {2.2, 3.6, 3.6}, crown, 1);
  for (const double x : {-3.0, 2.0, 7.0}) s.limb({{x, -56, 0}, {x * 1.5 + 1, -63.5, 0}}, 2.6, 0.9, crown, 2);
  for (int i = 0; i < 4; ++i) s.limb({{11, -40 + 8.0 * i, 0}, {17.5, -42 + 8.2 * i, 0}}, 2.8, 0.8, crown, 2);
  s.plate({{12, -16}, {19, -20}, {24, -10}, {22, 4}, {12, 4}}, 0, 4, fin, 1, 4);
  add_eye(s, {-4.5, -50.5, -8.6}, 3.8, from_hsv(150, 0.6, 0.75));
}

void build_coelacanth(Sculpture& s) {
  const auto body = s.paint(from_hsv(214, 0.75, 0.48),
                            {{Pattern::kMottle, from_hsv(235, 0.65, 0.34), 16, 0.35},
                             {Pattern::kGradient, from_hsv(28, 0.42, 0.78), 14, 0.5, {0, 1, 0}, {0, 10, 0}},
                             {Pattern::kSpots, from_hsv(335, 0.22, 0.95), 13, 0.24},
                             {Pattern::kSpots, from_hsv(175, 0.45, 0.80), 9, 0.13}});
  const auto head = s.paint(from_hsv(200, 0.70, 0.50),
                            {{Pattern::kMottle, from_hsv(180, 0.6, 0.62), 10, 0.35},
                             {Pattern::kGradient, from_hsv(28, 0.45, 0.80), 10, 0.5, {0, 1, 0}, {0, 10, 0}}});
  const auto lobe =
      s.paint(from_hsv(222, 0.65, 0.42), {{Pattern::kSpots, from_hsv(335, 0.25, 0.92), 8, 0.22}});
  const auto fin = s.paint(from_hsv(34, 0.80, 0.82),
                           {{Pattern::kStripes, from_hsv(14, 0.80, 0.60), 4.5, 0.42, {0.8, 0.6, 0}}});
  const auto tail = s.paint(from_hsv(38, 0.75, 0.85),
                            {{Pattern::kStripes, from_hsv(348, 0.65, 0.62), 5, 0.42, {0.1, 0.99, 0}}});
  const auto mouth = s.paint(from_hsv(355, 0.6, 0.25));
  s.body({{-58, 2, 0}, {-42, 0, 0}, {-20, -1, 0}, {4, -1, 0}, {28, 0, 0}, {48, 1, 0}, {62, 1, 0}},
         {9, 16, 20, 20, 15, 9, 5.5}, body, 2);
  s.ellipsoid({-50, 2, 0}, {19, 16, 15}, head, 6);
  s.limb({{-69, 6, -6}, {-60, 9, -13}, {-50, 9.5, -15.5}}, 1.6, 1.2, mouth, 0.5);
  s.plate({{56, -8},
           {66, -24},
           {84, -27},
           {86, -12},
           {84, 0},
           {92, 1},
           {84, 3},
           {86, 14},
           {84, 28},
           {66, 25},
           {56, 9}},
          0, 8, tail, 4, 7);
  s.plate({{-24, -18}, {-22, -38}, {-10, -38}, {-2, -30}, {-4, -18}}, 0, 6, fin, 2, 4);
  // Lobed fins: a fleshy stalk each, with rays around.
  const auto lobed = [&](const Vector3& root, const Vector3& end, double out) {
    const Vector3 d = (end - root).normalized();
    const Vector2 tip = (end + out * d).head<2>();
    const Vector2 n(-d[1] * 9, d[0] * 9);
    s.plate({(end - 6 * d).head<2>() + 0.6 * n, end.head<2>() + n, tip + 0.5 * n, tip - 0.5 * n,
             end.head<2>() - n, (end - 6 * d).head<2>() - 0.6 * n},
            end[2], 5, fin, 1, 4);
    s.limb({root, end}, 7, 5, lobe, 4);
  };
  lobed({16, -12, -2}, {28, -24, -2}, 12);
  lobed({22, 12, -2}, {34, 23, -2}, 12);
  lobed({-8, 14, -8}, {2, 27, -12}, 12);
  lobed({-34, 8, -16}, {-24, 20, -27}, 14);
  add_eye(s, {-56, -4, -12.5}, 4.6, from_hsv(62, 0.75, 0.90));
  // The far pair of fins gives the toy its thickness.
  lobed({-34, 8, 16}, {-24, 20, 27}, 10);
}

void build_moray(Sculpture& s) {
  const auto skin =
      s.paint(from_hsv(50, 0.85, 0.88), {{Pattern::kMottle, from_hsv(78, 0.72, 0.62), 12, 0.38},
                                         {Pattern::kSpots, from_hsv(18, 0.80, 0.42), 8.5, 0.33}});
  const auto belly = s.paint(from_hsv(58, 0.35, 0.96));
  const auto fin =
      s.paint(from_hsv(172, 0.65, 0.60), {{Pattern::kRim, from_hsv(200, 0.75, 0.80), 1.3, 0.5},
                                          {Pattern::kStripes, from_hsv(150, 0.6, 0.45), 6, 0.4, {1, 0, 0}}});
  const auto mouth = s.paint(from_hsv(350, 0.70, 0.65));
  const auto tooth = s.paint({0.85F, 0.85F, 0.80F});
  s.plate({{-48, -9},
           {-38, -16},
           {-20, -14},
           {0, -4},
           {20, 2},
           {40, -8},
           {56, -14},
           {70, -8},
           {73, -3},
           {60, 2},
           {40, 4},
           {20, 12},
           {0, 8},
           {-20, -2},
           {-40, -4}},
          1, 4, fin, 0, 4);
  s.body(
      {{-52, 2, 0}, {-40, 0, 0}, {-24, -2, 0}, {-4, 4, 0}, {16, 9, 0}, {36, 3, 0}, {54, -4, 0}, {68, -5, 0}},
      {8.5, 10, 9.5, 9, 8.5, 7.5, 5.5, 2.5}, skin, 2);
  s.limb({{-42, 7, -4}, {-26, 5, -5}, {-6, 11, -4}}, 4, 3, belly, 3);
  // Open jaws.
  s.limb({{-54, -2, 0}, {-64, -5, 0}, {-72, -6, 0}}, 7, 3, skin, 3);
  s.limb({{-54, 6, 0}, {-63, 9, 0}, {-70, 11, 0}}, 5.5, 2.2, skin, 3);
  s.limb({{-52, 2.2, -5}, {-63, 2.2, -3}}, 3.2, 1.6, mouth, 1);
  for (int i = 0; i < 3; ++i) {
    s.limb({{-68.0 + 5 * i, -2.5, -2.5}, {-68.0 + 5 * i, 1.2, -2.5}}, 1.0, 0.4, tooth);
    s.limb({{-67.0 + 5 * i, 8.0 - i, -2.5}, {-67.0 + 5 * i, 4.6 - i, -2.5}}, 0.9, 0.4, tooth);
  }
  add_eye(s, {-58, -6, -6.8}, 2.8, from_hsv(205, 0.7, 0.85));
}

void build_dolphin(Sculpture& s) {
  // Leaping up to the left, tail at the lower right.
  const auto back =
      s.paint(from_hsv(212, 0.62, 0.66),
              {{Pattern::kMottle, from_hsv(225, 0.65, 0.48), 14, 0.32},
               {Pattern::kGradient, from_hsv(190, 0.45, 0.82), 16, 0.5, {-0.75, 0.66, 0}, {-2, 0, 0}}});
  const auto belly =
      s.paint(from_hsv(18, 0.30, 0.98), {{Pattern::kMottle, from_hsv(345, 0.38, 0.92), 8, 0.4}});
  const auto fin = s.paint(from_hsv(232, 0.62, 0.50), {{Pattern::kRim, from_hsv(270, 0.45, 0.62), 1.5, 0.5}});
  const auto beak = s.paint(from_hsv(205, 0.50, 0.70));
  const auto stripe = s.paint(from_hsv(48, 0.55, 0.95));
  s.body({{-17, -27, 0}, {-10, -26, 0}, {2, -18, 0}, {10, -4, 0}, {13, 10, 0}, {11, 24, 0}, {6, 33, 0}},
         {7.5, 10, 12.5, 12.5, 9.5, 5.5, 3.2}, back, 3);
  s.body({{-17, -23, -2}, {-10, -19, -3}, {-2, -10, -3}, {4, 2, -3}, {9, 14, -2}}, {5, 7.5, 9, 8, 4}, belly,
         4);
  s.limb({{-20, -27, 0}, {-30, -24, 0}}, 5, 2.6, beak, 3);
  s.plate({{8, -22}, {18, -29}, {29, -29}, {24, -20}, {21, -10}, {14, -8}}, 0, 5, fin, 2, 4);
  s.plate({{-9, -10}, {0, -8}, {-2, 2}, {-10, 14}, {-16, 17}, {-15, 6}}, -11, 5, fin, 3, 4);
  s.plate({{4, 30}, {12, 31}, {22, 38}, {26, 46}, {16, 43}, {7, 39}, {-4, 46}, {-14, 46}, {-8, 37}}, 0, 6,
          fin, 3, 4);
  s.limb({{-14, -24, -8.8}, {-4, -17, -11.6}, {3, -8, -11.8}}, 1.5, 1.0, stripe, 1);
  s.ellipsoid({2, -12, 11}, {7, 9, 6}, belly, 4);
  add_eye(s, {-16, -29, -6.8}, 2.5, from_hsv(25, 0.6, 0.5));
}

void build_anemonefish(Sculpture& s) {
  const Rgb white{0.86F, 0.88F, 0.90F};
  const Rgb black{0.012F, 0.012F, 0.016F};
  std::vector<Layer> bands;
  const auto band = [&](double x, double width) {
    const Vector3 along(1, 0, 0);
    bands.push_back({Pattern::kBand, black, width + 3.6, 0.5, along, {x, 0, 0}});
    bands.push_back({Pattern::kBand, white, width, 0.5, along, {x, 0, 0}});
  };
  bands.push_back({Pattern::kGradient, from_hsv(44, 0.90, 0.98), 16, 0.5, {0, 1, 0}, {0, -2, 0}});
  bands.push_back({Pattern::kMottle, from_hsv(8, 0.92, 0.80), 14, 0.28});
  band(-27, 9);
  band(9, 10);
  band(35, 6);
  const auto body = s.paint(from_hsv(22, 0.93, 0.95), bands);
  const auto fin = s.paint(from_hsv(26, 0.90, 0.95),
                           {{Pattern::kStripes, from_hsv(10, 0.9, 0.7), 4.5, 0.35, {0.9, 0.4, 0}},
                            {Pattern::kRim, black, 2.2, 0.5}});
  const auto lateral = s.paint(from_hsv(50, 0.85, 0.98),
                               {{Pattern::kRim, from_hsv(210, 0.7, 0.55), 2.0, 0.5},
                                {Pattern::kStripes, from_hsv(28, 0.9, 0.85), 3.6, 0.35, {0.3, 0.95, 0}}});
  const auto mouth = s.paint(from_hsv(355, 0.55, 0.45));
  s.plate({{-26, -14}, {-12, -25}, {2, -24}, {10, -20}, {20, -25}, {32, -20}, {34, -8}, {0, -6}}, 0, 6, fin,
          0, 4);
  s.plate({{4, 12}, {10, 23}, {24, 22}, {32, 12}, {20, 6}}, 0, 6, fin, 0, 4);
  s.plate({{-22, 14}, {-18, 25}, {-8, 26}, {-6, 16}}, -3, 5, fin, 0, 4);
  s.body({{-48, 2, 0}, {-34, 0, 0}, {-14, -1, 0}, {8, -1, 0}, {28, 0, 0}, {42, 0, 0}},
         {9, 16, 20, 18.5, 11, 6}, body, 2);
  s.plate({{38, -5}, {48, -14}, {62, -17}, {67, -8}, {64, 0}, {67, 8}, {62, 17}, {48, 14}, {38, 5}}, 0, 7,
          fin, 3, 5);
  s.plate({{-18, 2}, {-8, -5}, {4, -3}, {7, 5}, {0, 12}, {-10, 11}}, -22, 6, lateral, 2, 5);
  s.limb({{-56, 6, -3}, {-51, 8, -6.5}}, 1.6, 1.2, mouth, 0.5);
  add_eye(s, {-43, -4, -11}, 4.4, from_hsv(40, 0.85, 0.85));
}

}  // namespace vergence::render
