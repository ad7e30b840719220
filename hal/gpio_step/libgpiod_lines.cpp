#include "hal/gpio_step/libgpiod_lines.hpp"

#include <span>

namespace vergence::step {
namespace {

constexpr std::uint32_t kAllForward = forward_bit(0) | forward_bit(1) | forward_bit(2);

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

}  // namespace

LinesError LibgpiodLines::request_outputs(const LinesConfig& config) {
  for (std::size_t i = 0; i < config.outputs.size(); ++i) {
    if (config.outputs[i].inverted) inverted_outputs_ |= 1U << i;
  }
  return outputs_.request_outputs(config.outputs_chip, config.outputs, kAllForward ^ inverted_outputs_);
}

LinesError LibgpiodLines::request_inputs(const LinesConfig& config) {
  std::array<LineSpec, kInputLines> present{};
  for (std::size_t i = 0; i < config.inputs.size(); ++i) {
    if (config.inputs[i].name.front() == '\0') continue;
    if (config.inputs[i].inverted) inverted_inputs_ |= 1U << i;
    present[inputs_count_] = config.inputs[i];
    input_bits_[inputs_count_++] = i;
  }
  if (inputs_count_ == 0) return {};
  return inputs_.request_inputs(config.inputs_chip, std::span(present).first(inputs_count_));
}

LinesError LibgpiodLines::request_all(const LinesConfig& config) {
  LinesError error = find_twice(config);
  if (error.kind != LinesErrorKind::kNone) return error;
  // The enable line first: nothing moves while the others are taken.
  inverted_enable_ = config.enable.inverted;
  error = enable_.request_outputs(config.enable_chip, std::span(&config.enable, 1), inverted_enable_ ? 1 : 0);
  if (error.kind == LinesErrorKind::kNone) error = request_outputs(config);
  return error.kind == LinesErrorKind::kNone ? request_inputs(config) : error;
}

LinesError LibgpiodLines::open(const LinesConfig& config) {
  close();
  const LinesError error = request_all(config);
  if (error.kind != LinesErrorKind::kNone) close();
  return error;
}

void LibgpiodLines::close() {
  (void)set_enable(false);
  (void)set_outputs(kAllForward);
  inputs_.release();
  outputs_.release();
  enable_.release();
  inputs_count_ = 0;
  inverted_outputs_ = inverted_inputs_ = 0;
}

bool LibgpiodLines::set_outputs(std::uint32_t levels) {
  return outputs_.is_requested() && outputs_.set(levels ^ inverted_outputs_);
}

bool LibgpiodLines::set_enable(bool on) {
  return enable_.is_requested() && enable_.set_first(on != inverted_enable_);
}

bool LibgpiodLines::read_inputs(std::uint32_t& levels) {
  levels = 0;
  if (!outputs_.is_requested()) return false;
  std::uint32_t wires = 0;
  if (inputs_count_ > 0 && !inputs_.get(wires)) return false;
  for (std::size_t i = 0; i < inputs_count_; ++i) {
    if (((wires >> i) & 1U) != 0) levels |= 1U << input_bits_[i];
  }
  levels ^= inverted_inputs_;
  return true;
}

}  // namespace vergence::step
