// Heartbeats [CiA 301, 7.2.8.2.2]: the master watches each drive and shows the drives that it lives itself.
#pragma once

#include <cstdint>

#include "hal/canopen/can_bus.hpp"
#include "hal/canopen/nmt.hpp"

namespace vergence::canopen {

enum class NodeLife : std::uint8_t {
  kAwaited,      // has not booted yet, and may still
  kNeverBooted,  // its time to boot is over; a heartbeat timeout alone would wait for ever
  kBooted,       // has booted, and has had no heartbeat to send so far
  kAlive,
  kLost,  // its heartbeat has stopped
};

class HeartbeatConsumer {
 public:
  void init(std::uint8_t node_id, std::int64_t timeout_ns, std::int64_t boot_timeout_ns);

  // From now on a boot is awaited; a heartbeat from before it does not count.
  void await_boot(std::int64_t now_ns);
  // Frames of other nodes are ignored.
  void receive(const CanFrame& frame, std::int64_t now_ns);
  // Once lost, a node stays so until its next boot is awaited.
  void process(std::int64_t now_ns);

  [[nodiscard]] NodeLife life() const { return life_; }
  [[nodiscard]] NmtState state() const { return state_; }
  // Boots since one was awaited: the second one is a node that has restarted by itself.
  [[nodiscard]] std::uint32_t boots() const { return boots_; }

 private:
  std::uint8_t node_id_ = 0;
  std::int64_t timeout_ns_ = 0;
  std::int64_t boot_timeout_ns_ = 0;
  std::int64_t since_ns_ = 0;
  NodeLife life_ = NodeLife::kAwaited;
  NmtState state_ = NmtState::kUnknown;
  std::uint32_t boots_ = 0;
};

class HeartbeatProducer {
 public:
  // Period 0: none is sent.
  void init(std::uint8_t node_id, std::int64_t period_ns);
  // Sends one where it is due; what was refused is sent next time.
  void process(std::int64_t now_ns, NmtState state, const FrameSink& sink);

 private:
  std::uint8_t node_id_ = 0;
  std::int64_t period_ns_ = 0;
  std::int64_t last_ns_ = 0;
  bool sent_ = false;
};

}  // namespace vergence::canopen
