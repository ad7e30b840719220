// libgpiod 1.x.
#include "tests/support/fake_gpiod.hpp"

#include <gpiod.h>

#include <cerrno>
#include <deque>
#include <memory>

using vergence::testing::fake_gpio;
using vergence::testing::FakeGpio;
using vergence::testing::FakeGpioLine;

// Handles. A line's belongs to its chip's, and only the handle it was requested by may use it.
struct gpiod_line {
  std::size_t chip;
  std::size_t offset;
  bool is_requested = false;

  [[nodiscard]] FakeGpioLine& wire() const { return fake_gpio().chips.at(chip).lines.at(offset); }
};

struct gpiod_chip {
  std::size_t index;
  std::deque<gpiod_line> lines;
};

struct gpiod_chip_iter {
  std::size_t next = 0;
};

namespace {

int failed(int error) {
  errno = error;
  return -1;
}

gpiod_chip* open_handle(std::size_t index) {
  ++fake_gpio().open_handles;
  auto chip = std::make_unique<gpiod_chip>(gpiod_chip{index, {}});
  return chip.release();
}

int request(gpiod_line* const* lines, unsigned int count, const int* levels, int error) {
  if (error != 0) return failed(error);
  for (unsigned int i = 0; i < count; ++i) {
    if (lines[i]->wire().is_others || lines[i]->wire().is_ours) return failed(EBUSY);
  }
  for (unsigned int i = 0; i < count; ++i) {
    FakeGpioLine& wire = lines[i]->wire();
    lines[i]->is_requested = wire.is_ours = true;
    wire.is_output = levels != nullptr;
    if (levels == nullptr) continue;
    wire.level = levels[i];
    fake_gpio().writes.push_back({wire.name, wire.level});
  }
  return 0;
}

int set(gpiod_line* const* lines, unsigned int count, const int* levels) {
  ++fake_gpio().set_calls;
  if (fake_gpio().set_error != 0) return failed(fake_gpio().set_error);
  for (unsigned int i = 0; i < count; ++i) {
    if (!lines[i]->is_requested || !lines[i]->wire().is_output) return failed(EPERM);
  }
  for (unsigned int i = 0; i < count; ++i) {
    FakeGpioLine& wire = lines[i]->wire();
    if (wire.level != levels[i]) fake_gpio().writes.push_back({wire.name, levels[i]});
    wire.level = levels[i];
  }
  return 0;
}

}  // namespace

extern "C" {

gpiod_chip_iter* gpiod_chip_iter_new() {
  if (fake_gpio().list_error != 0) {
    errno = fake_gpio().list_error;
    return nullptr;
  }
  fake_gpio().open_handles += static_cast<int>(fake_gpio().chips.size());
  return std::make_unique<gpiod_chip_iter>().release();
}

gpiod_chip* gpiod_chip_iter_next_noclose(gpiod_chip_iter* iter) {
  if (iter->next == fake_gpio().chips.size()) return nullptr;
  --fake_gpio().open_handles;  // the iterator's becomes the caller's
  return open_handle(iter->next++);
}

void gpiod_chip_iter_free_noclose(gpiod_chip_iter* iter) {
  fake_gpio().open_handles -= static_cast<int>(fake_gpio().chips.size() - iter->next);
  const std::unique_ptr<gpiod_chip_iter> owner(iter);
}

gpiod_chip* gpiod_chip_open_by_name(const char* name) {
  for (std::size_t i = 0; i < fake_gpio().chips.size(); ++i) {
    if (fake_gpio().chips[i].name != name) continue;
    if (fake_gpio().open_error == 0) return open_handle(i);
    errno = fake_gpio().open_error;
    return nullptr;
  }
  errno = ENOENT;
  return nullptr;
}

const char* gpiod_chip_label(gpiod_chip* chip) {
  return fake_gpio().chips.at(chip->index).label.c_str();
}

void gpiod_chip_close(gpiod_chip* chip) {
  const std::unique_ptr<gpiod_chip> owner(chip);
  --fake_gpio().open_handles;
  for (const gpiod_line& line : chip->lines) {
    if (line.is_requested) line.wire().is_ours = false;
  }
}

gpiod_line* gpiod_chip_find_line(gpiod_chip* chip, const char* name) {
  if (fake_gpio().find_error != 0) {
    errno = fake_gpio().find_error;
    return nullptr;
  }
  const auto& lines = fake_gpio().chips.at(chip->index).lines;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (lines[i].name != name) continue;
    for (gpiod_line& line : chip->lines) {
      if (line.offset == i) return &line;
    }
    return &chip->lines.emplace_back(gpiod_line{chip->index, i});
  }
  errno = ENOENT;
  return nullptr;
}

bool gpiod_line_is_used(gpiod_line* line) {
  return line->wire().is_others || line->wire().is_ours;
}

int gpiod_line_request_bulk_output(gpiod_line_bulk* bulk, const char* /*consumer*/, const int* levels) {
  const FakeGpio& gpio = fake_gpio();
  return request(bulk->lines, bulk->num_lines, levels,
                 bulk->num_lines == 1 ? gpio.enable_request_error : gpio.output_request_error);
}

int gpiod_line_request_bulk_input(gpiod_line_bulk* bulk, const char* /*consumer*/) {
  return request(bulk->lines, bulk->num_lines, nullptr, fake_gpio().input_request_error);
}

int gpiod_line_set_value(gpiod_line* line, int level) {
  return set(&line, 1, &level);
}

int gpiod_line_set_value_bulk(gpiod_line_bulk* bulk, const int* levels) {
  return set(bulk->lines, bulk->num_lines, levels);
}

int gpiod_line_get_value_bulk(gpiod_line_bulk* bulk, int* levels) {
  if (fake_gpio().get_error != 0) return failed(fake_gpio().get_error);
  for (unsigned int i = 0; i < bulk->num_lines; ++i) {
    if (!bulk->lines[i]->is_requested) return failed(EPERM);
    levels[i] = bulk->lines[i]->wire().level;
  }
  return 0;
}

}  // extern "C"
