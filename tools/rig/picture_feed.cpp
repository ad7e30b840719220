#include "tools/rig/picture_feed.hpp"

#include <algorithm>
#include <exception>
#include <utility>

#include "tools/rig/yuyv.hpp"

namespace vergence::rig {

PictureFeed::PictureFeed(const render::Scene& scene, std::array<Vivid*, 2> cameras)
    : scene_(scene), cameras_(cameras), thread_([this] { work(); }) {}

PictureFeed::~PictureFeed() {
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

void PictureFeed::show(const render::SceneState& state, std::uint64_t seed) {
  {
    const std::lock_guard lock(mutex_);
    ++counts_.asked;
    if (busy_ || job_) {
      ++counts_.skipped;
      return;
    }
    job_ = Job{state, seed};
  }
  wake_.notify_one();
}

void PictureFeed::act(int side, CameraAction action) {
  {
    const std::lock_guard lock(mutex_);
    acts_.push_back({side, action});
  }
  wake_.notify_one();
}

void PictureFeed::set_late(int side, std::size_t pictures) {
  const std::lock_guard lock(mutex_);
  late_[static_cast<std::size_t>(side)] = std::min(pictures, kMostLate);
}

PictureCounts PictureFeed::counts() {
  const std::lock_guard lock(mutex_);
  return counts_;
}

std::optional<std::string> PictureFeed::trouble() {
  const std::lock_guard lock(mutex_);
  return trouble_;
}

void PictureFeed::obey(const Act& act) {
  Vivid& camera = *cameras_[static_cast<std::size_t>(act.side)];
  if (act.action == CameraAction::kPlugIn) return camera.plug_in();
  if (camera.is_unplugged()) return;
  switch (act.action) {
    case CameraAction::kUnplug: return camera.unplug();
    case CameraAction::kPlugIn: return;
    case CameraAction::kDropAll: return camera.set_dropped_percent(100);
    case CameraAction::kDropNone: return camera.set_dropped_percent(0);
    case CameraAction::kFlagNext: return camera.flag_next_frame();
  }
}

void PictureFeed::make(const Job& job, const std::array<std::size_t, 2>& late) {
  std::array<tools::RgbImage, 2> images;
  render::render_pair(scene_, job.state, job.seed, images[0], images[1]);
  for (std::size_t side = 0; side < 2; ++side) {
    auto& shown = shown_[side];
    if (shown.size() > kMostLate) shown.erase(shown.begin());
    shown.emplace_back();
    to_yuyv(images[side], shown.back());
    const std::size_t back = std::min(late[side], shown.size() - 1);
    if (!cameras_[side]->show(shown[shown.size() - 1 - back])) {
      const std::lock_guard lock(mutex_);
      ++counts_.refused[side];
    }
  }
}

void PictureFeed::work() {
  std::unique_lock lock(mutex_);
  while (true) {
    wake_.wait(lock, [this] { return ends_ || job_ || !acts_.empty(); });
    if (ends_) return;
    busy_ = true;
    const std::vector<Act> acts = std::exchange(acts_, {});
    const std::optional<Job> job = std::exchange(job_, std::nullopt);
    const std::array<std::size_t, 2> late = late_;
    lock.unlock();
    try {
      for (const Act& act : acts) obey(act);
      if (job) make(*job, late);
    } catch (const std::exception& error) {
      const std::lock_guard again(mutex_);
      trouble_ = error.what();
    }
    lock.lock();
    busy_ = false;
  }
}

}  // namespace vergence::rig
