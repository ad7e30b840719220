// For libgpiod 1.x, and the only file of the controller with calls of it: version 2 has another interface and
// gets a file of its own beside this one.
#include "hal/gpio_step/libgpiod_lines.hpp"

#include <gpiod.h>

#include <cerrno>
#include <cstring>

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

bool is_named(const GpioName& name) {
  return name.front() != '\0' && name.back() == '\0';
}

// The only chip with this label; null, and how many there are, where it is not the only one.
gpiod_chip* only_chip_labelled(const GpioName& label, int& count) {
  count = 0;
  errno = 0;
  gpiod_chip_iter* all = gpiod_chip_iter_new();
  if (all == nullptr) return nullptr;
  gpiod_chip* found = nullptr;
  while (gpiod_chip* chip = gpiod_chip_iter_next_noclose(all)) {
    const bool matches = std::strcmp(gpiod_chip_label(chip), label.data()) == 0;
    if (matches) ++count;
    if (matches && found == nullptr) {
      found = chip;
    } else {
      gpiod_chip_close(chip);
    }
  }
  gpiod_chip_iter_free_noclose(all);
  if (count <= 1) return found;
  gpiod_chip_close(found);
  return nullptr;
}

LinesError open_chip(const GpioName& label, gpiod_chip*& chip) {
  if (!is_named(label)) return {LinesErrorKind::kNotNamed, label, 0};
  int count = 0;
  chip = only_chip_labelled(label, count);
  if (chip != nullptr) return {};
  if (count > 1) return {LinesErrorKind::kChipUnclear, label, 0};
  const int label_error = errno;  // where some chip may not be opened, no labels are read
  errno = 0;
  chip = gpiod_chip_open_by_name(label.data());
  if (chip != nullptr) return {};
  if (label_error != 0) errno = label_error;
  return error_of(LinesErrorKind::kChipNotFound, label);
}

LinesError find_line(gpiod_chip* chip, const GpioName& name, gpiod_line*& line) {
  if (!is_named(name)) return {LinesErrorKind::kNotNamed, name, 0};
  errno = 0;
  line = gpiod_chip_find_line(chip, name.data());
  return line == nullptr ? error_of(LinesErrorKind::kLineNotFound, name) : LinesError{};
}

// Lines that are needed and have no name are found later.
LinesError find_twice(const LinesConfig& config) {
  struct Use {
    const GpioName* chip;
    const GpioName* line;
  };
  std::array<Use, kOutputLines + 1 + kInputLines> uses{};
  std::size_t count = 0;
  uses[count++] = {&config.enable_chip, &config.enable.name};
  for (const LineSpec& output : config.outputs) uses[count++] = {&config.outputs_chip, &output.name};
  for (const LineSpec& input : config.inputs) uses[count++] = {&config.inputs_chip, &input.name};
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (is_named(*uses[i].line) && *uses[i].line == *uses[j].line && *uses[i].chip == *uses[j].chip) {
        return {LinesErrorKind::kNamedTwice, *uses[i].line, 0};
      }
    }
  }
  return {};
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
  errno = 0;
  are_outputs_ours_ = gpiod_line_request_bulk_output(&bulk, kConsumer, values.data()) == 0;
  if (are_outputs_ours_) return {};
  return blame(error_of(LinesErrorKind::kRequestFailed, config.outputs_chip), outputs_.data(), specs.data(),
               outputs_.size());
}

LinesError LibgpiodLines::request_inputs(const LinesConfig& config) {
  gpiod_line_bulk bulk;
  gpiod_line_bulk_init(&bulk);
  std::array<const LineSpec*, kInputLines> specs{};
  for (std::size_t i = 0; i < config.inputs.size(); ++i) {
    const LineSpec& spec = config.inputs[i];
    if (spec.name.front() == '\0') continue;
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
  errno = 0;
  if (inputs_count_ == 0 || gpiod_line_request_bulk_input(&bulk, kConsumer) == 0) return {};
  return blame(error_of(LinesErrorKind::kRequestFailed, config.inputs_chip), inputs_.data(), specs.data(),
               inputs_count_);
}

LinesError LibgpiodLines::request_all(const LinesConfig& config) {
  LinesError error = find_twice(config);
  // The enable line first: nothing moves while the others are taken.
  if (error.kind == LinesErrorKind::kNone) error = open_chip(config.enable_chip, enable_chip_);
  gpiod_line* enable = nullptr;
  if (error.kind == LinesErrorKind::kNone) error = find_line(enable_chip_, config.enable.name, enable);
  if (error.kind != LinesErrorKind::kNone) return error;
  errno = 0;
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
  if (are_outputs_ours_) (void)set_outputs(kAllForward);
  are_outputs_ours_ = false;
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
  if (!are_outputs_ours_) return false;
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
  if (!are_outputs_ours_) return false;
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
