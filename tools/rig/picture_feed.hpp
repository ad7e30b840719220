// Makes pictures of the world and shows them to both cameras, in a thread of its own: in real time a picture
// takes longer than the drives may wait for an answer.
#pragma once

#include <array>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "tools/render/scene.hpp"
#include "tools/rig/vivid.hpp"

namespace vergence::rig {

// What to do to a camera before the next picture.
enum class CameraAction {
  kUnplug,
  kPlugIn,
  kDropAll,
  kDropNone,
  kFlagNext,
};

struct PictureCounts {  // of an eye
  std::uint64_t asked = 0;
  std::uint64_t skipped = 0;  // the one before was still being made
  std::uint64_t refused = 0;  // the camera was unplugged
};

class PictureFeed {
 public:
  PictureFeed(const render::Scene& scene, std::array<Vivid*, 2> cameras);
  ~PictureFeed();
  PictureFeed(const PictureFeed&) = delete;
  PictureFeed& operator=(const PictureFeed&) = delete;

  // Neither waits.
  void show(int side, const render::SceneState& state, std::uint64_t seed);
  void act(int side, CameraAction action);
  // Of this eye, the picture of so many pictures before; at most kMostLate.
  void set_late(int side, std::size_t pictures);

  [[nodiscard]] PictureCounts counts(int side);
  // What went wrong in the thread, where something did.
  [[nodiscard]] std::optional<std::string> trouble();

  static constexpr std::size_t kMostLate = 30;

 private:
  struct Job {
    render::SceneState state;
    std::uint64_t seed = 0;
  };
  struct Act {
    int side = 0;
    CameraAction action = CameraAction::kFlagNext;
  };
  void work();
  void obey(const Act& act);
  void make(std::size_t side, const Job& job, std::size_t late);

  const render::Scene& scene_;
  std::array<Vivid*, 2> cameras_;
  std::array<std::vector<std::vector<std::uint8_t>>, 2> shown_{};  // the last ones of each eye, oldest first

  std::mutex mutex_;
  std::condition_variable wake_;
  std::array<std::optional<Job>, 2> jobs_{};
  std::vector<Act> acts_;
  std::array<std::size_t, 2> late_{};
  std::array<bool, 2> busy_{};
  bool ends_ = false;
  std::array<PictureCounts, 2> counts_{};
  std::optional<std::string> trouble_;
  std::thread thread_;
};

}  // namespace vergence::rig
