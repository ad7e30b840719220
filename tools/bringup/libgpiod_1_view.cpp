// For libgpiod 1.x.
#include "tools/bringup/libgpiod_view.hpp"

#include <gpiod.h>

#include <cerrno>
#include <cstring>
#include <ctime>
#include <memory>
#include <utility>

namespace vergence::tools {
namespace {

constexpr const char* kConsumer = "vergence bringup";

struct CloseChip {
  void operator()(gpiod_chip* chip) const { gpiod_chip_close(chip); }
};
using Chip = std::unique_ptr<gpiod_chip, CloseChip>;

std::string text_of(const char* text) {
  return text == nullptr ? "" : text;
}

GpioChip describe(gpiod_chip* chip) {
  GpioChip seen{text_of(gpiod_chip_name(chip)), text_of(gpiod_chip_label(chip)), {}};
  for (unsigned i = 0; i < gpiod_chip_num_lines(chip); ++i) {
    gpiod_line* const line = gpiod_chip_get_line(chip, i);
    if (line == nullptr) continue;
    seen.lines.push_back({text_of(gpiod_line_name(line)),
                          gpiod_line_direction(line) == GPIOD_LINE_DIRECTION_OUTPUT, gpiod_line_is_used(line),
                          text_of(gpiod_line_consumer(line))});
  }
  return seen;
}

}  // namespace

std::vector<GpioChip> LibgpiodView::chips(std::string& problem) {
  std::vector<GpioChip> seen;
  errno = 0;
  gpiod_chip_iter* const all = gpiod_chip_iter_new();
  if (all == nullptr) {
    problem = std::string("the chips cannot be opened: ") + std::strerror(errno);
    return seen;
  }
  while (gpiod_chip* const chip = gpiod_chip_iter_next_noclose(all)) {
    seen.push_back(describe(chip));
    gpiod_chip_close(chip);
  }
  gpiod_chip_iter_free_noclose(all);
  return seen;
}

std::optional<bool> LibgpiodView::level(const std::string& label, const std::string& name) {
  const Chip chip(gpiod_chip_open_by_label(label.c_str()));
  if (!chip) return std::nullopt;
  gpiod_line* const line = gpiod_chip_find_line(chip.get(), name.c_str());
  if (line == nullptr || gpiod_line_request_input(line, kConsumer) != 0) return std::nullopt;
  const int value = gpiod_line_get_value(line);
  gpiod_line_release(line);
  return value < 0 ? std::nullopt : std::optional<bool>(value != 0);
}

// The line's chip is closed with it.
struct LibgpiodEdges::Watched {
  gpiod_line* line = nullptr;

  explicit Watched(gpiod_line* found) : line(found) {}
  ~Watched() { gpiod_line_close_chip(line); }
  Watched(const Watched&) = delete;
  Watched& operator=(const Watched&) = delete;
};

LibgpiodEdges::LibgpiodEdges() = default;
LibgpiodEdges::~LibgpiodEdges() = default;

std::string LibgpiodEdges::open(const std::string& name) {
  close();
  errno = 0;
  gpiod_line* const line = gpiod_line_find(name.c_str());
  if (line == nullptr) return "no chip has a line '" + name + "'";
  auto watched = std::make_unique<Watched>(line);
  if (gpiod_line_direction(line) == GPIOD_LINE_DIRECTION_OUTPUT || gpiod_line_is_used(line)) {
    return "'" + name + "' is in use, or an output";
  }
  if (gpiod_line_request_rising_edge_events(line, kConsumer) != 0) {
    return "'" + name + "' gives no edges: " + std::strerror(errno);
  }
  watched_ = std::move(watched);
  return "";
}

void LibgpiodEdges::close() {
  watched_.reset();
}

void LibgpiodEdges::collect(std::vector<std::int64_t>& rising_ns) {
  constexpr timespec kNoWait{0, 0};
  while (watched_ && gpiod_line_event_wait(watched_->line, &kNoWait) == 1) {
    gpiod_line_event event{};
    if (gpiod_line_event_read(watched_->line, &event) != 0) return;
    rising_ns.push_back(std::int64_t{event.ts.tv_sec} * 1'000'000'000 + event.ts.tv_nsec);
  }
}

}  // namespace vergence::tools
