// A logic analyser on the GPIO lines: each level that anybody sets, with the kernel's stamp, from the trace
// of the event gpio/gpio_value.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tools/rig/file_handle.hpp"

namespace vergence::rig {

struct Edge {
  std::int64_t stamp_ns = 0;  // of the monotonic clock, to a microsecond
  int line = 0;               // offset in the chip
  bool level = false;
};

// A line of the trace, where it is of a level that was set: `TASK-PID [CPU] FLAGS SECONDS.MICROS: gpio_value:
// NUMBER set LEVEL`. Line numbers are the kernel's, counted from the chip's first.
[[nodiscard]] std::optional<Edge> parse_edge(std::string_view text, int first_number);

struct Capture {
  int minor = 0;  // of the camera's device
  std::int64_t stamp_ns = 0;
};

// `TASK-PID [CPU] FLAGS SECONDS.MICROS: v4l2_dqbuf: minor = MINOR, ... timestamp = NANOSECONDS, ...`
[[nodiscard]] std::optional<Capture> parse_capture(std::string_view text);

// The kernel's number of a chip's first line, from the text of /sys/kernel/debug/gpio.
[[nodiscard]] std::optional<int> first_number_of(std::string_view chips, std::string_view label);

class TraceReader {
 public:
  // Throws RigError where there is no such chip or no trace.
  explicit TraceReader(const char* chip_label);

  // What came since the last call; does not wait. Levels that were set again are left out.
  void read();
  [[nodiscard]] const std::vector<Edge>& edges() const { return edges_; }
  [[nodiscard]] const std::vector<Capture>& captures() const { return captures_; }

 private:
  void take(std::string_view line);

  int first_number_ = 0;
  FileHandle trace_;
  std::string rest_;  // of a line that is not complete
  std::uint64_t levels_ = 0;
  std::vector<Edge> edges_;
  std::vector<Capture> captures_;
};

}  // namespace vergence::rig
