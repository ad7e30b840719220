#include "hal/gpio_step/memory_lines.hpp"

namespace vergence::step {

void MemoryLines::add(int line, bool level) {
  if (recorded_ == record_.size()) {
    ++lost_;
    return;
  }
  record_[recorded_++] = {clock_->now_ns(), line, level};
}

bool MemoryLines::set_outputs(std::uint32_t levels) {
  ++set_calls_;
  if (outputs_broken_) return false;
  clock_->set_now_ns(clock_->now_ns() + before_ns_);
  for (int line = 0; line < kOutputLines; ++line) {
    const std::uint32_t bit = 1U << line;
    if (((outputs_ ^ levels) & bit) != 0) add(line, (levels & bit) != 0);
  }
  outputs_ = levels;
  clock_->set_now_ns(clock_->now_ns() + after_ns_);
  return true;
}

bool MemoryLines::set_enable(bool on) {
  if (enable_broken_) return false;
  if (on != enabled_) add(kEnableLine, on);
  enabled_ = on;
  return true;
}

bool MemoryLines::read_inputs(std::uint32_t& levels) {
  if (inputs_broken_) return false;
  levels = inputs_;
  return true;
}

}  // namespace vergence::step
