// For libgpiod 1.x, and the only file of the controller with calls of it: version 2 has another interface and
// gets a file of its own beside this one.
#include "hal/gpio_step/libgpiod_lines.hpp"

#include <gpiod.h>

#include <cerrno>

namespace vergence::step {
namespace {

constexpr const char* kConsumer = "vergence";
constexpr std::uint32_t kAllForward = forward_bit(0) | forward_bit(1) | forward_bit(2);

LinesError error_of(LinesErrorKind kind, const GpioName& what) {
  const int os_error = errno;
  if (os_error == EACCES || os_error == EPERM) kind = LinesErrorKind::kNoPermission;
  if (kind == LinesErrorKind::kRequestFailed && os_error == EBUSY) kind = LinesErrorKind::kLineBusy;
  return {kind, what, os_error};
}

LinesError open_chip(const GpioName& label, gpiod_chip*& chip) {
  errno = 0;
  chip = gpiod_chip_open_by_label(label.data());
  return chip == nullptr ? error_of(LinesErrorKind::kChipNotFound, label) : LinesError{};
}

LinesError find_line(gpiod_chip* chip, const GpioName& name, gpiod_line*& line) {
  if (name[0] == '\0') return {LinesErrorKind::kNotNamed, name, 0};
  errno = 0;
  line = gpiod_chip_find_line(chip, name.data());
  return line == nullptr ? error_of(LinesErrorKind::kLineNotFound, name) : LinesError{};
}

// A request of several lines that failed does not say which was to blame.
LinesError blame(LinesError error, gpiod_line* const* lines, const LineSpec* const* specs,
                 std::size_t count) {
  if (error.kind != LinesErrorKind::kLineBusy) return error;
  for (std::size_t i = 0; i < count; ++i) {
    if (gpiod_line_is_used(lines[i])) {
      error.what = specs[i]->name;
      break;
    }
  }
  return error;
}

}  // namespace

const char* describe(LinesErrorKind kind) {
  switch (kind) {
    case LinesErrorKind::kNone: return "no error";
    case LinesErrorKind::kNotNamed:
      return "a step, direction or enable line has no name in the configuration";
    case LinesErrorKind::kChipNotFound: return "no GPIO chip has this label: see the labels with gpiodetect";
    case LinesErrorKind::kLineNotFound:
      return "the chip has no line of this name: see the names with gpioinfo";
    case LinesErrorKind::kLineBusy: return "somebody else uses this line: see who with gpioinfo";
    case LinesErrorKind::kNoPermission:
      return "no permission for the GPIO chip: join the group of /dev/gpiochip*";
    case LinesErrorKind::kRequestFailed: return "the kernel refused the lines";
  }
  return "unknown error";
}

LinesError LibgpiodLines::request_outputs(const LinesConfig& config) {
  LinesError error = open_chip(config.outputs_chip, outputs_chip_);
  gpiod_line_bulk bulk;
  gpiod_line_bulk_init(&bulk);
  std::array<int, kOutputLines> values{};
  std::array<const LineSpec*, kOutputLines> specs{};
  for (std::size_t i = 0; i < outputs_.size() && error.kind == LinesErrorKind::kNone; ++i) {
    const std::uint32_t bit = 1U << i;
    specs[i] = &config.outputs[i];
    if (specs[i]->inverted) inverted_outputs_ |= bit;
    values[i] = ((kAllForward ^ inverted_outputs_) & bit) != 0 ? 1 : 0;
    error = find_line(outputs_chip_, specs[i]->name, outputs_[i]);
    gpiod_line_bulk_add(&bulk, outputs_[i]);
  }
  if (error.kind != LinesErrorKind::kNone) return error;
  if (gpiod_line_request_bulk_output(&bulk, kConsumer, values.data()) == 0) return {};
  return blame(error_of(LinesErrorKind::kRequestFailed, config.outputs_chip), outputs_.data(), specs.data(),
               outputs_.size());
}

LinesError LibgpiodLines::request_inputs(const LinesConfig& config) {
  gpiod_line_bulk bulk;
  gpiod_line_bulk_init(&bulk);
  std::array<const LineSpec*, kInputLines> specs{};
  for (std::size_t i = 0; i < config.inputs.size(); ++i) {
    const LineSpec& spec = config.inputs[i];
    if (spec.name[0] == '\0') continue;
    LinesError error;
    if (inputs_chip_ == nullptr) error = open_chip(config.inputs_chip, inputs_chip_);
    gpiod_line* line = nullptr;
    if (error.kind == LinesErrorKind::kNone) error = find_line(inputs_chip_, spec.name, line);
    if (error.kind != LinesErrorKind::kNone) return error;
    gpiod_line_bulk_add(&bulk, line);
    if (spec.inverted) inverted_inputs_ |= 1U << i;
    specs[inputs_count_] = &spec;
    inputs_[inputs_count_] = line;
    input_bits_[inputs_count_++] = static_cast<int>(i);
  }
  if (inputs_count_ == 0 || gpiod_line_request_bulk_input(&bulk, kConsumer) == 0) return {};
  return blame(error_of(LinesErrorKind::kRequestFailed, config.inputs_chip), inputs_.data(), specs.data(),
               inputs_count_);
}

LinesError LibgpiodLines::request_all(const LinesConfig& config) {
  // The enable line first: nothing moves while the others are taken.
  LinesError error = open_chip(config.enable_chip, enable_chip_);
  gpiod_line* enable = nullptr;
  if (error.kind == LinesErrorKind::kNone) error = find_line(enable_chip_, config.enable.name, enable);
  if (error.kind != LinesErrorKind::kNone) return error;
  if (gpiod_line_request_output(enable, kConsumer, config.enable.inverted ? 1 : 0) != 0) {
    return error_of(LinesErrorKind::kRequestFailed, config.enable.name);
  }
  enable_ = enable;
  inverted_enable_ = config.enable.inverted;
  error = request_outputs(config);
  return error.kind == LinesErrorKind::kNone ? request_inputs(config) : error;
}

LinesError LibgpiodLines::open(const LinesConfig& config) {
  close();
  const LinesError error = request_all(config);
  if (error.kind != LinesErrorKind::kNone) close();
  return error;
}

void LibgpiodLines::close() {
  if (enable_ != nullptr) (void)set_enable(false);
  // Closing a chip releases its lines.
  for (gpiod_chip* chip : {inputs_chip_, outputs_chip_, enable_chip_}) {
    if (chip != nullptr) gpiod_chip_close(chip);
  }
  outputs_chip_ = enable_chip_ = inputs_chip_ = nullptr;
  outputs_ = {};
  enable_ = nullptr;
  inputs_count_ = 0;
  inverted_outputs_ = inverted_inputs_ = 0;
}

bool LibgpiodLines::set_outputs(std::uint32_t levels) {
  if (outputs_chip_ == nullptr) return false;
  gpiod_line_bulk bulk;
  gpiod_line_bulk_init(&bulk);
  std::array<int, kOutputLines> values{};
  for (std::size_t i = 0; i < outputs_.size(); ++i) {
    gpiod_line_bulk_add(&bulk, outputs_[i]);
    values[i] = static_cast<int>(((levels ^ inverted_outputs_) >> i) & 1U);
  }
  return gpiod_line_set_value_bulk(&bulk, values.data()) == 0;
}

bool LibgpiodLines::set_enable(bool on) {
  return enable_ != nullptr && gpiod_line_set_value(enable_, on != inverted_enable_ ? 1 : 0) == 0;
}

bool LibgpiodLines::read_inputs(std::uint32_t& levels) {
  levels = 0;
  if (outputs_chip_ == nullptr) return false;
  if (inputs_count_ == 0) return true;
  gpiod_line_bulk bulk;
  gpiod_line_bulk_init(&bulk);
  for (std::size_t i = 0; i < inputs_count_; ++i) gpiod_line_bulk_add(&bulk, inputs_[i]);
  std::array<int, kInputLines> values{};
  if (gpiod_line_get_value_bulk(&bulk, values.data()) != 0) return false;
  for (std::size_t i = 0; i < inputs_count_; ++i) {
    if (values[i] != 0) levels |= 1U << input_bits_[i];
  }
  levels ^= inverted_inputs_;
  return true;
}

}  // namespace vergence::step
