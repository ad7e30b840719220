// The chips of this machine, through libgpiod 1.x (libgpiod_1_view.cpp) or 2 (libgpiod_2_view.cpp).
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tools/bringup/gpio_view.hpp"

namespace vergence::tools {

class LibgpiodView final : public GpioView {
 public:
  std::vector<GpioChip> chips(std::string& problem) override;
  std::optional<bool> level(const std::string& label, const std::string& name) override;
};

class LibgpiodEdges final : public EdgeWatch {
 public:
  LibgpiodEdges();
  ~LibgpiodEdges();
  LibgpiodEdges(const LibgpiodEdges&) = delete;
  LibgpiodEdges& operator=(const LibgpiodEdges&) = delete;

  // A line of any chip; it becomes an input. What is wrong, or nothing.
  [[nodiscard]] std::string open(const std::string& name);
  void close();
  void collect(std::vector<std::int64_t>& rising_ns) override;

 private:
  struct Watched;  // as the version of the library has it
  std::unique_ptr<Watched> watched_;
};

}  // namespace vergence::tools
