// What libgpiod 2 hands out, given back by itself; and the chips of this machine in their order.
#pragma once

#include <gpiod.h>

#include <array>
#include <cstdio>
#include <memory>

namespace vergence::step::gpiod2 {

// `Free` is the library's own function for it.
template <auto Free>
struct GiveBack {
  template <typename T>
  void operator()(T* handle) const {
    Free(handle);
  }
};
template <typename T, auto Free>
using Handle = std::unique_ptr<T, GiveBack<Free>>;

using Chip = Handle<gpiod_chip, gpiod_chip_close>;
using ChipInfo = Handle<gpiod_chip_info, gpiod_chip_info_free>;
using LineInfo = Handle<gpiod_line_info, gpiod_line_info_free>;
using LineSettings = Handle<gpiod_line_settings, gpiod_line_settings_free>;
using LinesToRequest = Handle<gpiod_line_config, gpiod_line_config_free>;
using RequestConfig = Handle<gpiod_request_config, gpiod_request_config_free>;
using Request = Handle<gpiod_line_request, gpiod_line_request_release>;

// The kernel has no more (GPIO_DEV_MAX), and numbers them from 0, with gaps where one was unplugged.
inline constexpr int kMostChips = 256;

using ChipPath = std::array<char, 64>;

// "/dev/" and a name such as gpiochip2.
[[nodiscard]] inline ChipPath path_of_chip(const char* name) {
  ChipPath path{};
  (void)std::snprintf(path.data(), path.size(), "/dev/%s", name);
  return path;
}

// Calls see(path) of each chip that is there, until it answers false.
template <typename See>
void for_each_chip(See&& see) {
  for (int number = 0; number < kMostChips; ++number) {
    ChipPath path{};
    (void)std::snprintf(path.data(), path.size(), "/dev/gpiochip%d", number);
    if (gpiod_is_gpiochip_device(path.data()) && !see(path.data())) return;
  }
}

}  // namespace vergence::step::gpiod2
