// For libgpiod 1.x, and with libgpiod_2_group.cpp all of the controller's calls of it.
#include <gpiod.h>

#include <cerrno>
#include <cstring>

#include "hal/gpio_step/line_group.hpp"

namespace vergence::step {
namespace {

constexpr const char* kConsumer = "vergence";

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
  return lines_error_of_errno(LinesErrorKind::kChipNotFound, label);
}

LinesError find_line(gpiod_chip* chip, const GpioName& name, gpiod_line*& line) {
  if (!is_named(name)) return {LinesErrorKind::kNotNamed, name, 0};
  errno = 0;
  line = gpiod_chip_find_line(chip, name.data());
  return line == nullptr ? lines_error_of_errno(LinesErrorKind::kLineNotFound, name) : LinesError{};
}

gpiod_line_bulk bulk_of(std::span<gpiod_line* const> lines) {
  gpiod_line_bulk bulk;
  gpiod_line_bulk_init(&bulk);
  for (gpiod_line* line : lines) gpiod_line_bulk_add(&bulk, line);
  return bulk;
}

// A request of several lines that failed does not say which was to blame.
LinesError blame(std::span<gpiod_line* const> lines, const GpioName& chip, std::span<const LineSpec> specs) {
  LinesError error =
      lines_error_of_errno(LinesErrorKind::kRequestFailed, specs.size() == 1 ? specs.front().name : chip);
  if (error.kind != LinesErrorKind::kLineBusy) return error;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (gpiod_line_is_used(lines[i])) {
      error.what = specs[i].name;
      break;
    }
  }
  return error;
}

}  // namespace

LinesError LineGroup::take(const GpioName& chip, std::span<const LineSpec> specs,
                           const std::uint32_t* levels) {
  LinesError error = open_chip(chip, chip_);
  std::array<int, kGroupLines> values{};
  for (std::size_t i = 0; i < specs.size() && error.kind == LinesErrorKind::kNone; ++i) {
    error = find_line(chip_, specs[i].name, lines_[i]);
    if (levels != nullptr) values[i] = static_cast<int>((*levels >> i) & 1U);
  }
  if (error.kind != LinesErrorKind::kNone) return error;
  const std::span<gpiod_line* const> lines = std::span(lines_).first(specs.size());
  gpiod_line_bulk bulk = bulk_of(lines);
  errno = 0;
  const int result = levels != nullptr ? gpiod_line_request_bulk_output(&bulk, kConsumer, values.data())
                                       : gpiod_line_request_bulk_input(&bulk, kConsumer);
  if (result != 0) return blame(lines, chip, specs);
  count_ = specs.size();
  return {};
}

void LineGroup::release() {
  // Closing a chip releases its lines.
  if (chip_ != nullptr) gpiod_chip_close(chip_);
  chip_ = nullptr;
  lines_ = {};
  count_ = 0;
}

bool LineGroup::set(std::uint32_t levels) {
  gpiod_line_bulk bulk = bulk_of(std::span(lines_).first(count_));
  std::array<int, kGroupLines> values{};
  for (std::size_t i = 0; i < count_; ++i) values[i] = static_cast<int>((levels >> i) & 1U);
  return gpiod_line_set_value_bulk(&bulk, values.data()) == 0;
}

// One call of the kernel, and besides a note in the library's memory that nothing reads.
bool LineGroup::set_first(bool level) {
  return gpiod_line_set_value(lines_.front(), level ? 1 : 0) == 0;
}

bool LineGroup::get(std::uint32_t& levels) {
  levels = 0;
  gpiod_line_bulk bulk = bulk_of(std::span(lines_).first(count_));
  std::array<int, kGroupLines> values{};
  if (gpiod_line_get_value_bulk(&bulk, values.data()) != 0) return false;
  for (std::size_t i = 0; i < count_; ++i) {
    if (values[i] != 0) levels |= 1U << i;
  }
  return true;
}

}  // namespace vergence::step
