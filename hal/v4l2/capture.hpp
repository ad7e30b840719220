// One camera that keeps running: set up, watched, restarted. It never waits; time comes in.
#pragma once

#include <cstdint>

#include "hal/stereo_camera.hpp"
#include "hal/v4l2/buffer_ring.hpp"
#include "hal/v4l2/controls.hpp"

namespace vergence::v4l2 {

enum class CaptureState : std::uint8_t {
  kStopped,
  kRestarting,  // no stream; another attempt is due
  kSettling,    // streams, and the automatics find their values; no frame is given out
  kStreaming,
  kFault,  // given up until start()
};

// Since configure().
struct CaptureCounts {
  std::uint64_t frames = 0;      // given out
  std::uint64_t flagged = 0;     // left out: the driver marked them as damaged
  std::uint64_t incomplete = 0;  // left out: fewer bytes than a picture has
  std::uint64_t bad_stamps = 0;  // left out: stamps of the future, or far in the past
  std::uint64_t settling = 0;    // left out while the automatics found their values
  std::uint64_t gaps = 0;        // in the driver's sequence numbers
  std::uint64_t lost = 0;        // frames that fell into them
  std::uint64_t stream_errors = 0;
  std::uint64_t unplugged = 0;
  std::uint64_t stalls = 0;
  std::uint64_t restarts = 0;  // troubles that led to another attempt
  std::uint64_t openings = 0;  // of the device, successful ones
  std::uint64_t recoveries = 0;
};

struct CapturedFrame {
  int buffer = -1;
  std::uint64_t number = 0;   // rises by one with each frame of the driver, lost ones too, over restarts
  std::int64_t stamp_ns = 0;  // middle of the exposure
  ImageView image;
};

class Capture {
 public:
  [[nodiscard]] VideoError configure(VideoSystem& system, const VideoConfig& config);

  // From kStopped or kFault; the first attempt is due at once.
  void start(std::int64_t now_ns);
  // Lets go of everything; nobody looks at a picture any more.
  void stop();

  // The next good frame, oldest first, to be given back; false where none is ready.
  [[nodiscard]] bool next(std::int64_t now_ns, CapturedFrame& frame);
  void give_back(std::int64_t now_ns, int buffer);

  // What is due: stalls, values to lock, restarts. `happened` is what poll() said, after next() was called.
  void tend(std::int64_t now_ns, short happened);
  [[nodiscard]] std::int64_t deadline_ns() const;  // when tend() has something to do without a frame

  [[nodiscard]] int handle_to_poll() const { return is_running() ? handle_ : -1; }
  [[nodiscard]] bool is_running() const;
  // A new start waits for the buffers that are still held.
  [[nodiscard]] bool wants_buffers_back() const;

  [[nodiscard]] CaptureState state() const { return state_; }
  [[nodiscard]] CameraState camera_state() const;
  [[nodiscard]] const VideoError& error() const { return error_; }  // the last one, also when it is over
  [[nodiscard]] const CaptureCounts& counts() const { return counts_; }
  [[nodiscard]] const StreamFormat& format() const { return format_; }
  [[nodiscard]] const Controls& controls() const { return controls_; }
  [[nodiscard]] const BufferRing& ring() const { return ring_; }

 private:
  [[nodiscard]] VideoError open(std::int64_t now_ns);
  [[nodiscard]] VideoError begin(std::int64_t now_ns);
  void close();
  void attempt(std::int64_t now_ns);
  void trouble(std::int64_t now_ns, const VideoError& error);
  void give_up(const VideoError& error);
  void failed_call(std::int64_t now_ns, VideoFault otherwise, int error_number);
  void count_sequence(std::uint32_t sequence);
  [[nodiscard]] bool is_good(std::int64_t now_ns, const DequeuedBuffer& buffer);
  void note_good(std::int64_t now_ns);
  [[nodiscard]] std::int64_t patience_ns() const;

  VideoSystem* system_ = nullptr;
  VideoConfig config_;
  CaptureState state_ = CaptureState::kStopped;
  int handle_ = -1;
  StreamFormat format_;
  Controls controls_;
  BufferRing ring_;
  VideoError error_;
  CaptureCounts counts_;

  bool in_trouble_ = false;
  std::int64_t trouble_since_ns_ = 0;
  int attempts_ = 0;
  bool keeps_device_ = false;  // the next attempt starts the stream anew, not the device
  std::int64_t due_ns_ = 0;

  std::int64_t settled_ns_ = 0;
  std::int64_t last_good_ns_ = 0;
  int good_frames_ = 0;  // since the stream began
  bool has_sequence_ = false;
  std::uint32_t sequence_ = 0;
  std::uint64_t number_ = 0;
  bool heard_frame_ = false;  // since the last tend()
};

}  // namespace vergence::v4l2
