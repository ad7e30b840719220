// A CAN bus as the protocols see it: frames go out, frames come in, and how well it is. Chosen at compile
// time: a socket, or a bus in memory.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>

#include "hal/canopen/can_frame.hpp"

namespace vergence::canopen {

enum class BusState : std::uint8_t {
  kActive,
  kWarning,
  kPassive,
  kOff,   // the controller has left the bus
  kDown,  // the interface is down or gone
};

// Counted since the bus was opened.
struct CanHealth {
  BusState state = BusState::kActive;
  std::uint32_t rx_overflows = 0;  // frames lost because nobody took them in time
  std::uint32_t tx_refused = 0;    // frames not taken because the queue was full (ENOBUFS)
  std::uint32_t tx_failed = 0;     // frames not taken for another reason
  std::uint32_t error_frames = 0;
  std::uint32_t bus_offs = 0;
  std::uint32_t restarts = 0;  // asked for after a bus-off
  CanErrors last_errors;
};

// Counts an error frame. Back from bus-off it counts as active until the next error frame says otherwise.
inline void count_errors(CanHealth& health, const CanErrors& errors) {
  ++health.error_frames;
  health.last_errors = errors;
  if (errors.rx_overflow) ++health.rx_overflows;
  if (errors.bus_off) {
    if (health.state != BusState::kOff) ++health.bus_offs;
    health.state = BusState::kOff;
    return;
  }
  if (errors.restarted) health.state = BusState::kActive;
  if (health.state == BusState::kOff) return;
  if (errors.passive) {
    health.state = BusState::kPassive;
  } else if (errors.warning) {
    health.state = BusState::kWarning;
  } else if (errors.active) {
    health.state = BusState::kActive;
  }
}

// None of these waits. send() is false where the frame was not taken: nothing is queued behind the caller's
// back, who tries again next period with what is true by then. process() is called once a period, before
// the frames of the period are received. receive() is false where nothing was left when the bus was last
// asked; the call after that asks again. It does not give error frames: they are in the health.
template <typename T>
concept CanBus = requires(T& bus, const CanFrame& out, CanFrame& in, std::int64_t now_ns) {
  { bus.process(now_ns) } -> std::same_as<void>;
  { bus.send(out) } -> std::same_as<bool>;
  { bus.receive(in) } -> std::same_as<bool>;
  { bus.health() } -> std::convertible_to<const CanHealth&>;
};

// A bus that takes several frames in one call: how many, from the first; after one that was not taken none is
// tried.
template <typename T>
concept CanBusOfMany = CanBus<T> && requires(T& bus, std::span<const CanFrame> out) {
  { bus.send(out) } -> std::same_as<std::size_t>;
};

// Whoever takes frames, without its type, so that protocols need no templates. Refers to the bus.
class FrameSink {
 public:
  template <CanBus Bus>
  explicit FrameSink(Bus& bus)
      : bus_(&bus),
        send_([](void* to, const CanFrame& frame) { return static_cast<Bus*>(to)->send(frame); }),
        send_many_([](void* to, std::span<const CanFrame> frames) {
          Bus& its = *static_cast<Bus*>(to);
          if constexpr (CanBusOfMany<Bus>) {
            return its.send(frames);
          } else {
            std::size_t taken = 0;
            while (taken < frames.size() && its.send(frames[taken])) ++taken;
            return taken;
          }
        }) {}

  [[nodiscard]] bool send(const CanFrame& frame) const { return send_(bus_, frame); }
  // How many were taken, from the first; after one that was not none is tried.
  [[nodiscard]] std::size_t send(std::span<const CanFrame> frames) const { return send_many_(bus_, frames); }

 private:
  void* bus_;
  bool (*send_)(void*, const CanFrame&);
  std::size_t (*send_many_)(void*, std::span<const CanFrame>);
};

}  // namespace vergence::canopen
