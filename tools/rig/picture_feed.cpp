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

void PictureFeed::show(int side, const render::SceneState& state, std::uint64_t seed) {
  const auto eye = static_cast<std::size_t>(side);
  {
    const std::lock_guard lock(mutex_);
    ++counts_[eye].asked;
    if (busy_[eye] || jobs_[eye]) {
      ++counts_[eye].skipped;
      return;
    }
    jobs_[eye] = Job{state, seed};
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

PictureCounts PictureFeed::counts(int side) {
  const std::lock_guard lock(mutex_);
  return counts_[static_cast<std::size_t>(side)];
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

void PictureFeed::make(std::size_t side, const Job& job, std::size_t late) {
  tools::RgbImage image;
  render::render_eye(scene_, job.state, side == 0 ? render::Eye::kLeft : render::Eye::kRight, job.seed,
                     image);
  auto& shown = shown_[side];
  if (shown.size() > kMostLate) shown.erase(shown.begin());
  shown.emplace_back();
  to_yuyv(image, shown.back());
  const std::size_t back = std::min(late, shown.size() - 1);
  if (!cameras_[side]->show(shown[shown.size() - 1 - back])) {
    const std::lock_guard lock(mutex_);
    ++counts_[side].refused;
  }
}

void PictureFeed::work() {
  std::unique_lock lock(mutex_);
  while (true) {
    wake_.wait(lock, [this] { return ends_ || jobs_[0] || jobs_[1] || !acts_.empty(); });
    if (ends_) return;
    const std::vector<Act> acts = std::exchange(acts_, {});
    const std::array<std::optional<Job>, 2> jobs = std::exchange(jobs_, {});
    const std::array<std::size_t, 2> late = late_;
    busy_ = {jobs[0].has_value(), jobs[1].has_value()};
    lock.unlock();
    try {
      for (const Act& act : acts) obey(act);
      for (std::size_t side = 0; side < 2; ++side) {
        if (jobs[side]) make(side, *jobs[side], late[side]);
      }
    } catch (const std::exception& error) {
      const std::lock_guard again(mutex_);
      trouble_ = error.what();
    }
    lock.lock();
    busy_ = {};
  }
}

}  // namespace vergence::rig
