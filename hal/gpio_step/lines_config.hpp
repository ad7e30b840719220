// Which lines of which GPIO chips the motors have, and what may be wrong with them.
#pragma once

#include <array>
#include <cstdint>

#include "hal/gpio_step/step_lines.hpp"

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

// Of what the system just refused, by errno: the kind is what it is called where errno says nothing better.
[[nodiscard]] LinesError lines_error_of_errno(LinesErrorKind kind, const GpioName& what);

[[nodiscard]] inline bool is_named(const GpioName& name) {
  return name.front() != '\0' && name.back() == '\0';
}

}  // namespace vergence::step
