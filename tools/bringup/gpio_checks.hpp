// Are the lines of the eyes' motors there, free, and do they move what they should?
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hal/gpio_step/lines_config.hpp"
#include "hal/gpio_step/motor_set.hpp"
#include "tools/bringup/finding.hpp"
#include "tools/bringup/gpio_view.hpp"

namespace vergence::tools {

struct WantedLine {
  std::string role;  // "tilt step"
  std::string chip;  // label
  std::string name;
  bool is_output = false;
};
// Outputs, the enable line, and the switches that have a name, in this order.
[[nodiscard]] std::vector<WantedLine> wanted_lines(const step::LinesConfig& config);

struct GpioObservation {
  std::string problem;  // with the chips as a whole
  std::vector<GpioChip> chips;
  std::array<std::optional<bool>, step::kInputLines> levels{};  // of the switches, by their bits
};
[[nodiscard]] std::vector<Finding> judge(const GpioObservation& seen, const step::LinesConfig& config);

// Reads what judge() wants. Takes only switches that are free inputs already, for the moment of reading.
[[nodiscard]] GpioObservation look_at_lines(GpioView& view, const step::LinesConfig& config);

// A motor that was moved there and back.
struct PulseObservation {
  std::string problem;  // empty: it ran
  std::int64_t farthest_steps = 0;
  std::int64_t final_steps = 0;         // 0 where it came back
  std::uint64_t late_events = 0;        // later than the configured jitter
  std::vector<std::int64_t> issued_ns;  // pulses
  std::vector<std::int64_t> looped_ns;  // rising edges that came back on the loop-back line
};
// `has_loopback`: a line is watched, which one motor's step line is wired to.
[[nodiscard]] std::vector<Finding> judge(const std::array<PulseObservation, kPanTiltMotors>& seen,
                                         bool has_loopback, std::int64_t wanted_steps);
// Why nothing was moved.
[[nodiscard]] std::vector<Finding> not_moved(const std::string& why);

}  // namespace vergence::tools
