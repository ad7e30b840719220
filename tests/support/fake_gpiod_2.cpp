// libgpiod 2, and the kernel's call on the file of a request.
#include <gpiod.h>
#include <linux/gpio.h>

#include <cerrno>
#include <cstdarg>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "tests/support/fake_gpiod.hpp"

using vergence::testing::fake_gpio;
using vergence::testing::FakeGpio;
using vergence::testing::FakeGpioChip;
using vergence::testing::FakeGpioLine;

struct gpiod_chip {
  std::size_t index;
};
struct gpiod_chip_info {
  std::size_t index;
};
struct gpiod_line_info {
  bool is_used;
};
struct gpiod_line_settings {
  gpiod_line_direction direction = GPIOD_LINE_DIRECTION_AS_IS;
  gpiod_line_value value = GPIOD_LINE_VALUE_INACTIVE;
};
struct gpiod_line_config {
  std::vector<unsigned> offsets;
  std::vector<gpiod_line_settings> settings;
};
struct gpiod_request_config {
  std::string consumer;
};
struct gpiod_line_request {
  std::size_t chip;
  std::vector<unsigned> offsets;
  int file;

  [[nodiscard]] FakeGpioLine& wire(std::size_t i) const {
    return fake_gpio().chips.at(chip).lines.at(offsets.at(i));
  }
};

namespace {

// Files of requests are numbered from here; no test opens as many.
constexpr int kFirstFile = 1'000'000;
int next_file = kFirstFile;
std::vector<gpiod_line_request*> requests;

int failed(int error) {
  errno = error;
  return -1;
}

template <typename T>
T* failed_null(int error) {
  errno = error;
  return nullptr;
}

template <typename T>
T* give_out(T value) {
  ++fake_gpio().open_handles;
  return std::make_unique<T>(std::move(value)).release();
}

template <typename T>
void take_back(T* handle) {
  if (handle == nullptr) return;
  --fake_gpio().open_handles;
  const std::unique_ptr<T> owner(handle);
}

const FakeGpioChip* chip_of_path(const char* path) {
  for (const FakeGpioChip& chip : fake_gpio().chips) {
    if ("/dev/" + chip.name == path) return &chip;
  }
  return nullptr;
}

// Bit i of mask and levels: line i of the request, as the kernel counts.
int set(gpiod_line_request& request, std::uint64_t mask, std::uint64_t levels) {
  ++fake_gpio().set_calls;
  if (fake_gpio().set_error != 0) return failed(fake_gpio().set_error);
  for (std::size_t i = 0; i < request.offsets.size(); ++i) {
    if (((mask >> i) & 1U) == 0) continue;
    FakeGpioLine& wire = request.wire(i);
    if (!wire.is_output) return failed(EPERM);
    const int level = static_cast<int>((levels >> i) & 1U);
    if (wire.level != level) fake_gpio().writes.push_back({wire.name, level});
    wire.level = level;
  }
  return 0;
}

// As the library finds it: an offset that was not requested is refused.
int index_of(const gpiod_line_request& request, unsigned offset) {
  for (std::size_t i = 0; i < request.offsets.size(); ++i) {
    if (request.offsets[i] == offset) return static_cast<int>(i);
  }
  return failed(EINVAL);
}

}  // namespace

extern "C" {

bool gpiod_is_gpiochip_device(const char* path) {
  return chip_of_path(path) != nullptr;
}

// Who looks through all chips opens the last of them, which is nobody's.
gpiod_chip* gpiod_chip_open(const char* path) {
  const FakeGpioChip* const chip = chip_of_path(path);
  if (chip == nullptr) return failed_null<gpiod_chip>(ENOENT);
  const FakeGpio& gpio = fake_gpio();
  if (gpio.open_error != 0) return failed_null<gpiod_chip>(gpio.open_error);
  const bool is_last = chip == &gpio.chips.back();
  if (gpio.list_error != 0 && is_last) return failed_null<gpiod_chip>(gpio.list_error);
  return give_out(gpiod_chip{static_cast<std::size_t>(chip - gpio.chips.data())});
}

void gpiod_chip_close(gpiod_chip* chip) {
  take_back(chip);
}

gpiod_chip_info* gpiod_chip_get_info(gpiod_chip* chip) {
  return give_out(gpiod_chip_info{chip->index});
}

void gpiod_chip_info_free(gpiod_chip_info* info) {
  take_back(info);
}

const char* gpiod_chip_info_get_label(gpiod_chip_info* info) {
  return fake_gpio().chips.at(info->index).label.c_str();
}

int gpiod_chip_get_line_offset_from_name(gpiod_chip* chip, const char* name) {
  if (fake_gpio().find_error != 0) return failed(fake_gpio().find_error);
  const auto& lines = fake_gpio().chips.at(chip->index).lines;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (lines[i].name == name) return static_cast<int>(i);
  }
  return failed(ENOENT);
}

gpiod_line_info* gpiod_chip_get_line_info(gpiod_chip* chip, unsigned offset) {
  const FakeGpioLine& wire = fake_gpio().chips.at(chip->index).lines.at(offset);
  return give_out(gpiod_line_info{wire.is_others || wire.is_ours});
}

void gpiod_line_info_free(gpiod_line_info* info) {
  take_back(info);
}

bool gpiod_line_info_is_used(gpiod_line_info* info) {
  return info->is_used;
}

gpiod_line_settings* gpiod_line_settings_new() {
  return give_out(gpiod_line_settings{});
}

void gpiod_line_settings_free(gpiod_line_settings* settings) {
  take_back(settings);
}

int gpiod_line_settings_set_direction(gpiod_line_settings* settings, gpiod_line_direction direction) {
  settings->direction = direction;
  return 0;
}

int gpiod_line_settings_set_output_value(gpiod_line_settings* settings, gpiod_line_value value) {
  settings->value = value;
  return 0;
}

gpiod_line_config* gpiod_line_config_new() {
  return give_out(gpiod_line_config{});
}

void gpiod_line_config_free(gpiod_line_config* config) {
  take_back(config);
}

// The settings are copied.
int gpiod_line_config_add_line_settings(gpiod_line_config* config, const unsigned* offsets, std::size_t count,
                                        gpiod_line_settings* settings) {
  for (std::size_t i = 0; i < count; ++i) {
    config->offsets.push_back(offsets[i]);
    config->settings.push_back(*settings);
  }
  return 0;
}

gpiod_request_config* gpiod_request_config_new() {
  return give_out(gpiod_request_config{});
}

void gpiod_request_config_free(gpiod_request_config* config) {
  take_back(config);
}

void gpiod_request_config_set_consumer(gpiod_request_config* config, const char* consumer) {
  config->consumer = consumer;
}

gpiod_line_request* gpiod_chip_request_lines(gpiod_chip* chip, gpiod_request_config* config,
                                             gpiod_line_config* lines) {
  FakeGpio& gpio = fake_gpio();
  if (config->consumer.empty() || lines->offsets.empty()) return failed_null<gpiod_line_request>(EINVAL);
  const bool are_outputs = lines->settings.front().direction == GPIOD_LINE_DIRECTION_OUTPUT;
  const int error = !are_outputs                 ? gpio.input_request_error
                    : lines->offsets.size() == 1 ? gpio.enable_request_error
                                                 : gpio.output_request_error;
  if (error != 0) return failed_null<gpiod_line_request>(error);
  gpiod_line_request request{chip->index, lines->offsets, next_file++};
  for (std::size_t i = 0; i < request.offsets.size(); ++i) {
    if (request.wire(i).is_others || request.wire(i).is_ours) return failed_null<gpiod_line_request>(EBUSY);
  }
  for (std::size_t i = 0; i < request.offsets.size(); ++i) {
    FakeGpioLine& wire = request.wire(i);
    const gpiod_line_settings& settings = lines->settings[i];
    wire.is_ours = true;
    wire.is_output = settings.direction == GPIOD_LINE_DIRECTION_OUTPUT;
    if (!wire.is_output) continue;
    wire.level = settings.value == GPIOD_LINE_VALUE_ACTIVE ? 1 : 0;
    gpio.writes.push_back({wire.name, wire.level});
  }
  requests.push_back(give_out(std::move(request)));
  return requests.back();
}

void gpiod_line_request_release(gpiod_line_request* request) {
  for (std::size_t i = 0; i < request->offsets.size(); ++i) request->wire(i).is_ours = false;
  std::erase(requests, request);
  take_back(request);
}

int gpiod_line_request_get_fd(gpiod_line_request* request) {
  return request->file;
}

int gpiod_line_request_set_values_subset(gpiod_line_request* request, std::size_t count,
                                         const unsigned* offsets, const gpiod_line_value* values) {
  std::uint64_t mask = 0;
  std::uint64_t levels = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const int bit = index_of(*request, offsets[i]);
    if (bit < 0) return -1;
    mask |= std::uint64_t{1} << bit;
    if (values[i] == GPIOD_LINE_VALUE_ACTIVE) levels |= std::uint64_t{1} << bit;
  }
  return set(*request, mask, levels);
}

int gpiod_line_request_get_values_subset(gpiod_line_request* request, std::size_t count,
                                         const unsigned* offsets, gpiod_line_value* values) {
  if (fake_gpio().get_error != 0) return failed(fake_gpio().get_error);
  for (std::size_t i = 0; i < count; ++i) {
    const int bit = index_of(*request, offsets[i]);
    if (bit < 0) return -1;
    values[i] = request->wire(static_cast<std::size_t>(bit)).level != 0 ? GPIOD_LINE_VALUE_ACTIVE
                                                                        : GPIOD_LINE_VALUE_INACTIVE;
  }
  return 0;
}

// In place of the C library's: these tests have no other files to control.
int ioctl(int file, unsigned long call, ...) noexcept {
  va_list more;
  va_start(more, call);
  void* const argument = va_arg(more, void*);
  va_end(more);
  for (gpiod_line_request* request : requests) {
    if (request->file != file) continue;
    if (call != GPIO_V2_LINE_SET_VALUES_IOCTL) return failed(EINVAL);
    const auto* values = static_cast<const gpio_v2_line_values*>(argument);
    return set(*request, values->mask, values->bits);
  }
  return failed(EBADF);
}

}  // extern "C"
