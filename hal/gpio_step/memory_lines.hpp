// Lines in memory, for tests and simulation: record which line changed when. In one thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "hal/gpio_step/step_lines.hpp"
#include "hal/sim/sim_devices.hpp"

namespace vergence::step {

inline constexpr int kEnableLine = kOutputLines;  // after the bits of the outputs

struct LineEdge {
  std::int64_t t_ns = 0;
  int line = 0;  // bit of the outputs, or kEnableLine
  bool level = false;
  bool operator==(const LineEdge&) const = default;
};

class MemoryLines {
 public:
  // Edges go to `record`; those it has no room for are only counted.
  MemoryLines(std::span<LineEdge> record, sim::SimClock& clock) : record_(record), clock_(&clock) {}

  [[nodiscard]] bool set_outputs(std::uint32_t levels);
  [[nodiscard]] bool set_enable(bool on);
  [[nodiscard]] bool read_inputs(std::uint32_t& levels);

  // The world's side.
  void press(std::uint32_t inputs) { inputs_ = inputs; }
  // A call of set_outputs() takes so long: the lines change after the first part. The clock moves on by it.
  void set_duration_ns(std::int64_t before_ns, std::int64_t after_ns) {
    before_ns_ = before_ns;
    after_ns_ = after_ns;
  }
  void break_outputs(bool broken) { outputs_broken_ = broken; }
  void break_enable(bool broken) { enable_broken_ = broken; }
  void break_inputs(bool broken) { inputs_broken_ = broken; }
  [[nodiscard]] std::span<const LineEdge> edges() const { return record_.first(recorded_); }
  void forget_edges() { recorded_ = 0; }
  [[nodiscard]] std::size_t lost_edges() const { return lost_; }
  [[nodiscard]] std::uint32_t outputs() const { return outputs_; }
  [[nodiscard]] bool is_enabled() const { return enabled_; }
  [[nodiscard]] std::uint64_t set_calls() const { return set_calls_; }

 private:
  void add(int line, bool level);

  std::span<LineEdge> record_;
  sim::SimClock* clock_;
  std::size_t recorded_ = 0;
  std::size_t lost_ = 0;
  std::uint64_t set_calls_ = 0;
  std::uint32_t outputs_ = 0;
  std::uint32_t inputs_ = 0;
  std::int64_t before_ns_ = 0;
  std::int64_t after_ns_ = 0;
  bool enabled_ = false;
  bool outputs_broken_ = false;
  bool enable_broken_ = false;
  bool inputs_broken_ = false;
};

static_assert(StepLines<MemoryLines>);

}  // namespace vergence::step
