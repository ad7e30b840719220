// Makes pictures of the world as one eye sees it and shows them to its camera, in a thread of its own: in
// real time a picture takes longer than the drives may wait for an answer, and the other eye's is made beside
// it.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
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

struct PictureCounts {
  std::uint64_t asked = 0;
  std::uint64_t skipped = 0;  // the one before was still being made
  std::uint64_t refused = 0;  // the camera was unplugged
};

class PictureFeed {
 public:
  PictureFeed(const render::Scene& scene, render::Eye eye, Vivid& camera);
  ~PictureFeed();
  PictureFeed(const PictureFeed&) = delete;
  PictureFeed& operator=(const PictureFeed&) = delete;

  // Neither waits.
  void show(const render::SceneState& state, std::uint64_t seed);
  void act(CameraAction action);
  // The picture of so many pictures before; at most kMostLate.
  void set_late(std::size_t pictures);

  [[nodiscard]] PictureCounts counts();
  // What went wrong in the thread, where something did.
  [[nodiscard]] std::optional<std::string> trouble();

  static constexpr std::size_t kMostLate = 30;

 private:
  struct Job {
    render::SceneState state;
    std::uint64_t seed = 0;
  };
  void work();
  void obey(CameraAction action);
  void make(const Job& job, std::size_t late);

  const render::Scene& scene_;
  render::Eye eye_;
  Vivid& camera_;
  std::vector<std::vector<std::uint8_t>> shown_;  // the last ones, oldest first

  std::mutex mutex_;
  std::condition_variable wake_;
  std::optional<Job> job_;
  std::vector<CameraAction> acts_;
  std::size_t late_ = 0;
  bool busy_ = false;
  bool ends_ = false;
  PictureCounts counts_;
  std::optional<std::string> trouble_;
  std::thread thread_;
};

}  // namespace vergence::rig
