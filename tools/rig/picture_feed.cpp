#include "tools/rig/picture_feed.hpp"

#include <algorithm>
#include <exception>
#include <utility>

#include "tools/rig/yuyv.hpp"

namespace vergence::rig {

PictureFeed::PictureFeed(const render::Scene& scene, render::Eye eye, Vivid& camera)
    : scene_(scene), eye_(eye), camera_(camera), thread_([this] { work(); }) {}

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

void PictureFeed::act(CameraAction action) {
  {
    const std::lock_guard lock(mutex_);
    acts_.push_back(action);
  }
  wake_.notify_one();
}

void PictureFeed::set_late(std::size_t pictures) {
  const std::lock_guard lock(mutex_);
  late_ = std::min(pictures, kMostLate);
}

PictureCounts PictureFeed::counts() {
  const std::lock_guard lock(mutex_);
  return counts_;
}

std::optional<std::string> PictureFeed::trouble() {
  const std::lock_guard lock(mutex_);
  return trouble_;
}

void PictureFeed::obey(CameraAction action) {
  if (action == CameraAction::kPlugIn) return camera_.plug_in();
  if (camera_.is_unplugged()) return;
  switch (action) {
    case CameraAction::kUnplug: return camera_.unplug();
    case CameraAction::kPlugIn: return;
    case CameraAction::kDropAll: return camera_.set_dropped_percent(100);
    case CameraAction::kDropNone: return camera_.set_dropped_percent(0);
    case CameraAction::kFlagNext: return camera_.flag_next_frame();
  }
}

void PictureFeed::make(const Job& job, std::size_t late) {
  tools::RgbImage image;
  render::render_eye(scene_, job.state, eye_, job.seed, image);
  if (shown_.size() > kMostLate) shown_.erase(shown_.begin());
  shown_.emplace_back();
  to_yuyv(image, shown_.back());
  const std::size_t back = std::min(late, shown_.size() - 1);
  if (!camera_.show(shown_[shown_.size() - 1 - back])) {
    const std::lock_guard lock(mutex_);
    ++counts_.refused;
  }
}

void PictureFeed::work() {
  std::unique_lock lock(mutex_);
  while (true) {
    wake_.wait(lock, [this] { return ends_ || job_ || !acts_.empty(); });
    if (ends_) return;
    const std::vector<CameraAction> acts = std::exchange(acts_, {});
    const std::optional<Job> job = std::exchange(job_, {});
    const std::size_t late = late_;
    busy_ = job.has_value();
    lock.unlock();
    try {
      for (const CameraAction action : acts) obey(action);
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
