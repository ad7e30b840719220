// For libgpiod 2.
#include <gpiod.h>

#include <cerrno>
#include <cstring>
#include <memory>
#include <utility>

#include "hal/gpio_step/libgpiod_2_handles.hpp"
#include "tools/bringup/libgpiod_view.hpp"

namespace vergence::tools {
namespace {

using step::gpiod2::Chip;
using step::gpiod2::ChipInfo;
using step::gpiod2::for_each_chip;
using step::gpiod2::Handle;
using step::gpiod2::LineInfo;
using step::gpiod2::LineSettings;
using step::gpiod2::LinesToRequest;
using step::gpiod2::Request;
using step::gpiod2::RequestConfig;
using Events = Handle<gpiod_edge_event_buffer, gpiod_edge_event_buffer_free>;

constexpr const char* kConsumer = "vergence bringup";
constexpr std::size_t kEvents = 16;  // as many as the kernel keeps of a line

std::string text_of(const char* text) {
  return text == nullptr ? "" : text;
}

GpioChip describe(gpiod_chip* chip, gpiod_chip_info* info) {
  GpioChip seen{text_of(gpiod_chip_info_get_name(info)), text_of(gpiod_chip_info_get_label(info)), {}};
  for (unsigned i = 0; i < gpiod_chip_info_get_num_lines(info); ++i) {
    const LineInfo line(gpiod_chip_get_line_info(chip, i));
    if (!line) continue;
    seen.lines.push_back({text_of(gpiod_line_info_get_name(line.get())),
                          gpiod_line_info_get_direction(line.get()) == GPIOD_LINE_DIRECTION_OUTPUT,
                          gpiod_line_info_is_used(line.get()),
                          text_of(gpiod_line_info_get_consumer(line.get()))});
  }
  return seen;
}

Request request_input(gpiod_chip* chip, unsigned offset, gpiod_line_edge edge) {
  const LineSettings settings(gpiod_line_settings_new());
  const LinesToRequest lines(gpiod_line_config_new());
  const RequestConfig config(gpiod_request_config_new());
  if (!settings || !lines || !config) return nullptr;
  gpiod_request_config_set_consumer(config.get(), kConsumer);
  if (gpiod_line_settings_set_direction(settings.get(), GPIOD_LINE_DIRECTION_INPUT) != 0) return nullptr;
  if (gpiod_line_settings_set_edge_detection(settings.get(), edge) != 0) return nullptr;
  if (gpiod_line_config_add_line_settings(lines.get(), &offset, 1, settings.get()) != 0) return nullptr;
  return Request(gpiod_chip_request_lines(chip, config.get(), lines.get()));
}

}  // namespace

std::vector<GpioChip> LibgpiodView::chips(std::string& problem) {
  std::vector<GpioChip> seen;
  for_each_chip([&](const char* path) {
    errno = 0;
    const Chip chip(gpiod_chip_open(path));
    const ChipInfo info(chip ? gpiod_chip_get_info(chip.get()) : nullptr);
    if (info) {
      seen.push_back(describe(chip.get(), info.get()));
    } else {
      problem = std::string(path) + " cannot be opened: " + std::strerror(errno);
    }
    return true;
  });
  return seen;
}

std::optional<bool> LibgpiodView::level(const std::string& label, const std::string& name) {
  std::optional<bool> level;
  for_each_chip([&](const char* path) {
    const Chip chip(gpiod_chip_open(path));
    const ChipInfo info(chip ? gpiod_chip_get_info(chip.get()) : nullptr);
    if (!info || label != gpiod_chip_info_get_label(info.get())) return true;
    const int offset = gpiod_chip_get_line_offset_from_name(chip.get(), name.c_str());
    if (offset < 0) return false;
    const auto line = static_cast<unsigned>(offset);
    const Request request = request_input(chip.get(), line, GPIOD_LINE_EDGE_NONE);
    if (!request) return false;
    const gpiod_line_value value = gpiod_line_request_get_value(request.get(), line);
    if (value != GPIOD_LINE_VALUE_ERROR) level = value == GPIOD_LINE_VALUE_ACTIVE;
    return false;
  });
  return level;
}

struct LibgpiodEdges::Watched {
  Request request;
  Events events;
};

LibgpiodEdges::LibgpiodEdges() = default;
LibgpiodEdges::~LibgpiodEdges() = default;

std::string LibgpiodEdges::open(const std::string& name) {
  close();
  std::string problem = "no chip has a line '" + name + "'";
  for_each_chip([&](const char* path) {
    const Chip chip(gpiod_chip_open(path));
    const int offset = chip ? gpiod_chip_get_line_offset_from_name(chip.get(), name.c_str()) : -1;
    if (offset < 0) return true;
    const auto line = static_cast<unsigned>(offset);
    errno = 0;
    const LineInfo info(gpiod_chip_get_line_info(chip.get(), line));
    if (!info || gpiod_line_info_get_direction(info.get()) == GPIOD_LINE_DIRECTION_OUTPUT ||
        gpiod_line_info_is_used(info.get())) {
      problem = "'" + name + "' is in use, or an output";
      return false;
    }
    errno = 0;
    Watched watched{request_input(chip.get(), line, GPIOD_LINE_EDGE_RISING),
                    Events(gpiod_edge_event_buffer_new(kEvents))};
    if (!watched.request || !watched.events) {
      problem = "'" + name + "' gives no edges: " + std::strerror(errno);
      return false;
    }
    watched_ = std::make_unique<Watched>(std::move(watched));
    problem.clear();
    return false;
  });
  return problem;
}

void LibgpiodEdges::close() {
  watched_.reset();
}

void LibgpiodEdges::collect(std::vector<std::int64_t>& rising_ns) {
  while (watched_ && gpiod_line_request_wait_edge_events(watched_->request.get(), 0) == 1) {
    const int count =
        gpiod_line_request_read_edge_events(watched_->request.get(), watched_->events.get(), kEvents);
    if (count <= 0) return;
    for (int i = 0; i < count; ++i) {
      gpiod_edge_event* const event =
          gpiod_edge_event_buffer_get_event(watched_->events.get(), static_cast<unsigned long>(i));
      rising_ns.push_back(static_cast<std::int64_t>(gpiod_edge_event_get_timestamp_ns(event)));
    }
  }
}

}  // namespace vergence::tools
