// For libgpiod 2, and with libgpiod_1_group.cpp all of the controller's calls of it.
#include <gpiod.h>
#include <linux/gpio.h>
#include <sys/ioctl.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "hal/gpio_step/libgpiod_2_handles.hpp"
#include "hal/gpio_step/line_group.hpp"

namespace vergence::step {
namespace {

using gpiod2::Chip;
using gpiod2::ChipInfo;
using gpiod2::LineInfo;
using gpiod2::LineSettings;
using gpiod2::LinesToRequest;
using gpiod2::RequestConfig;

constexpr const char* kConsumer = "vergence";

// The only chip with this label; none, and how many there are, where it is not the only one. Where one may
// not be opened, its label may be this one: none, and errno.
Chip only_chip_labelled(const GpioName& label, int& count) {
  count = 0;
  Chip found;
  int os_error = 0;
  gpiod2::for_each_chip([&](const char* path) {
    errno = 0;
    Chip chip(gpiod_chip_open(path));
    const ChipInfo info(chip ? gpiod_chip_get_info(chip.get()) : nullptr);
    if (!info) {
      os_error = errno;
      return false;
    }
    if (std::strcmp(gpiod_chip_info_get_label(info.get()), label.data()) == 0 && ++count == 1) {
      found = std::move(chip);
    }
    return true;
  });
  if (count != 1 || os_error != 0) found.reset();
  errno = os_error;
  return found;
}

LinesError open_chip(const GpioName& label, Chip& chip) {
  if (!is_named(label)) return {LinesErrorKind::kNotNamed, label, 0};
  int count = 0;
  chip = only_chip_labelled(label, count);
  if (chip) return {};
  const int label_error = errno;
  if (label_error == 0 && count > 1) return {LinesErrorKind::kChipUnclear, label, 0};
  errno = 0;
  chip.reset(gpiod_chip_open(gpiod2::path_of_chip(label.data()).data()));
  if (chip) return {};
  if (label_error != 0) errno = label_error;
  return lines_error_of_errno(LinesErrorKind::kChipNotFound, label);
}

LinesError find_line(gpiod_chip* chip, const GpioName& name, unsigned& offset) {
  if (!is_named(name)) return {LinesErrorKind::kNotNamed, name, 0};
  errno = 0;
  const int found = gpiod_chip_get_line_offset_from_name(chip, name.data());
  if (found < 0) return lines_error_of_errno(LinesErrorKind::kLineNotFound, name);
  offset = static_cast<unsigned>(found);
  return {};
}

gpiod_line_value value_of(std::uint32_t levels, std::size_t i) {
  return ((levels >> i) & 1U) != 0 ? GPIOD_LINE_VALUE_ACTIVE : GPIOD_LINE_VALUE_INACTIVE;
}

// Null, and errno, where it failed.
gpiod_line_request* request_lines(gpiod_chip* chip, std::span<const unsigned> offsets,
                                  const std::uint32_t* levels) {
  errno = 0;
  const LineSettings settings(gpiod_line_settings_new());
  const LinesToRequest lines(gpiod_line_config_new());
  const RequestConfig config(gpiod_request_config_new());
  if (!settings || !lines || !config) return nullptr;
  gpiod_request_config_set_consumer(config.get(), kConsumer);
  const gpiod_line_direction direction =
      levels != nullptr ? GPIOD_LINE_DIRECTION_OUTPUT : GPIOD_LINE_DIRECTION_INPUT;
  if (gpiod_line_settings_set_direction(settings.get(), direction) != 0) return nullptr;
  for (std::size_t i = 0; i < offsets.size(); ++i) {
    if (levels != nullptr &&
        gpiod_line_settings_set_output_value(settings.get(), value_of(*levels, i)) != 0) {
      return nullptr;
    }
    if (gpiod_line_config_add_line_settings(lines.get(), &offsets[i], 1, settings.get()) != 0) return nullptr;
  }
  return gpiod_chip_request_lines(chip, config.get(), lines.get());
}

// A request of several lines that failed does not say which was to blame.
LinesError blame(gpiod_chip* chip, std::span<const unsigned> offsets, const GpioName& label,
                 std::span<const LineSpec> specs) {
  LinesError error =
      lines_error_of_errno(LinesErrorKind::kRequestFailed, specs.size() == 1 ? specs.front().name : label);
  if (error.kind != LinesErrorKind::kLineBusy) return error;
  for (std::size_t i = 0; i < offsets.size(); ++i) {
    const LineInfo info(gpiod_chip_get_line_info(chip, offsets[i]));
    if (info && gpiod_line_info_is_used(info.get())) {
      error.what = specs[i].name;
      break;
    }
  }
  return error;
}

}  // namespace

LinesError LineGroup::take(const GpioName& label, std::span<const LineSpec> specs,
                           const std::uint32_t* levels) {
  Chip chip;  // a request outlives it
  LinesError error = open_chip(label, chip);
  for (std::size_t i = 0; i < specs.size() && error.kind == LinesErrorKind::kNone; ++i) {
    error = find_line(chip.get(), specs[i].name, offsets_[i]);
  }
  if (error.kind != LinesErrorKind::kNone) return error;
  const std::span<const unsigned> offsets = std::span(offsets_).first(specs.size());
  request_ = request_lines(chip.get(), offsets, levels);
  if (request_ == nullptr) return blame(chip.get(), offsets, label, specs);
  file_ = gpiod_line_request_get_fd(request_);
  count_ = specs.size();
  return {};
}

void LineGroup::release() {
  if (request_ != nullptr) gpiod_line_request_release(request_);
  request_ = nullptr;
  file_ = -1;
  count_ = 0;
}

bool LineGroup::set(std::uint32_t levels) {
  std::array<gpiod_line_value, kGroupLines> values{};
  for (std::size_t i = 0; i < count_; ++i) values[i] = value_of(levels, i);
  return gpiod_line_request_set_values_subset(request_, count_, offsets_.data(), values.data()) == 0;
}

// The kernel's own call on the request's file: the library promises nothing for one request in two threads,
// the kernel takes it from any. Version 2 of the library always has version 2 of the kernel's calls.
bool LineGroup::set_first(bool level) {
  gpio_v2_line_values values{};
  values.mask = 1;
  values.bits = level ? 1 : 0;
  return ::ioctl(file_, GPIO_V2_LINE_SET_VALUES_IOCTL, &values) == 0;
}

bool LineGroup::get(std::uint32_t& levels) {
  levels = 0;
  std::array<gpiod_line_value, kGroupLines> values{};
  if (gpiod_line_request_get_values_subset(request_, count_, offsets_.data(), values.data()) != 0)
    return false;
  for (std::size_t i = 0; i < count_; ++i) {
    if (values[i] == GPIOD_LINE_VALUE_ACTIVE) levels |= 1U << i;
  }
  return true;
}

}  // namespace vergence::step
