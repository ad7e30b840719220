// The accuracy suite judges rightly: bounds, locks, confidence and covariance, on observations made up for
// it; and its list of data sets is in order.
#include "tools/accuracy/case.hpp"
#include "tools/accuracy/claims.hpp"
#include "tools/accuracy/confidence_fit.hpp"
#include "tools/accuracy/consistency.hpp"
#include "tools/accuracy/reliability.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "tools/render/random.hpp"
#include "tools/render/scene.hpp"

namespace vergence::accuracy {
namespace {

Observation looked(std::size_t case_index, int frame, TrackState state, const Vector3& error_mm, double e,
                   int tracked_for = 5) {
  Observation seen;
  seen.case_index = case_index;
  seen.tracked_for = tracked_for;
  seen.result.frame = frame;
  seen.result.estimate.state = state;
  seen.result.error = tools::PoseError{error_mm, e, Vector3{e, 0, 0}};
  return seen;
}

Observation nothing_there(std::size_t case_index, TrackState state) {
  Observation seen;
  seen.case_index = case_index;
  seen.result.estimate.state = state;
  return seen;
}

Case follow(const char* group, const char* name) {
  Case result;
  result.group = group;
  result.set.name = name;
  return result;
}

const ErrorBounds kBounds{{1, 1, 2}, 0.01, 3};

TEST(ErrorReport, IsMetOnlyWhereEveryDataSetMeetsIt) {
  const std::vector<Case> cases{follow("g", "good"), follow("g", "bad"), follow("other", "worse")};
  std::vector<Observation> seen{looked(0, 1, TrackState::kTracking, {0.5, 0.5, 1}, 0.005),
                                looked(2, 1, TrackState::kTracking, {9, 9, 9}, 0.5)};
  ErrorReport report = error_report("c", cases, seen, {"g"}, Part::kLocked, kBounds);
  EXPECT_EQ(report.claim.met, false) << "a data set without a single tracked frame meets nothing";
  // Nearly all frames are good, and all of them together within the bounds; but one data set is not.
  for (int i = 0; i < 99; ++i) seen.push_back(looked(0, 2 + i, TrackState::kTracking, {0, 0, 0}, 0));
  seen.push_back(looked(1, 1, TrackState::kTracking, {1.5, 0, 0}, 0));
  report = error_report("c", cases, seen, {"g"}, Part::kLocked, kBounds);
  ASSERT_EQ(report.rows.size(), 2U);
  EXPECT_TRUE(report.met[0]);
  EXPECT_FALSE(report.met[1]);
  EXPECT_LT(report.all.rms_mm[0], 1);
  EXPECT_EQ(report.claim.met, false);
  seen.back() = looked(1, 1, TrackState::kTracking, {0.9, 0, 0}, 0);
  report = error_report("c", cases, seen, {"g"}, Part::kLocked, kBounds);
  EXPECT_EQ(report.claim.met, true) << report.claim.measured;
}

TEST(ErrorReport, OneFrameFarOffBreaksTheClaim) {
  const std::vector<Case> cases{follow("g", "a")};
  std::vector<Observation> seen(1000, looked(0, 1, TrackState::kTracking, {0, 0, 0}, 0));
  EXPECT_EQ(error_report("c", cases, seen, {"g"}, Part::kLocked, kBounds).claim.met, true);
  seen[500] = looked(0, 1, TrackState::kTracking, {0, 0, 3.5}, 0);
  EXPECT_EQ(error_report("c", cases, seen, {"g"}, Part::kLocked, kBounds).claim.met, false);
}

TEST(ErrorRow, CountsTheFramesOfItsPartOnly) {
  Observation first = looked(0, 0, TrackState::kTracking, {4, 0, 0}, 0.1, 0);
  Observation lost = looked(0, 1, TrackState::kLost, {4, 0, 0}, 0.1, 0);
  Observation learned = looked(0, 40, TrackState::kTracking, {1, 0, 0}, 0.001, kLearned_frames);
  learned.result.stage = Stage::kRelief;
  const std::vector<const Observation*> seen{&first, &lost, &learned};
  EXPECT_EQ(error_row("", seen, Part::kLocked).frames, 1U);
  EXPECT_EQ(error_row("", seen, Part::kEarly).frames, 1U);
  EXPECT_DOUBLE_EQ(error_row("", seen, Part::kEarly).rms_mm[0], 4);
  EXPECT_DOUBLE_EQ(error_row("", seen, Part::kRelief).rms_mm[0], 1);
  EXPECT_EQ(error_row("", seen, Part::kLocked).seen, 3U);
  EXPECT_EQ(error_row("", seen, Part::kLocked).tracked, 2U);
}

TEST(ColdClaims, TellFirstFrameFromThirdAndRightFromWrong) {
  std::vector<Case> cases{follow("g", "a")};
  cases[0].task = Task::kCold;
  std::vector<Observation> seen(99, looked(0, 0, TrackState::kTracking, {1, 1, 1}, 0.01));
  seen.push_back(looked(0, 99, TrackState::kTracking, {100, 0, 0}, 0.01));  // not it
  Observation again = looked(0, 99, TrackState::kTracking, {1, 1, 1}, 0.01);
  again.attempt = 1;
  seen.push_back(again);
  const auto claims = cold_claims("c", cases, seen, "g");
  ASSERT_EQ(claims.size(), 2U);
  EXPECT_EQ(claims[0].met, true);
  EXPECT_NE(claims[0].measured.find("99.0 % of 100; 1 frames"), std::string::npos) << claims[0].measured;
  EXPECT_EQ(claims[1].met, true);
  seen.pop_back();
  EXPECT_EQ(cold_claims("c", cases, seen, "g")[1].met, false);
  const auto rows = cold_rows(cases, seen);
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(rows[0].looks, 100U);
  EXPECT_EQ(rows[0].soon, 99U);
  EXPECT_EQ(rows[0].false_locks, 1U);
}

TEST(RelockClaim, NeedsALockWithinThreeFramesOfEachEvent) {
  std::vector<Case> cases{follow("g", "a")};
  cases[0].task = Task::kRelock;
  cases[0].events = {10, 20};
  std::vector<Observation> seen{looked(0, 12, TrackState::kTracking, {1, 1, 1}, 0.01),
                                looked(0, 23, TrackState::kTracking, {1, 1, 1}, 0.01)};
  EXPECT_EQ(relock_claim("c", cases, seen, "g").met, false) << "23 is the fourth frame";
  seen[1].result.frame = 22;
  EXPECT_EQ(relock_claim("c", cases, seen, "g").met, true);
}

TEST(AbsentClaims, SearchingIsNotLostYetAndTrackingIsFalse) {
  std::vector<Case> cases{follow("g", "a")};
  cases[0].task = Task::kAbsent;
  std::vector<Observation> seen(1000, nothing_there(0, TrackState::kLost));
  seen.push_back(nothing_there(0, TrackState::kSearching));
  EXPECT_EQ(absent_claims("c", cases, seen, "g")[0].met, true);
  EXPECT_EQ(absent_claims("c", cases, seen, "g")[1].met, true);
  seen.push_back(nothing_there(0, TrackState::kTracking));
  EXPECT_EQ(absent_claims("c", cases, seen, "g")[0].met, true);
  EXPECT_EQ(absent_claims("c", cases, seen, "g")[1].met, false);
}

TEST(ReliabilityTest, AHonestForecasterHasNoErrorAndABoasterHasOne) {
  std::vector<Observation> seen;
  for (int i = 0; i < 1000; ++i) {
    // Right in three quarters of the frames, and says so.
    seen.push_back(looked(0, i, TrackState::kTracking, {i % 4 == 0 ? 50.0 : 0.0, 0, 0}, 0));
    seen.back().result.estimate.confidence = 0.75;
  }
  const auto is_right = [](const Observation& o) { return o.right(); };
  EXPECT_NEAR(reliability(seen, is_right).expected_error, 0, 1e-9);
  EXPECT_NEAR(reliability(seen, is_right).squared_error, 0.75 * 0.25, 1e-9);
  for (Observation& o : seen) o.result.estimate.confidence = 1;
  const Reliability boast = reliability(seen, is_right);
  EXPECT_NEAR(boast.expected_error, 0.25, 1e-9);
  EXPECT_EQ(boast.bin[kReliabilityBins - 1].frames, 1000U) << "a confidence of 1 belongs into the last bin";
}

TEST(ConsistencyTest, IsOneWhereErrorsAreAsLargeAsStated) {
  constexpr double kSigma[6] = {0.3, 0.2, 1.5, 0.004, 0.003, 0.002};
  std::vector<Observation> seen;
  for (int i = 0; i < 4000; ++i) {
    const auto draw = [&](int axis) {
      return kSigma[axis] * render::normal(render::hash(7, static_cast<std::uint64_t>(6 * i + axis)));
    };
    Observation o = looked(0, i, TrackState::kTracking, {draw(0), draw(1), draw(2)}, 0.001);
    o.result.error->e_difference = {draw(3), draw(4), draw(5)};
    for (int axis = 0; axis < 6; ++axis) {
      o.result.estimate.covariance(axis, axis) = kSigma[axis] * kSigma[axis] * (axis == 2 ? 0.25 : 1);
    }
    seen.push_back(o);
  }
  seen.push_back(looked(0, 0, TrackState::kTracking, {9, 0, 0}, 0));  // without a covariance: does not count
  std::vector<const Observation*> all;
  for (const Observation& o : seen) all.push_back(&o);
  const Consistency c = consistency(all);
  EXPECT_EQ(c.frames, 4000U);
  for (const unsigned axis : {0U, 1U, 3U, 4U, 5U}) {
    EXPECT_NEAR(c.ratio[axis], 1, 0.1) << axis;
    EXPECT_NEAR(c.within_two[axis], 0.954, 0.02) << axis;
  }
  EXPECT_NEAR(c.ratio[2], 4, 0.4) << "stated at half of what it is";
  EXPECT_NEAR(c.share_within_two(), (5 * 0.954 + 0.683) / 6, 0.02);
}

TEST(Cases, HaveNamesOfTheirOwnAndScenesThatExist) {
  for (const bool quick : {true, false}) {
    const SuiteSize size{quick};
    std::map<std::string, std::string> patch_of;
    std::vector<RenderedSet> sets = generation_sets(size);
    for (const TimedSet& timed : timed_sets(size)) sets.push_back(timed.set);
    for (const auto& cases : {marker_cases(size), photo_cases(size), lock_cases(size), absent_cases(size)}) {
      for (const Case& what : cases) {
        sets.push_back(what.set);
        EXPECT_EQ(what.task == Task::kRelock, !what.events.empty()) << what.set.name;
        for (const int event : what.events) EXPECT_LE(event + 3, what.set.frames) << what.set.name;
      }
    }
    for (const RenderedSet& set : sets) {
      EXPECT_GT(set.frames, 0) << set.name;
      EXPECT_TRUE(std::filesystem::exists(std::filesystem::path(VERGENCE_SCENES) / (set.scene + ".toml")))
          << set.name;
      const auto [entry, is_new] = patch_of.emplace(set.name, set.scene + "\n" + set.patch);
      EXPECT_EQ(entry->second, set.scene + "\n" + set.patch) << set.name << " stands for two";
    }
    for (const Case& what : absent_cases(size)) {
      if (what.model_of.empty()) continue;
      EXPECT_EQ(patch_of.count(what.model_of), 1U) << what.model_of;
    }
  }
}

TEST(Cases, MarkerScenesCanBeReadWithTheirChanges) {
  // The last change made to each scene: reading one takes a while.
  const SuiteSize size{true};
  std::map<std::string, std::string> patch_of;
  for (const auto& cases : {marker_cases(size), lock_cases(size), absent_cases(size)}) {
    for (const Case& what : cases) {
      if (what.set.scene.rfind("marker", 0) == 0) patch_of[what.set.scene] = what.set.patch;
    }
  }
  for (const auto& [scene, patch] : patch_of) {
    render::SceneOverrides overrides;
    overrides.patch = patch;
    EXPECT_NO_THROW({
      (void)render::load_scene(std::filesystem::path(VERGENCE_SCENES) / (scene + ".toml"), overrides);
    }) << scene;
  }
}

// Outcomes drawn by known weights give those weights back, and one that says nothing is left at nothing.
TEST(ConfidenceFit, FindsTheWeightsThatMadeTheOutcomes) {
  const PhotoFeatures truth{-1, 2, 0, -3, 0, 1, 0, 0};
  std::vector<JudgedPose> poses;
  for (std::uint64_t i = 0; i < 20000; ++i) {
    JudgedPose pose;
    double sum = 0;
    for (std::size_t k = 0; k < kPhotoFeatures; ++k) {
      pose.feature[k] = k == 0 ? 1 : 2 * render::uniform(i, k) - 1;
      sum += truth[k] * pose.feature[k];
    }
    pose.right = render::uniform(i, kPhotoFeatures) < 1 / (1 + std::exp(-sum));
    poses.push_back(pose);
  }
  const PhotoFeatures found = fit_confidence(poses, 0.1);
  for (std::size_t k = 0; k < kPhotoFeatures; ++k) EXPECT_NEAR(found[k], truth[k], 0.12) << k;
  // Right ones that count twice are likelier everywhere, by a factor of two.
  for (JudgedPose& pose : poses) pose.counts = pose.right ? 2 : 1;
  EXPECT_NEAR(fit_confidence(poses, 0.1)[0], truth[0] + std::log(2.0), 0.12);
}

TEST(ConfidenceFit, StaysFiniteWhereRightAndWrongNeverMeet) {
  std::vector<JudgedPose> poses;
  for (int i = -10; i <= 10; ++i) {
    if (i != 0) poses.push_back({{1, i / 10.0, 0, 0, 0, 0, 0, 0}, i > 0});
  }
  const PhotoFeatures found = fit_confidence(poses, 0.1);
  EXPECT_GT(found[1], 1);
  EXPECT_LT(found[1], 100);
}

}  // namespace
}  // namespace vergence::accuracy
