// A CAN bus on which nothing can be moved: only requests to read an object [CiA 301, 7.2.4] get through.
// Whatever else is sent is refused and counted, so that no mistake elsewhere enables a drive.
#pragma once

#include <cstdint>

#include "hal/canopen/can_bus.hpp"
#include "hal/canopen/nmt.hpp"
#include "hal/clock.hpp"
#include "hal/rt/sleep.hpp"

namespace vergence::tools {

// Upload requests, their segments, and the abort of a transfer.
[[nodiscard]] inline bool only_reads(const canopen::CanFrame& frame) {
  const bool is_request =
      frame.id > canopen::kSdoRequestCobId && frame.id <= canopen::kSdoRequestCobId + canopen::kMaxNodeId;
  const int command = frame.data[0] >> 5;
  return is_request && frame.size == 8 && !frame.is_remote && !frame.is_error &&
         (command == 2 || command == 3 || command == 4);
}

class ReadOnlyBus {
 public:
  void process(std::int64_t now_ns) { process_bus(now_ns); }
  [[nodiscard]] bool send(const canopen::CanFrame& frame) {
    if (!only_reads(frame)) {
      ++refused_;
      return false;
    }
    return send_bus(frame);
  }
  [[nodiscard]] virtual bool receive(canopen::CanFrame& frame) = 0;
  [[nodiscard]] virtual const canopen::CanHealth& health() const = 0;

  [[nodiscard]] virtual std::int64_t now_ns() = 0;
  virtual void sleep_until(std::int64_t ns) = 0;

  [[nodiscard]] std::uint64_t refused() const { return refused_; }

 protected:
  ~ReadOnlyBus() = default;

 private:
  virtual void process_bus(std::int64_t now_ns) = 0;
  [[nodiscard]] virtual bool send_bus(const canopen::CanFrame& frame) = 0;

  std::uint64_t refused_ = 0;
};

static_assert(canopen::CanBus<ReadOnlyBus>);

// Of any bus, with the time it lives in. All must outlive it.
template <canopen::CanBus Bus, Clock C, rt::Sleeper S>
class ReadOnly final : public ReadOnlyBus {
 public:
  ReadOnly(Bus& bus, C& clock, S& sleeper) : bus_(&bus), clock_(&clock), sleeper_(&sleeper) {}

  bool receive(canopen::CanFrame& frame) override { return bus_->receive(frame); }
  [[nodiscard]] const canopen::CanHealth& health() const override { return bus_->health(); }
  std::int64_t now_ns() override { return clock_->now_ns(); }
  void sleep_until(std::int64_t ns) override { sleeper_->sleep_until(ns); }

 private:
  void process_bus(std::int64_t now_ns) override { bus_->process(now_ns); }
  bool send_bus(const canopen::CanFrame& frame) override { return bus_->send(frame); }

  Bus* bus_;
  C* clock_;
  S* sleeper_;
};

}  // namespace vergence::tools
