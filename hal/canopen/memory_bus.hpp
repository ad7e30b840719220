// A CAN bus in memory, for tests and simulation: what one port sends all others receive, in order. Faults can
// be put on it. Time is what process() of any port last said.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "hal/canopen/can_bus.hpp"

namespace vergence::canopen {

class MemoryBus {
 public:
  static constexpr std::size_t kPorts = 10;
  static constexpr std::size_t kQueue = 128;  // frames a port holds until they are taken
  static constexpr std::size_t kFaults = 8;

  // Satisfies CanBusOfMany. Belongs to its bus and moves no more than that one does.
  class Port {
   public:
    void process(std::int64_t now_ns) { bus_->advance(now_ns); }
    [[nodiscard]] bool send(const CanFrame& frame) { return send(std::span(&frame, 1)) == 1; }
    [[nodiscard]] std::size_t send(std::span<const CanFrame> frames);
    [[nodiscard]] bool receive(CanFrame& frame);
    [[nodiscard]] const CanHealth& health() const { return health_; }

    // Refuses to send, as a full queue does.
    void set_full(bool is_full) { room_ = is_full ? 0 : kEndless; }
    // Takes so many more, and is full then.
    void set_room(std::size_t frames) { room_ = frames; }
    // Neither sends nor receives; what would have arrived is lost.
    void set_off(bool is_off);
    // Smaller queues overflow sooner.
    void set_queue_limit(std::size_t frames) { limit_ = frames < kQueue ? frames : kQueue; }

   private:
    friend class MemoryBus;
    void deliver(const CanFrame& frame);

    static constexpr std::size_t kEndless = ~std::size_t{0};

    MemoryBus* bus_ = nullptr;
    CanHealth health_;
    std::array<CanFrame, kQueue> queue_{};
    std::size_t first_ = 0;
    std::size_t count_ = 0;
    std::size_t limit_ = kQueue;
    std::size_t room_ = kEndless;  // for frames to send
  };

  MemoryBus();
  MemoryBus(const MemoryBus&) = delete;
  MemoryBus& operator=(const MemoryBus&) = delete;

  [[nodiscard]] Port& port(std::size_t i) { return ports_[i]; }
  void advance(std::int64_t now_ns) { now_ns_ = now_ns; }

  // Of the frames with (id & mask) == id, the next `count` are lost, or can be received only so much later.
  // At most kFaults at a time; false where there is no room for another.
  bool drop(const CanFilter& which, std::uint32_t count = ~0U);
  bool delay(const CanFilter& which, std::int64_t delay_ns, std::uint32_t count = ~0U);
  void clear_faults();

 private:
  struct Fault {
    CanFilter which;
    std::uint32_t count = 0;    // left; 0: none
    std::int64_t delay_ns = 0;  // 0: lost
  };
  bool add(const Fault& fault);
  void spread(const Port& from, const CanFrame& frame);

  std::array<Port, kPorts> ports_;
  std::array<Fault, kFaults> faults_{};
  std::int64_t now_ns_ = 0;
};

static_assert(CanBusOfMany<MemoryBus::Port>);

}  // namespace vergence::canopen
