#include "hal/canopen/memory_bus.hpp"

#include <algorithm>

namespace vergence::canopen {

MemoryBus::MemoryBus() {
  for (Port& port : ports_) port.bus_ = this;
}

std::size_t MemoryBus::Port::send(std::span<const CanFrame> frames) {
  const bool is_off = health_.state == BusState::kOff;
  const std::size_t taken = is_off ? 0 : std::min(frames.size(), room_);
  for (const CanFrame& frame : frames.first(taken)) bus_->spread(*this, frame);
  if (room_ != kEndless) room_ -= taken;
  (is_off ? health_.tx_failed : health_.tx_refused) += static_cast<std::uint32_t>(frames.size() - taken);
  return taken;
}

bool MemoryBus::Port::receive(CanFrame& frame) {
  // A frame that is late lets none of its followers pass, as in a queue.
  if (count_ == 0 || queue_[first_].stamp_ns > bus_->now_ns_) return false;
  frame = queue_[first_];
  first_ = (first_ + 1) % kQueue;
  --count_;
  return true;
}

void MemoryBus::Port::set_off(bool is_off) {
  CanErrors errors;
  errors.bus_off = is_off;
  errors.restarted = !is_off;
  count_errors(health_, errors);
  count_ = 0;
}

void MemoryBus::Port::deliver(const CanFrame& frame) {
  if (health_.state == BusState::kOff) return;
  if (count_ >= limit_) {
    ++health_.rx_overflows;
    return;
  }
  queue_[(first_ + count_) % kQueue] = frame;
  ++count_;
}

void MemoryBus::spread(const Port& from, const CanFrame& frame) {
  CanFrame arriving = frame;
  arriving.stamp_ns = now_ns_;
  for (Fault& fault : faults_) {
    if (fault.count == 0 || (frame.id & fault.which.mask) != (fault.which.id & fault.which.mask)) continue;
    --fault.count;
    if (fault.delay_ns == 0) return;
    arriving.stamp_ns += fault.delay_ns;
  }
  for (Port& port : ports_) {
    if (&port != &from) port.deliver(arriving);
  }
}

bool MemoryBus::drop(const CanFilter& which, std::uint32_t count) {
  return add({which, count, 0});
}

bool MemoryBus::delay(const CanFilter& which, std::int64_t delay_ns, std::uint32_t count) {
  return add({which, count, delay_ns});
}

bool MemoryBus::add(const Fault& fault) {
  for (Fault& slot : faults_) {
    if (slot.count != 0) continue;
    slot = fault;
    return true;
  }
  return false;
}

void MemoryBus::clear_faults() {
  faults_ = {};
}

}  // namespace vergence::canopen
