// Hues that follow the light: slowly to where they are seen, never far, back again without a target.
#include "algo/light_follower.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>

namespace vergence {
namespace {

void show(LightFollower& light, int channel, int configured, int seen, int pixels = 20) {
  for (int i = 0; i < pixels; ++i) {
    light.observe(channel, static_cast<std::uint8_t>(configured), static_cast<std::uint8_t>(seen));
  }
}

TEST(LightFollower, ComesToExpectWhatIsSeenAcrossZeroAsWell) {
  LightFollower light;
  for (int frame = 0; frame < 80; ++frame) {
    show(light, 0, 0, 240);  // 12 steps down, round the circle
    show(light, 1, 84, 94);
    light.end_frame(true);
  }
  EXPECT_EQ(light.expected(0, 0), 240);
  EXPECT_EQ(light.expected(1, 84), 94);
  EXPECT_EQ(light.expected(2, 168), 168);  // never observed
  EXPECT_NEAR(light.shift_deg(0), -12 * 360.0 / 252, 0.2);
}

TEST(LightFollower, IsSlow) {
  LightFollower light;
  show(light, 0, 84, 98);
  light.end_frame(true);
  EXPECT_LE(hue_distance(light.expected(0, 84), 84), 2);
}

TEST(LightFollower, FadesWithoutATargetAndForgetsAtOnce) {
  LightFollower light;
  for (int frame = 0; frame < 80; ++frame) {
    show(light, 0, 84, 98);
    light.end_frame(true);
  }
  const double learnt = light.shift_deg(0);
  for (int frame = 0; frame < 10; ++frame) light.end_frame(false);
  EXPECT_LT(light.shift_deg(0), 0.7 * learnt);
  for (int frame = 0; frame < 400; ++frame) light.end_frame(false);
  EXPECT_EQ(light.shift_deg(0), 0);
  show(light, 0, 84, 98);
  light.end_frame(true);
  light.forget();
  EXPECT_EQ(light.expected(0, 84), 84);
}

TEST(LightFollower, IgnoresFewPixelsAndThoseThatShowSomethingElse) {
  LightFollower light;
  for (int frame = 0; frame < 50; ++frame) {
    show(light, 0, 84, 94, 5);          // too few
    show(light, 1, 84, 84 + 60);        // another thing
    show(light, 2, 84, kHueUndefined);  // no hue
    show(light, 3, kHueDark, 84);
    light.end_frame(true);
  }
  for (int channel = 0; channel < 4; ++channel) EXPECT_EQ(light.shift_deg(channel), 0) << channel;
  EXPECT_EQ(light.expected(0, kHueDark), kHueDark);
}

RC_GTEST_PROP(LightFollowerProperty, NeverGoesBeyondItsBoundsAndStaysAHue, (std::uint64_t seed)) {
  LightFollower light;
  const int configured = static_cast<int>(seed % kHueSteps);
  int seen = configured;
  for (int frame = 0; frame < 300; ++frame) {
    seen = (seen + 1) % kHueSteps;  // creeping away, which it could follow for ever
    show(light, 0, configured, seen);
    light.end_frame(true);
    RC_ASSERT(std::abs(light.shift_deg(0)) <= LightFollower::kMaxShift_deg + 1e-9);
    RC_ASSERT(is_hue(light.expected(0, static_cast<std::uint8_t>(configured))));
  }
}

TEST(HueSector, CoversTheCircleInTwelve) {
  EXPECT_EQ(hue_sector(0), 0);
  EXPECT_EQ(hue_sector(251), kHueSectors - 1);
  for (int code = 1; code < kHueSteps; ++code) {
    const int step =
        hue_sector(static_cast<std::uint8_t>(code)) - hue_sector(static_cast<std::uint8_t>(code - 1));
    EXPECT_TRUE(step == 0 || step == 1);
  }
  EXPECT_LT(hue_sector(kHueOutside), kHueSectors);
}

}  // namespace
}  // namespace vergence
