// A bus that keeps what is sent, and refuses it when told to.
#pragma once

#include <initializer_list>
#include <vector>

#include "hal/canopen/can_bus.hpp"

namespace vergence::testing {

inline canopen::CanFrame can_frame(std::uint32_t id, std::initializer_list<int> bytes) {
  canopen::CanFrame frame;
  frame.id = id;
  for (const int byte : bytes) frame.data[frame.size++] = static_cast<std::uint8_t>(byte);
  return frame;
}

struct CanRecorder {
  void process(std::int64_t) {}
  bool send(const canopen::CanFrame& frame) {
    if (is_full) return false;
    sent.push_back(frame);
    return true;
  }
  bool receive(canopen::CanFrame&) { return false; }
  [[nodiscard]] const canopen::CanHealth& health() const { return its_health; }

  // The only frame since the last call; none or several are no frame.
  canopen::CanFrame take() {
    const canopen::CanFrame frame = sent.size() == 1 ? sent[0] : canopen::CanFrame{};
    sent.clear();
    return frame;
  }

  std::vector<canopen::CanFrame> sent;
  bool is_full = false;
  canopen::CanHealth its_health;
};

}  // namespace vergence::testing
