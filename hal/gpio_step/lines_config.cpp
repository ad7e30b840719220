#include "hal/gpio_step/lines_config.hpp"

#include <cerrno>

namespace vergence::step {

const char* describe(LinesErrorKind kind) {
  switch (kind) {
    case LinesErrorKind::kNone: return "no error";
    case LinesErrorKind::kNotNamed:
      return "a chip, or a step, direction or enable line, has no name in the configuration";
    case LinesErrorKind::kNamedTwice: return "this line has two purposes in the configuration";
    case LinesErrorKind::kChipNotFound:
      return "no GPIO chip has this label or name: see both with gpiodetect";
    case LinesErrorKind::kChipUnclear:
      return "several GPIO chips have this label: give the chip's name (gpiochip2) instead, see gpiodetect";
    case LinesErrorKind::kLineNotFound:
      return "the chip has no line of this name: see the names with gpioinfo";
    case LinesErrorKind::kLineBusy: return "somebody else uses this line: see who with gpioinfo";
    case LinesErrorKind::kNoPermission:
      return "no permission for the GPIO chip: join the group of /dev/gpiochip*";
    case LinesErrorKind::kRequestFailed: return "the kernel refused the lines";
  }
  return "unknown error";
}

LinesError lines_error_of_errno(LinesErrorKind kind, const GpioName& what) {
  const int os_error = errno;
  if (os_error == EACCES || os_error == EPERM) kind = LinesErrorKind::kNoPermission;
  if (kind == LinesErrorKind::kRequestFailed && os_error == EBUSY) kind = LinesErrorKind::kLineBusy;
  return {kind, what, os_error};
}

}  // namespace vergence::step
