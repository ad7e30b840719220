// The controller's pipeline and the simulated world, in lock-step virtual time: the same seed gives the same
// bits, however fast the machine.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "firmware_like/pipeline.hpp"
#include "tools/demo/loop_log.hpp"
#include "tools/demo/scenario.hpp"
#include "tools/io/dataset.hpp"
#include "tools/plant/world.hpp"

namespace vergence::demo {

struct LoopSetup {
  std::string name;   // of the scene, for complaints
  std::string scene;  // TOML, see docs/render.md; its world is S, the hand's frame at the start
  std::string patch;
  double duration_s = 10;
  // Where the target is comes from the truth, frame by frame, as late as vision would say it.
  bool pose_given = false;
  bool has_arm = true;
  bool servo = true;  // the hand is to follow; otherwise it rests
  Transform T_W_S;    // where the hand starts
  std::function<void(RobotConfig&)> adjust_robot;
  std::function<void(plant::WorldOptions&)> adjust_world;
};

// Where the hand starts in chapter 4 [4.1].
[[nodiscard]] Transform lateral_start();

class ClosedLoop {
 public:
  // Throws std::runtime_error where the controller refuses the configuration or the arm cannot be there.
  ClosedLoop(const LoopSetup& setup, const RunOptions& options);
  ~ClosedLoop();

  // On to the end, from wherever it is.
  void run(const std::function<void(double)>& progress = {});
  void run_until(double t_s);

  [[nodiscard]] double now_s() const;
  [[nodiscard]] plant::World& world() { return *world_; }
  [[nodiscard]] Pipeline& pipeline() { return *pipeline_; }
  [[nodiscard]] const RobotConfig& robot() const { return robot_; }
  [[nodiscard]] const tools::LogTable& log() const { return log_.table(); }
  [[nodiscard]] tools::LogTable take_log() { return log_.take(); }

  // Called each millisecond, after the controller.
  std::function<void(double t_s)> on_tick;

  // Both eyes' last pictures with the model drawn in; throws std::logic_error where there are none.
  [[nodiscard]] tools::Picture draw_last_frame(const std::filesystem::path& png, const std::string& caption);

 private:
  struct Camera;

  void build_models(const RunOptions& options, const render::Scene& scene);
  void tick();
  void keep_pace();
  void operate();
  void give_pose();
  void look();
  [[nodiscard]] Transform true_T_H_M(std::int64_t stamp_ns) const;

  LoopSetup setup_;
  RobotConfig robot_;
  tools::Target target_;
  std::unique_ptr<MarkerModel> marker_;
  std::unique_ptr<PhotoModel> photo_;
  std::unique_ptr<Pipeline> pipeline_;
  std::unique_ptr<Camera> camera_;
  sim::SimArm arm_;
  sim::SimPanTilt eyes_;
  std::unique_ptr<plant::World> world_;
  LoopLog log_;
  std::int64_t t_ns_ = 0;
  bool wall_clock_ = false;
  std::optional<std::chrono::steady_clock::time_point> began_;
  std::vector<Transform> hand_was_;  // each millisecond, in a ring
  std::optional<SeenFrame> fresh_;   // since the last row
  std::optional<SeenFrame> last_seen_;
};

}  // namespace vergence::demo
