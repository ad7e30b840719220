#include "tools/demo/still_sight.hpp"

#include <stdexcept>

#include "tools/draw/overlay.hpp"
#include "tools/io/writable.hpp"
#include "tools/render/dataset_writer.hpp"
#include "tools/render/random.hpp"

namespace vergence::demo {
namespace {

render::Scene load(const std::string& name, const std::string& scene, const RunOptions& options) {
  render::SceneOverrides overrides;
  overrides.seed = options.seed;
  return render::load_scene_text(name, scene, overrides);
}

double& component(Pose& pose, int i) {
  return i < 3 ? pose.position_mm[i] : pose.e[i - 3];
}

}  // namespace

StillSight::StillSight(const std::string& name, const std::string& scene, const RunOptions& options)
    : scene_(load(name, scene, options)),
      marker_(std::make_unique<MarkerModel>()),
      photo_(std::make_unique<PhotoModel>()),
      tracker_(std::make_unique<Tracker>()),
      seed_(options.seed) {
  const std::filesystem::path directory = options.out / name;
  tools::make_directory(directory);
  render::write_model(scene_, directory);
  tools::Dataset dataset;
  dataset.directory = directory;
  dataset.rig = scene_.rig;
  dataset.box = scene_.search;
  dataset.target = tools::read_target(directory);
  target_ = dataset.target;
  TrackerSettings settings = default_settings(Method::kVergence, target_.kind);
  settings.seed = options.seed;
  settings.box = scene_.search;
  Status status = Status::kOk;
  if (target_.kind == TargetKind::kMarker) {
    tools::build_model(dataset, MarkerOptions{}, *marker_);
    status = tracker_->configure(scene_.rig, *marker_, settings);
  } else {
    tools::build_model(dataset, PhotoOptions{}, settings.hue_limits, *photo_);
    status = tracker_->configure(scene_.rig, *photo_, settings);
  }
  if (status != Status::kOk) throw std::runtime_error(describe(status));
}

Pose StillSight::truth(int frame) const {
  return scene_.target_motion.at(frame / scene_.fps);
}

Estimate StillSight::look(int frame, bool track) {
  frame_ = frame;
  const render::SceneState state = render::state_at(scene_, frame / scene_.fps);
  render::render_pair(scene_, state, render::hash(seed_, static_cast<std::uint64_t>(frame)), left_, right_);
  const EyeAngles& eyes = state.moments.back().eyes;
  motion_.t_s = frame / scene_.fps;
  motion_.T_H_CL = left_eye_in_hand(scene_.rig.left.T_H_C, eyes);
  motion_.T_H_CR = right_eye_in_hand(scene_.rig.right.T_H_C, eyes);
  const Status status =
      tracker_->begin_frame(static_cast<std::uint64_t>(frame), left_.view(), right_.view(), motion_);
  if (status != Status::kOk) throw std::runtime_error(describe(status));
  if (!track) return {};
  for (int g = 0; g < tracker_->usual_generations(); ++g) {
    tracker_->evolve(static_cast<double>(g) / tracker_->usual_generations());
  }
  return tracker_->end_frame();
}

tools::Picture StillSight::draw(const std::filesystem::path& png, const Pose& pose,
                                const std::string& caption) const {
  tools::Overlay overlay{target_,
                         target_.kind == TargetKind::kPhoto ? &tracker_->photo_model() : nullptr,
                         {scene_.rig.left, scene_.rig.right},
                         pose,
                         truth(frame_),
                         caption};
  overlay.cameras[0].T_H_C = motion_.T_H_CL;
  overlay.cameras[1].T_H_C = motion_.T_H_CR;
  tools::write_png(png, tools::draw_overlay(overlay, left_, right_));
  return {png, caption};
}

FitnessMap map_fitness(const StillSight& sight, const Pose& about, const MapAxis& x, const MapAxis& y,
                       const std::string& title) {
  FitnessMap map{{title, x.grid, y.grid, "fitness", {}, {}}, about, -1e9};
  Pose pose = about;
  for (int iy = 0; iy < y.grid.count; ++iy) {
    component(pose, y.component) = y.grid.value(iy);
    for (int ix = 0; ix < x.grid.count; ++ix) {
      component(pose, x.component) = x.grid.value(ix);
      const double fitness = sight.fitness(pose);
      map.figure.values.push_back(fitness);
      if (fitness > map.peak_fitness) {
        map.peak_fitness = fitness;
        map.peak = pose;
      }
    }
  }
  Pose truth = about;
  map.figure.marks.push_back({component(truth, x.component), component(truth, y.component), "truth", 6});
  map.figure.marks.push_back({component(map.peak, x.component), component(map.peak, y.component), "peak", 2});
  return map;
}

}  // namespace vergence::demo
