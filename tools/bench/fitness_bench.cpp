#include "tools/bench/fitness_bench.hpp"

#include <memory>
#include <vector>

#include "algo/correlation.hpp"
#include "algo/fitness.hpp"
#include "algo/hue_plane.hpp"
#include "tests/differential/scalar_fitness.hpp"
#include "tools/bench/bench_scene.hpp"
#include "tools/bench/stopwatch.hpp"
#include "tools/run/estimator.hpp"

namespace vergence::tools {
namespace {

constexpr int kPoses = 64;

// Poses as evolution meets them: around the target, where most samples fall into the image.
std::vector<Transform> some_poses(const BenchScene& scene) {
  CounterRandom random(5, 0);
  SearchBox box;
  for (unsigned i = 0; i < 3; ++i) {
    box.centre[i] = scene.truth.position_mm[i];
    box.half_range[i] = 40;
  }
  for (unsigned i = 3; i < 6; ++i) box.half_range[i] = 0.2;
  std::vector<Transform> poses;
  for (int i = 0; i < kPoses; ++i) {
    poses.push_back(to_transform(decode(random_chromosome(random), box, GeneCoding::kGray)));
  }
  return poses;
}

volatile std::int64_t sink = 0;  // keeps results alive

struct Planes {
  HuePlane left;
  HuePlane right;
  YuvHueTable unused;
};

template <class Model, class Votes, class PlainVotes>
PairOfTimes measure(const BenchScene& scene, const Planes& planes, const Model& model, int turns,
                    Votes&& votes, PlainVotes&& plain) {
  std::vector<Transform> left;
  std::vector<Transform> right;
  for (const Transform& T : some_poses(scene)) {
    left.push_back(target_in_camera(scene.dataset.rig.left, T));
    right.push_back(target_in_camera(scene.dataset.rig.right, T));
  }
  const auto all = [&](auto&& evaluate) {
    std::int64_t sum = 0;
    for (std::size_t i = 0; i < left.size(); ++i) {
      sum += evaluate(model, scene.dataset.rig.left, planes.left, left[i]);
      sum += evaluate(model, scene.dataset.rig.right, planes.right, right[i]);
    }
    sink = sum;
  };
  return measure_in_turn(
      turns, [&] { all(votes); }, [&] { all(plain); });
}

int generations_in_24ms(const BenchScene& scene) {
  EstimateOptions options;
  options.method = Method::kThesis;  // evolution on votes, all points
  options.coding = GeneCoding::kGray;
  options.mutation_per_1024 = 102;
  options.budget_ms = 24;
  Estimator estimator(scene.dataset, options);
  std::vector<double> generations;
  for (int i = 0; i < 9; ++i) {
    generations.push_back(estimator.run({i, {}, {}}, scene.left, scene.right).estimate.generations);
  }
  return static_cast<int>(median(generations));
}

}  // namespace

FitnessBenchResult run_fitness_bench(int turns) {
  FitnessBenchResult result;
  const auto planes = std::make_unique<Planes>();
  const auto fill = [&](const BenchScene& scene, const HueLimits& limits) {
    (void)make_hue_plane(scene.left.view(), limits, planes->unused, planes->left);
    (void)make_hue_plane(scene.right.view(), limits, planes->unused, planes->right);
  };
  {
    const BenchScene scene = make_bench_scene(TargetKind::kMarker, BenchContent::kPresent);
    const auto model = std::make_unique<MarkerModel>();
    build_model(scene.dataset, {}, *model);
    fill(scene, {});
    const auto ours = [](auto&&... a) { return marker_votes(a...); };
    const auto plain = [](auto&&... a) { return reference::marker_votes(a...); };
    const PairOfTimes times = measure(scene, *planes, *model, turns, ours, plain);
    result.marker_ns_per_sample = times.ours_ns / (kPoses * 2.0 * model->samples_per_camera());
    result.marker_speedup_vs_scalar = 1 / times.ratio;
    result.generations_in_24ms_marker = generations_in_24ms(scene);
  }
  {
    const BenchScene scene = make_bench_scene(TargetKind::kPhoto, BenchContent::kPresent);
    const auto model = std::make_unique<PhotoModel>();
    build_model(scene.dataset, PhotoOptions{}, {}, *model);
    fill(scene, {});
    const auto ours = [](auto&&... a) { return photo_votes(a...); };
    const auto plain = [](auto&&... a) { return reference::photo_votes(a...); };
    const PairOfTimes times = measure(scene, *planes, *model, turns, ours, plain);
    result.photo_ns_per_sample = times.ours_ns / (kPoses * 2.0 * model->points());
    result.photo_speedup_vs_scalar = 1 / times.ratio;
    result.generations_in_24ms_photo = generations_in_24ms(scene);

    const auto pyramid = std::make_unique<ColourPyramid>();
    const auto correlated = std::make_unique<CorrelationModel>();
    (void)make_colour_pyramid(scene.left.view(), *pyramid);
    build_correlation_model(*model, 2, 160, HiddenPoints::kTakenAlong, *correlated);
    const CameraModel camera = camera_at_level(scene.dataset.rig.left, 2);
    const ColourLevel level = level_of(*pyramid, 2);
    const auto poses = some_poses(scene);
    std::vector<double> times_ns;
    for (int i = 0; i < turns; ++i) {
      const double start = now_ns();
      std::int64_t sum = 0;
      for (const Transform& T : poses)
        sum += correlation(*correlated, *model, camera, level, target_in_camera(camera, T));
      sink = sum;
      times_ns.push_back(now_ns() - start);
    }
    result.correlation_ns_per_sample = median(times_ns) / (kPoses * static_cast<double>(correlated->points));
  }
  return result;
}

}  // namespace vergence::tools
