// Hue codes of single pixels against the definition in real numbers, over every colour there is.
#include "algo/hue.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>

#include "algo/hue_plane.hpp"

namespace vergence {
namespace {

constexpr double kHalfStep_deg = 180.0 / kHueSteps;

// Eqs. 3.1-3.4 in real numbers; call only where the chroma is not zero.
double exact_hue_deg(double r, double g, double b) {
  const double V = std::max({r, g, b});
  const double C = V - std::min({r, g, b});
  double h = 0;
  if (V == r) {
    h = g >= b ? 60 * (g - b) / C : 360 + 60 * (g - b) / C;
  } else if (V == g) {
    h = 120 + 60 * (b - r) / C;
  } else {
    h = 240 + 60 * (r - g) / C;
  }
  return h;
}

double circular_deg(double a, double b) {
  const double d = std::fmod(std::abs(a - b), 360.0);
  return std::min(d, 360 - d);
}

TEST(HueOfRgb, IsWithinHalfAStepForAllColours) {
  const HueLimits limits{10, 250, 0};
  double worst = 0;
  for (int r = 0; r < 256; ++r) {
    for (int g = 0; g < 256; ++g) {
      for (int b = 0; b < 256; ++b) {
        const int V = std::max({r, g, b});
        const int v = std::min({r, g, b});
        const std::uint8_t code = hue_code_rgb(r, g, b, limits);
        if (V < 10) {
          ASSERT_EQ(code, kHueDark);
        } else if (v >= 250) {
          ASSERT_EQ(code, kHueBright);
        } else if (V == v) {
          ASSERT_EQ(code, kHueUndefined);
        } else {
          ASSERT_LT(code, kHueSteps);
          worst = std::max(worst, circular_deg(hue_degrees(code), exact_hue_deg(r, g, b)));
        }
      }
    }
  }
  EXPECT_LE(worst, kHalfStep_deg + 1e-9);
}

TEST(HueOfRgb, SaturationGateIsExact) {
  const HueLimits limits{0, 256, 400};
  for (int V = 0; V < 256; ++V) {
    for (int v = 0; v <= V; ++v) {
      const bool has_hue = V > v && 1000 * (V - v) >= 400 * V;
      EXPECT_EQ(is_hue(hue_code_rgb(V, v, v, limits)), has_hue) << V << " " << v;
    }
  }
}

TEST(HueOfRgb, HalfwayGoesToTheNextStep) {
  const HueLimits limits = kThesisHueLimits;
  EXPECT_EQ(hue_code_rgb(94, 11, 10, limits), 1);     // 0.5
  EXPECT_EQ(hue_code_rgb(94, 10, 11, limits), 0);     // 251.5
  EXPECT_EQ(hue_code_rgb(10, 94, 11, limits), 85);    // 84.5
  EXPECT_EQ(hue_code_rgb(11, 94, 10, limits), 84);    // 83.5
  EXPECT_EQ(hue_code_rgb(11, 10, 94, limits), 169);   // 168.5
  EXPECT_EQ(hue_code_rgb(10, 11, 94, limits), 168);   // 167.5
  EXPECT_EQ(hue_code_rgb(10, 14, 178, limits), 167);  // 167: not a tie
}

TEST(HueOfRgb, DarkComesBeforeBrightBeforeUndefined) {
  EXPECT_EQ(hue_code_rgb(150, 150, 150, {200, 100, 500}), kHueDark);
  EXPECT_EQ(hue_code_rgb(150, 150, 150, {150, 150, 500}), kHueBright);
  EXPECT_EQ(hue_code_rgb(150, 150, 150, {150, 151, 500}), kHueUndefined);
  EXPECT_EQ(hue_code_rgb(0, 0, 0, kThesisHueLimits), kHueUndefined);
}

TEST(HueCode, IsTheNearestOfItsDegrees) {
  for (int code = 0; code < kHueSteps; ++code) {
    const double degrees = hue_degrees(static_cast<std::uint8_t>(code));
    EXPECT_DOUBLE_EQ(degrees, code / 0.7);
    for (const double turns : {-720.0, -360.0, 0.0, 360.0, 36000.0}) {
      EXPECT_EQ(hue_code_from_degrees(degrees + turns), code);
      EXPECT_EQ(hue_code_from_degrees(degrees + turns + 0.999 * kHalfStep_deg), code);
      EXPECT_EQ(hue_code_from_degrees(degrees + turns - 0.999 * kHalfStep_deg), code);
    }
  }
}

TEST(HueOfRgb, PrimariesLieOnWholeSteps) {
  const HueLimits limits;
  EXPECT_EQ(hue_code_rgb(200, 0, 0, limits), 0);
  EXPECT_EQ(hue_code_rgb(200, 200, 0, limits), 42);
  EXPECT_EQ(hue_code_rgb(0, 200, 0, limits), 84);
  EXPECT_EQ(hue_code_rgb(0, 200, 200, limits), 126);
  EXPECT_EQ(hue_code_rgb(0, 0, 200, limits), 168);
  EXPECT_EQ(hue_code_rgb(200, 0, 200, limits), 210);
  EXPECT_EQ(hue_code_from_degrees(-120), 168);
  EXPECT_EQ(hue_code_from_degrees(359.9), 0);
  EXPECT_EQ(hue_code_from_degrees(std::nan("")), kHueUndefined);
  EXPECT_EQ(hue_tolerance_steps(20), 14);
  EXPECT_EQ(hue_tolerance_steps(30), 21);
  EXPECT_EQ(hue_tolerance_steps(1000), 126);
  EXPECT_EQ(hue_tolerance_steps(-1), 0);
}

// The unclipped BT.601 conversion, in its textbook form.
struct Rgb {
  double r, g, b;
};
Rgb unclipped_rgb(int y, int u, int v) {
  const double luma = (y - 16) / 219.0;
  const double pb = (u - 128) / 224.0;
  const double pr = (v - 128) / 224.0;
  const double r = luma + 1.402 * pr;
  const double b = luma + 1.772 * pb;
  return {255 * r, 255 * (luma - 0.299 / 0.587 * 1.402 * pr - 0.114 / 0.587 * 1.772 * pb), 255 * b};
}

TEST(HueOfYuv, AgreesWithTheDefinitionForAllValues) {
  for (const HueLimits& limits : {HueLimits{10, 250, 0}, HueLimits{30, 200, 400}, kThesisHueLimits}) {
    static YuvHueTable table;
    table.build(limits);
    constexpr double kRounding = 1e-9;  // of comparisons that are ties in real numbers
    double worst = 0;
    for (int y = 0; y < 256; ++y) {
      for (int u = 0; u < 256; ++u) {
        for (int v = 0; v < 256; ++v) {
          const auto [r, g, b] = unclipped_rgb(y, u, v);
          const double V = std::max({r, g, b});
          const double low = std::min({r, g, b});
          const double C = V - low;
          const std::uint8_t code = table.code(y, u, v);
          const double dark = V - limits.dark_below;
          const double bright = low - limits.bright_from;
          const double gate = 1000 * C - limits.min_saturation_permille * V;
          if (std::abs(dark) < kRounding || std::abs(bright) < kRounding || std::abs(gate) < 1e-6) continue;
          if (dark < 0) {
            ASSERT_EQ(code, kHueDark) << y << " " << u << " " << v;
          } else if (bright > 0) {
            ASSERT_EQ(code, kHueBright) << y << " " << u << " " << v;
          } else if ((u == 128 && v == 128) || gate < 0) {
            ASSERT_EQ(code, kHueUndefined) << y << " " << u << " " << v;
          } else {
            ASSERT_LT(code, kHueSteps) << y << " " << u << " " << v;
            worst = std::max(worst, circular_deg(hue_degrees(code), exact_hue_deg(r, g, b)));
          }
        }
      }
    }
    EXPECT_LE(worst, kHalfStep_deg + 1e-6);
  }
}

// Rounding r, g and b moves the chroma by at most 1 and the hue by at most 60 deg / chroma on the way, so
// that by at most 60 / (C - 1), C the chroma after rounding; both codes then round by half a step.
TEST(HueOfYuv, AgreesWithRoundedRgbWhereThatDoesNotClip) {
  static YuvHueTable table;
  table.build(kThesisHueLimits);
  long compared = 0;
  double worst_share = 0;
  for (int y = 0; y < 256; ++y) {
    for (int u = 0; u < 256; ++u) {
      for (int v = 0; v < 256; ++v) {
        const auto [r, g, b] = unclipped_rgb(y, u, v);
        if (std::min({r, g, b}) < 0 || std::max({r, g, b}) > 255) continue;
        const int R = static_cast<int>(std::lround(r));
        const int G = static_cast<int>(std::lround(g));
        const int B = static_cast<int>(std::lround(b));
        const int C = std::max({R, G, B}) - std::min({R, G, B});
        if (C < 2) continue;
        const double bound = 60.0 / (C - 1) + 2 * kHalfStep_deg;
        const std::uint8_t of_rgb = hue_code_rgb(R, G, B, kThesisHueLimits);
        const std::uint8_t of_yuv = table.code(y, u, v);
        ASSERT_TRUE(is_hue(of_rgb) && is_hue(of_yuv)) << y << " " << u << " " << v;
        const double apart = circular_deg(hue_degrees(of_rgb), hue_degrees(of_yuv));
        ASSERT_LE(apart, bound) << y << " " << u << " " << v;
        worst_share = std::max(worst_share, apart / bound);
        ++compared;
      }
    }
  }
  EXPECT_GT(compared, 2'500'000);  // about a sixth of YUV lies inside the cube of RGB
  EXPECT_GT(worst_share, 0.5);     // the bound is not idle
}

TEST(HueDistance, ObeysTheTriangleInequality) {
  const auto distance = [](int a, int b) {
    return hue_distance(static_cast<std::uint8_t>(a), static_cast<std::uint8_t>(b));
  };
  int violations = 0;
  for (int a = 0; a < kHueSteps; ++a) {
    for (int b = 0; b < kHueSteps; ++b) {
      for (int c = 0; c < kHueSteps; ++c) violations += distance(a, c) > distance(a, b) + distance(b, c);
    }
  }
  EXPECT_EQ(violations, 0);
}

TEST(HueDistance, IsACircularMetric) {
  ASSERT_TRUE(rc::check([] {
    const auto any = [] { return static_cast<std::uint8_t>(*rc::gen::inRange(0, kHueSteps)); };
    const std::uint8_t a = any();
    const std::uint8_t b = any();
    const std::uint8_t c = any();
    RC_ASSERT(hue_distance(a, b) == hue_distance(b, a));
    RC_ASSERT((hue_distance(a, b) == 0) == (a == b));
    RC_ASSERT(hue_distance(a, b) <= kHueSteps / 2);
    RC_ASSERT(hue_distance(a, c) <= hue_distance(a, b) + hue_distance(b, c));
    const int turn = *rc::gen::inRange(0, kHueSteps);
    const auto turned = [turn](std::uint8_t h) { return static_cast<std::uint8_t>((h + turn) % kHueSteps); };
    RC_ASSERT(hue_distance(turned(a), turned(b)) == hue_distance(a, b));
  }));
  for (int code = kHueSteps; code < 256; ++code) {
    EXPECT_EQ(hue_distance(static_cast<std::uint8_t>(code), 0), 255);
    EXPECT_EQ(hue_distance(static_cast<std::uint8_t>(code), static_cast<std::uint8_t>(code)), 255);
  }
}

}  // namespace
}  // namespace vergence
