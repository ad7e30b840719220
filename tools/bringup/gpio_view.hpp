// GPIO chips as a bystander sees them: what is there and who uses it, without taking or changing a line; the
// levels of inputs; and the edges of one input. An interface, so that all of it can be tested without chips.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace vergence::tools {

struct GpioLine {
  std::string name;
  bool is_output = false;
  bool is_used = false;
  std::string consumer;  // who uses it
};

struct GpioChip {
  std::string device;
  std::string label;
  std::vector<GpioLine> lines;
};

class GpioView {
 public:
  // All of them. `problem` says why there may be more than can be seen.
  [[nodiscard]] virtual std::vector<GpioChip> chips(std::string& problem) = 0;
  // The level of a line that is an input already; nothing where it cannot be had.
  [[nodiscard]] virtual std::optional<bool> level(const std::string& label, const std::string& line) = 0;

 protected:
  ~GpioView() = default;
};

// Rising edges of one input, as the kernel stamps them.
class EdgeWatch {
 public:
  // Those since the last call are added. To be called often: the kernel keeps 16.
  virtual void collect(std::vector<std::int64_t>& rising_ns) = 0;

 protected:
  ~EdgeWatch() = default;
};

}  // namespace vergence::tools
