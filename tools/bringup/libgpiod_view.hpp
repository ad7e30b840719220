// The chips of this machine, through libgpiod 1.x.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/bringup/gpio_view.hpp"

struct gpiod_chip;
struct gpiod_line;

namespace vergence::tools {

class LibgpiodView final : public GpioView {
 public:
  std::vector<GpioChip> chips(std::string& problem) override;
  std::optional<bool> level(const std::string& label, const std::string& name) override;
};

class LibgpiodEdges final : public EdgeWatch {
 public:
  LibgpiodEdges() = default;
  ~LibgpiodEdges() { close(); }
  LibgpiodEdges(const LibgpiodEdges&) = delete;
  LibgpiodEdges& operator=(const LibgpiodEdges&) = delete;

  // A line of any chip; it becomes an input. What is wrong, or nothing.
  [[nodiscard]] std::string open(const std::string& name);
  void close();
  void collect(std::vector<std::int64_t>& rising_ns) override;

 private:
  gpiod_line* line_ = nullptr;
};

}  // namespace vergence::tools
