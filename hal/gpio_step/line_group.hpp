// Lines of one chip that are requested, set and read together: all that is asked of libgpiod. Versions 1 and
// 2 of it have nothing in common, so each has a file of its own (libgpiod_1_group.cpp, libgpiod_2_group.cpp),
// and the build takes the one of the version that is there.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "hal/gpio_step/lines_config.hpp"

struct gpiod_chip;
struct gpiod_line;
struct gpiod_line_request;

namespace vergence::step {

inline constexpr std::size_t kGroupLines = 6;  // at most
static_assert(kOutputLines <= kGroupLines && kInputLines <= kGroupLines);

// Levels are those of the wires, line i in bit i, inversion or not. Requests and releases may allocate;
// nothing else does.
class LineGroup {
 public:
  LineGroup() = default;
  ~LineGroup() { release(); }
  LineGroup(const LineGroup&) = delete;
  LineGroup& operator=(const LineGroup&) = delete;

  // Lines by their names on the chip of this label or name. After an error nothing is held.
  [[nodiscard]] LinesError request_outputs(const GpioName& chip, std::span<const LineSpec> lines,
                                           std::uint32_t levels) {
    return request(chip, lines, &levels);
  }
  [[nodiscard]] LinesError request_inputs(const GpioName& chip, std::span<const LineSpec> lines) {
    return request(chip, lines, nullptr);
  }
  void release();

  [[nodiscard]] bool is_requested() const { return count_ > 0; }
  [[nodiscard]] bool set(std::uint32_t levels);  // all of them, by one call
  [[nodiscard]] bool get(std::uint32_t& levels);
  // The first line, by any thread, while others do the same.
  [[nodiscard]] bool set_first(bool level);

 private:
  [[nodiscard]] LinesError request(const GpioName& chip, std::span<const LineSpec> lines,
                                   const std::uint32_t* levels) {
    release();
    const LinesError error = take(chip, lines, levels);
    if (error.kind != LinesErrorKind::kNone) release();
    return error;
  }
  // Without levels: as inputs. After an error, release() gives back what there is.
  [[nodiscard]] LinesError take(const GpioName& chip, std::span<const LineSpec> specs,
                                const std::uint32_t* levels);

  // Each version has its own. 1.x: lines belong to an open chip.
  [[maybe_unused]] gpiod_chip* chip_ = nullptr;
  [[maybe_unused]] std::array<gpiod_line*, kGroupLines> lines_{};
  // 2: offsets in a chip belong to a request, which the kernel knows by a file.
  [[maybe_unused]] struct gpiod_line_request* request_ = nullptr;  // 1.x has a function of that name
  [[maybe_unused]] std::array<unsigned, kGroupLines> offsets_{};
  [[maybe_unused]] int file_ = -1;

  std::size_t count_ = 0;  // of requested lines
};

}  // namespace vergence::step
