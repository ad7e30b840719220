// Step, direction, enable and switch lines through libgpiod, found by their chip and their name. Where the
// lines are set, nothing is allocated; open() may.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "hal/gpio_step/line_group.hpp"
#include "hal/gpio_step/lines_config.hpp"
#include "hal/gpio_step/step_lines.hpp"

namespace vergence::step {

class LibgpiodLines {
 public:
  LibgpiodLines() = default;
  ~LibgpiodLines() { close(); }
  LibgpiodLines(const LibgpiodLines&) = delete;
  LibgpiodLines& operator=(const LibgpiodLines&) = delete;

  // Requests all lines: drives disabled, step lines at rest, directions positive.
  [[nodiscard]] LinesError open(const LinesConfig& config);
  // Drops the enable line, ends pulses that have begun, and gives all lines back. After the tasks have ended.
  void close();

  [[nodiscard]] bool set_outputs(std::uint32_t levels);
  [[nodiscard]] bool set_enable(bool on);
  [[nodiscard]] bool read_inputs(std::uint32_t& levels);

 private:
  [[nodiscard]] LinesError request_all(const LinesConfig& config);
  [[nodiscard]] LinesError request_outputs(const LinesConfig& config);
  [[nodiscard]] LinesError request_inputs(const LinesConfig& config);

  LineGroup outputs_;
  LineGroup enable_;
  LineGroup inputs_;                                   // those that are there,
  std::array<std::size_t, kInputLines> input_bits_{};  // and the bit of each
  std::size_t inputs_count_ = 0;
  std::uint32_t inverted_outputs_ = 0;
  std::uint32_t inverted_inputs_ = 0;
  bool inverted_enable_ = false;
};

static_assert(StepLines<LibgpiodLines>);

}  // namespace vergence::step
