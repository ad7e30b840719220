#include "hal/canopen/heartbeat.hpp"

namespace vergence::canopen {

void HeartbeatConsumer::init(std::uint8_t node_id, std::int64_t timeout_ns, std::int64_t boot_timeout_ns) {
  *this = {};
  node_id_ = node_id;
  timeout_ns_ = timeout_ns;
  boot_timeout_ns_ = boot_timeout_ns;
}

void HeartbeatConsumer::await_boot(std::int64_t now_ns) {
  life_ = NodeLife::kAwaited;
  state_ = NmtState::kUnknown;
  since_ns_ = now_ns;
  boots_ = 0;
}

void HeartbeatConsumer::receive(const CanFrame& frame, std::int64_t now_ns) {
  if (frame.id != kHeartbeatCobId + node_id_ || frame.size != 1 || frame.is_remote || frame.is_error) return;
  const NmtState state = decode_nmt_state(frame.data[0]);
  if (state == NmtState::kBootUp) {
    ++boots_;
    if (life_ == NodeLife::kAwaited) life_ = NodeLife::kBooted;
  }
  if (life_ == NodeLife::kAwaited || life_ == NodeLife::kNeverBooted || life_ == NodeLife::kLost) return;
  state_ = state;
  since_ns_ = now_ns;
  if (state != NmtState::kBootUp) life_ = NodeLife::kAlive;
}

void HeartbeatConsumer::process(std::int64_t now_ns) {
  const std::int64_t age_ns = now_ns - since_ns_;
  if (life_ == NodeLife::kAwaited && age_ns > boot_timeout_ns_) life_ = NodeLife::kNeverBooted;
  if (life_ == NodeLife::kAlive && age_ns > timeout_ns_) life_ = NodeLife::kLost;
}

void HeartbeatProducer::init(std::uint8_t node_id, std::int64_t period_ns) {
  *this = {};
  node_id_ = node_id;
  period_ns_ = period_ns;
}

void HeartbeatProducer::process(std::int64_t now_ns, NmtState state, const FrameSink& sink) {
  if (period_ns_ == 0 || (sent_ && now_ns - last_ns_ < period_ns_)) return;
  if (!sink.send(heartbeat_frame(node_id_, state))) return;
  sent_ = true;
  last_ns_ = now_ns;
}

}  // namespace vergence::canopen
