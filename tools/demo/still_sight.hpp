// One scene, looked at with a hand that stands still: for maps of the fitness, and for searches from nothing.
#pragma once

#include <memory>
#include <string>

#include "algo/tracker.hpp"
#include "tools/demo/scenario.hpp"
#include "tools/draw/heat_map.hpp"
#include "tools/io/dataset.hpp"
#include "tools/render/scene.hpp"

namespace vergence::demo {

class StillSight {
 public:
  // The model goes to a folder of its own under options.out, by that name.
  StillSight(const std::string& name, const std::string& scene, const RunOptions& options);

  // Frame by frame, at the scene's rate; evolved and refined where `track`, otherwise only taken in.
  Estimate look(int frame, bool track);
  [[nodiscard]] Pose truth(int frame) const;
  [[nodiscard]] double fitness(const Pose& pose) const { return tracker_->fitness_at(pose); }
  // Both pictures of the last frame, the pose drawn in.
  [[nodiscard]] tools::Picture draw(const std::filesystem::path& png, const Pose& pose,
                                    const std::string& caption) const;

 private:
  render::Scene scene_;
  tools::Target target_;
  std::unique_ptr<MarkerModel> marker_;
  std::unique_ptr<PhotoModel> photo_;
  std::unique_ptr<Tracker> tracker_;
  std::uint64_t seed_;
  FrameMotion motion_;
  tools::RgbImage left_;
  tools::RgbImage right_;
  int frame_ = 0;
};

// An axis of a map: 0 to 5 for x y z e1 e2 e3.
struct MapAxis {
  int component;
  tools::GridAxis grid;
};

struct FitnessMap {
  tools::HeatMap figure;
  Pose peak;
  double peak_fitness = 0;
};

// Fitness over two components about a pose, in the mark "truth" where that pose is.
[[nodiscard]] FitnessMap map_fitness(const StillSight& sight, const Pose& about, const MapAxis& x,
                                     const MapAxis& y, const std::string& title);

}  // namespace vergence::demo
