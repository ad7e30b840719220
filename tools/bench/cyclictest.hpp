// cyclictest, of the kernel developers' rt-tests: the yardstick for wake-ups.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>

#include "hal/rt/duration_histogram.hpp"
#include "tools/bench/child_process.hpp"

namespace vergence::tools {

struct CyclictestOptions {
  std::int64_t interval_ns = 0;
  int seconds = 1;
  int priority = 1;  // of SCHED_FIFO; without the right to that it does not run at all
  int core = -1;     // negative: any
};

// One thread of it, running from construction to result().
class Cyclictest {
 public:
  // Its results go to the file, which result() removes.
  Cyclictest(const CyclictestOptions& options, const std::filesystem::path& file);

  // Waits for it. Nothing where it failed.
  [[nodiscard]] std::optional<rt::DurationHistogram> result();

 private:
  std::filesystem::path file_;
  ChildProcess process_;
};

}  // namespace vergence::tools
