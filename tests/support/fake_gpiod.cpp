#include "tests/support/fake_gpiod.hpp"

#include <stdexcept>

namespace vergence::testing {

FakeGpio& fake_gpio() {
  static FakeGpio gpio;
  return gpio;
}

FakeGpioLine& FakeGpio::line(const std::string& name) {
  for (FakeGpioChip& chip : chips) {
    for (FakeGpioLine& line : chip.lines) {
      if (line.name == name) return line;
    }
  }
  throw std::out_of_range(name);
}

}  // namespace vergence::testing
