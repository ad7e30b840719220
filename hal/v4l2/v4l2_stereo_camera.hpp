// Two V4L2 cameras as one StereoCamera. One thread captures, another takes; they share pictures where the
// driver put them, without copies or locks.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "hal/clock.hpp"
#include "hal/stereo_camera.hpp"
#include "hal/v4l2/capture.hpp"
#include "hal/v4l2/exchange.hpp"
#include "hal/v4l2/stereo_pairing.hpp"

namespace vergence::v4l2 {

struct StereoVideoReport {
  std::array<CaptureCounts, 2> eyes{};  // left, right
  std::array<VideoError, 2> errors{};   // the last of each
  std::array<StreamFormat, 2> formats{};
  PairingCounts pairing;
  std::uint64_t pairs_passed_over = 0;  // a newer one came before they were taken
  std::int64_t longest_wait_ns = 0;     // asked of poll()
};

class V4l2StereoCamera {
 public:
  V4l2StereoCamera() = default;
  ~V4l2StereoCamera() { stop(); }
  V4l2StereoCamera(const V4l2StereoCamera&) = delete;
  V4l2StereoCamera& operator=(const V4l2StereoCamera&) = delete;

  // Before the threads begin. `side` of the camera that is meant: 0 left, 1 right.
  [[nodiscard]] VideoError configure(VideoSystem& system, const StereoVideoConfig& config, int& side);

  // The capturing thread's side.
  void start(std::int64_t now_ns);
  // Nobody looks at a frame any more.
  void stop();
  // Waits for a frame or for the next deadline, at most kMaxWait_ns, and does what is due.
  template <Clock C>
  void run_once(C& clock) {
    wait(clock.now_ns());
    serve(clock.now_ns());
  }
  void wait(std::int64_t now_ns);
  void serve(std::int64_t now_ns);
  [[nodiscard]] const Capture& capture(int side) const { return captures_[static_cast<std::size_t>(side)]; }

  // The taking thread's side: a StereoCamera. While a camera is opened anew its pictures must go, so take()
  // then answers false once and ends the frame it gave before.
  [[nodiscard]] bool take(StereoFrame& frame);

  // Any thread.
  [[nodiscard]] CameraState state() const { return state_.load(std::memory_order_acquire); }

  // One thread, of any: true where there is a newer report than the last.
  [[nodiscard]] bool report(StereoVideoReport& report);

 private:
  struct Pair {
    StereoFrame frame;
    std::array<int, 2> buffers{-1, -1};
  };
  void collect(std::int64_t now_ns, int side);
  void give_back(std::int64_t now_ns, const DroppedFrames& dropped);
  void give_back(std::int64_t now_ns, const Pair& pair);
  void offer_newest(std::int64_t now_ns);
  void recall(std::int64_t now_ns);
  void publish();

  VideoSystem* system_ = nullptr;
  std::array<Capture, 2> captures_{};
  std::array<std::array<CapturedFrame, kMaxVideoBuffers>, 2> frames_{};  // by side and buffer
  std::array<short, 2> happened_{};
  StereoPairing pairing_;
  std::array<std::uint64_t, 2> last_numbers_{};
  std::uint64_t sequence_ = 0;
  bool is_recalling_ = false;
  StereoVideoReport report_;

  Exchange<Pair> pairs_;
  Exchange<StereoVideoReport> reports_;
  std::atomic<CameraState> state_{CameraState::kRestarting};
};

static_assert(StereoCamera<V4l2StereoCamera>);

}  // namespace vergence::v4l2
