// The simulated robot behind the kernel's devices, and the course of a run: each millisecond the world moves;
// frames, edges and faults are taken when they come. It sleeps until one of them does, so that virtual time
// can go on.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "firmware_like/config/controller_config.hpp"
#include "tools/demo/pen.hpp"
#include "tools/report/log_table.hpp"
#include "tools/rig/controller_process.hpp"
#include "tools/rig/controller_view.hpp"
#include "tools/rig/drive_bank.hpp"
#include "tools/rig/picture_feed.hpp"
#include "tools/rig/picture_schedule.hpp"
#include "tools/rig/rig_log.hpp"
#include "tools/rig/rig_scenario.hpp"
#include "tools/rig/rig_world.hpp"
#include "tools/rig/trace_reader.hpp"
#include "tools/rig/vivid.hpp"

namespace vergence::rig {

// How old pictures were at their stamps. Where the camera's rhythm changes, one is shown twice, and older.
class PictureAges {
 public:
  void add(std::int64_t age_ns) { ages_ns_.push_back(age_ns); }

  struct Spread {
    std::int64_t least_ns = 0;
    std::int64_t median_ns = 0;
    std::int64_t most_ns = 0;
  };
  // Empty where there were none.
  [[nodiscard]] std::optional<Spread> spread() const;

 private:
  std::vector<std::int64_t> ages_ns_;
};

enum class Pace {
  kVirtual,  // the clock waits for whoever computes
  kReal,
};

class PlantLoop {
 public:
  // Throws RigError where a device is missing, InputError where the scene is wrong, std::runtime_error where
  // the arm cannot be at the start. The robot is the one the controller's configuration describes.
  PlantLoop(const RigScenario& scenario, const ControllerConfig& config, ControllerProcess& controller);

  // From now on for the scenario's duration. Throws RigError where a device fails by itself.
  void run(Pace pace);

  [[nodiscard]] const tools::LogTable& log() const { return log_; }
  [[nodiscard]] const Judge& judge() const { return judge_; }
  [[nodiscard]] const demo::Pen& pen() const { return pen_; }
  [[nodiscard]] PictureCounts pictures(int side) { return feeds_[static_cast<std::size_t>(side)].counts(); }
  [[nodiscard]] const PictureAges& ages() const { return ages_; }
  [[nodiscard]] const DriveBank& drives() const { return drives_; }
  [[nodiscard]] const EyeMotors& eyes() const { return eyes_; }
  [[nodiscard]] std::int64_t start_ns() const { return start_ns_; }
  [[nodiscard]] std::int64_t most_ticks_late() const { return most_ticks_late_; }

 private:
  enum class Phase {
    kWaiting,
    kActive,
    kOver,
  };

  void tick(std::int64_t tick);
  void keep_faults(double t_s);
  [[nodiscard]] bool is_pen_let_go(double t_s);
  void begin(const FaultEvent& fault);
  void hold(const FaultEvent& fault, std::int64_t tick);
  void end(const FaultEvent& fault);
  void take_trace();
  void keep_out_of_step(std::size_t captured_side);
  PictureFeed& feed_of(const FaultEvent& fault) { return feeds_[static_cast<std::size_t>(fault.side)]; }
  void show_pictures(const std::array<bool, 2>& due, std::int64_t now_ns, double t_s, const Transform& T_W_H);

  RigScenario scenario_;
  const ControllerConfig& config_;
  ControllerProcess& controller_;
  RigWorld world_;         // which takes a while to make
  std::int64_t start_ns_;  // on a whole second
  DriveBank drives_;
  EyeMotors eyes_;
  TraceReader trace_;
  std::array<Vivid, 2> cameras_;
  std::array<PictureFeed, 2> feeds_;
  ControllerView view_;
  demo::Pen pen_;
  struct Aim {
    double t_s = 0;
    Transform T_W_H;
    Transform T_W_M;
  };
  std::deque<Aim> aims_;  // of the last rows, as the controller has it; oldest first
  Judge judge_;
  tools::LogTable log_;

  std::vector<Phase> phases_;
  std::array<PictureSchedule, 2> schedules_;
  std::array<int, 2> minors_;
  std::array<std::int64_t, 2> shown_ns_{};
  PictureAges ages_;  // of both eyes
  bool out_of_step_ = false;
  std::int64_t tick_ = 0;
  std::uint64_t pictures_ = 0;
  std::int64_t most_ticks_late_ = 0;
  Vector3 tool_W_mm_ = Vector3::Zero();
  double fastest_mm_per_s_ = 0;
};

}  // namespace vergence::rig
