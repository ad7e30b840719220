// Step, direction, enable and switch lines through libgpiod, found by their chip and their name. Where the
// lines are set, nothing is allocated; open() may.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "hal/gpio_step/step_lines.hpp"

struct gpiod_chip;
struct gpiod_line;

namespace vergence::step {

using GpioName = std::array<char, 32>;  // as long as the kernel's, with the zero it ends with

struct LineSpec {
  GpioName name{};        // empty: there is no such line; outputs all must be there
  bool inverted = false;  // low is 1
};

// Chips by their labels, which survive a restart; or, where several have the same, by their names
// (gpiochip2). Step and direction lines share a chip, so that one call sets them all; so do the switches.
struct LinesConfig {
  GpioName outputs_chip{};
  std::array<LineSpec, kOutputLines> outputs{};  // by their bits, see step_lines.hpp
  GpioName enable_chip{};
  LineSpec enable{};
  GpioName inputs_chip{};
  std::array<LineSpec, kInputLines> inputs{};
};

enum class LinesErrorKind : std::uint8_t {
  kNone,
  kNotNamed,      // a line that is needed has no name
  kNamedTwice,    // one line for two purposes
  kChipNotFound,  // no chip has this label or name
  kChipUnclear,   // several chips have this label
  kLineNotFound,  // the chip has no line of this name
  kLineBusy,      // somebody else has it
  kNoPermission,
  kRequestFailed,  // for another reason: os_error
};

struct LinesError {
  LinesErrorKind kind = LinesErrorKind::kNone;
  GpioName what{};   // label or line
  int os_error = 0;  // errno
};

// What to do about it, for people.
[[nodiscard]] const char* describe(LinesErrorKind kind);

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

  gpiod_chip* outputs_chip_ = nullptr;
  gpiod_chip* enable_chip_ = nullptr;
  gpiod_chip* inputs_chip_ = nullptr;
  std::array<gpiod_line*, kOutputLines> outputs_{};
  bool are_outputs_ours_ = false;
  gpiod_line* enable_ = nullptr;
  // Those that are there, and the bit of each.
  std::array<gpiod_line*, kInputLines> inputs_{};
  std::array<int, kInputLines> input_bits_{};
  std::size_t inputs_count_ = 0;
  std::uint32_t inverted_outputs_ = 0;
  std::uint32_t inverted_inputs_ = 0;
  bool inverted_enable_ = false;
};

static_assert(StepLines<LibgpiodLines>);

}  // namespace vergence::step
