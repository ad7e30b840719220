// Operators' commands on their way to the arm's task, from any other thread. Nothing is lost: of several the
// last counts, but a stop outlasts any other until it was taken.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>

#include "firmware_like/messages.hpp"

namespace vergence {

class OperatorChannel {
 public:
  void put(OperatorCommand command) {
    if (command == OperatorCommand::kStop) {
      stop_.store(true, std::memory_order_release);
    } else {
      command_.store(static_cast<std::uint32_t>(command) + 1, std::memory_order_release);
    }
  }
  // The arm's task, once a period.
  [[nodiscard]] std::optional<OperatorCommand> take() {
    const std::uint32_t command = command_.exchange(0, std::memory_order_acq_rel);
    if (stop_.exchange(false, std::memory_order_acq_rel)) return OperatorCommand::kStop;
    if (command == 0) return std::nullopt;
    return static_cast<OperatorCommand>(command - 1);
  }

 private:
  std::atomic<std::uint32_t> command_{0};
  std::atomic<bool> stop_{false};
};

}  // namespace vergence
