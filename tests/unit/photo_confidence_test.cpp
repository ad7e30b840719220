// Confidence of a photo-model: what it takes from evidence, and what evidence says of pictures.
#include "algo/photo_confidence.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>

#include "algo/photo_likeness.hpp"

namespace vergence {
namespace {

PhotoEvidence good_evidence() {
  PhotoEvidence evidence;
  evidence.left = evidence.right = 0.95;
  evidence.left_right_cost = 0.15;
  evidence.luma = 0.95;
  evidence.worst_quarter = 0.9;
  evidence.depth_mm = 0.2;
  evidence.e = 0.01;
  return evidence;
}

TEST(PhotoConfidence, RisesWithLikenessAndWhereTheTargetWasFollowed) {
  for (double likeness = 0.1; likeness < 1; likeness += 0.05) {
    PhotoEvidence less = good_evidence();
    less.left = likeness;
    less.right = likeness - 0.1;
    less.luma = 0;
    less.worst_quarter = 0;
    PhotoEvidence more = less;
    more.left += 0.04;
    EXPECT_LT(photo_confidence(less, false), photo_confidence(more, false)) << likeness;
    EXPECT_LT(photo_confidence(less, false), photo_confidence(less, true)) << likeness;
  }
}

TEST(PhotoConfidence, FallsWhereAnyOfTheEvidenceSpeaksAgainstThePose) {
  const double sure = photo_confidence(good_evidence(), false);
  EXPECT_GT(sure, 0.99);
  const std::array<void (*)(PhotoEvidence&), 4> worse{
      [](PhotoEvidence& e) { e.luma = 0; }, [](PhotoEvidence& e) { e.worst_quarter = 0; },
      [](PhotoEvidence& e) { e.depth_mm = 2; }, [](PhotoEvidence& e) { e.e = 0.04; }};
  for (const auto& change : worse) {
    PhotoEvidence evidence = good_evidence();
    change(evidence);
    EXPECT_LT(photo_confidence(evidence, false), sure);
  }
}

// As it was measured: an orange crab where an orange squid is looked for, and a mobula seen from aside.
TEST(PhotoConfidence, TellsAnotherThingOfTheSameColourFromAnObliqueTarget) {
  PhotoEvidence crab;
  crab.left = 0.37;
  crab.right = 0.49;
  crab.left_right_cost = 0.72;
  crab.luma = 0.2;
  crab.worst_quarter = 0.06;
  crab.depth_mm = 1.18;
  crab.e = 0.01;
  EXPECT_LT(photo_confidence(crab, false), 0.5);
  PhotoEvidence mobula;
  mobula.left = 0.65;
  mobula.right = 0.33;
  mobula.left_right_cost = 0.41;
  mobula.luma = 0.82;
  mobula.worst_quarter = 0.32;
  mobula.depth_mm = 0.45;
  mobula.e = 0.01;
  EXPECT_GT(photo_confidence(mobula, false), 0.5);
}

TEST(PhotoConfidence, WithoutEvidenceIsNone) {
  EXPECT_LT(photo_confidence({}, true), 0.01);
}

// A square of 20 x 20 points with a pattern, and a camera that sees it.
class PhotoLikenessTest : public ::testing::Test {
 protected:
  static constexpr unsigned kSide = 20;
  static constexpr int kPoints = kSide * kSide;

  void SetUp() override {
    for (unsigned i = 0; i < kPoints; ++i) {
      const double x = i % kSide - 9.5;
      const double y = static_cast<double>(i / kSide) - 9.5;
      model_->x_mm[i] = static_cast<float>(x);
      model_->y_mm[i] = static_cast<float>(y);
      samples_->weight[i] = 1;
      const std::array<double, 3> colour{40 * std::sin(x) + 5 * y, 20 * std::cos(0.7 * y),
                                         15 * std::sin(0.9 * x)};
      for (unsigned c = 0; c < 3; ++c) {
        photo_[4 * i + c] = static_cast<float>(colour[c]);
        samples_->value[4 * i + c] = static_cast<float>(0.6 * colour[c] + 11);
      }
    }
  }

  [[nodiscard]] PhotoLikeness likeness() const {
    return photo_likeness(*model_, kPoints, *samples_, photo_.data());
  }

  std::unique_ptr<PhotoModel> model_ = std::make_unique<PhotoModel>();
  std::unique_ptr<RefineSamples> samples_ = std::make_unique<RefineSamples>();
  std::array<float, std::size_t{4} * kPoints> photo_{};
};

TEST_F(PhotoLikenessTest, IsWholeUnderAnotherLight) {
  EXPECT_GT(likeness().luma, 0.95);
  EXPECT_GT(likeness().worst_quarter, 0.9);
}

TEST_F(PhotoLikenessTest, MissesBrightnessThatIsAnother) {
  const double before = likeness().luma;
  for (unsigned i = 0; i < kPoints; ++i) samples_->value[4 * i] = 50 * static_cast<float>(i * 7 % 11);
  EXPECT_GT(before, 0.95);
  EXPECT_LT(std::abs(likeness().luma), 0.3);
}

TEST_F(PhotoLikenessTest, SaysWhenOneQuarterIsOfSomethingElse) {
  for (unsigned i = 0; i < kPoints; ++i) {
    if (!(model_->x_mm[i] > 0 && model_->y_mm[i] > 0)) continue;
    for (unsigned c = 0; c < 3; ++c) samples_->value[4 * i + c] *= -1;
  }
  EXPECT_LT(likeness().worst_quarter, -0.5);
}

TEST_F(PhotoLikenessTest, ClaimsNothingOfAQuarterNobodySees) {
  for (unsigned i = 0; i < kPoints; ++i) {
    if (model_->x_mm[i] > 0) samples_->weight[i] = 0;
  }
  EXPECT_EQ(likeness().worst_quarter, 0);
  EXPECT_GT(likeness().luma, 0.9);
  for (unsigned i = 0; i < kPoints; ++i) samples_->weight[i] = 0;
  EXPECT_EQ(likeness().luma, 0);
}

}  // namespace
}  // namespace vergence
