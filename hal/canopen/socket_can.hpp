// A CAN interface of Linux (SocketCAN), the only file here that knows the operating system: a raw socket that
// does not wait, with filters, error frames, times of reception and a count of what was lost.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "hal/canopen/can_bus.hpp"
#include "hal/canopen/restart_policy.hpp"

namespace vergence::canopen {

enum class SocketStep : std::uint8_t {
  kOk,
  kName,  // the interface's name is empty or too long
  kSocket,
  kInterface,
  kFilter,
  kErrorFilter,
  kOverflowCount,
  kTimestamps,
  kBind,
};
[[nodiscard]] const char* describe(SocketStep step);

// Satisfies CanBusOfMany. All calls but open() are free of allocation and never wait. Frames are taken from
// the kernel, and given to it, several in a call.
class SocketCan {
 public:
  SocketCan() = default;
  ~SocketCan();
  SocketCan(const SocketCan&) = delete;
  SocketCan& operator=(const SocketCan&) = delete;

  // The step that failed, with errno in last_errno(), or kOk. Without filters nothing is received.
  [[nodiscard]] SocketStep open(const char* interface, std::span<const CanFilter> filters);
  void close();

  // Once a period: measures the offset of the kernel's stamps, and restarts a controller that is bus-off.
  // That needs the right to configure the interface (CAP_NET_ADMIN); without it, `restart-ms` of the
  // interface does.
  void process(std::int64_t now_ns);
  // False, and counted, where the kernel's queue is full (ENOBUFS) or the interface is down.
  [[nodiscard]] bool send(const CanFrame& frame) { return send(std::span(&frame, 1)) == 1; }
  // How many were taken, from the first; the others are counted likewise.
  [[nodiscard]] std::size_t send(std::span<const CanFrame> frames);
  // Stamps are in the time of process(). Error frames only go into the health.
  [[nodiscard]] bool receive(CanFrame& frame);

  [[nodiscard]] const CanHealth& health() const { return health_; }
  // Readable where there is something to receive; -1 while closed.
  [[nodiscard]] int handle_to_poll() const { return socket_; }
  [[nodiscard]] bool is_open() const { return socket_ >= 0; }
  [[nodiscard]] int last_errno() const { return errno_; }

 private:
  [[nodiscard]] SocketStep set_up(const char* interface, std::span<const CanFilter> filters);
  [[nodiscard]] bool ask_for_restart();
  void note_failure(int error);
  [[nodiscard]] bool fetch();

  // More than drives answer to a SYNC, in one call of the kernel.
  static constexpr std::size_t kMostAtOnce = 16;
  struct Received {
    CanFrame frame;
    std::uint32_t lost = 0;  // before it, as the kernel counts
  };

  int socket_ = -1;
  int interface_ = 0;
  int errno_ = 0;
  std::int64_t stamp_offset_ns_ = 0;  // from the kernel's time to that of process()
  std::uint32_t lost_by_kernel_ = 0;
  std::array<Received, kMostAtOnce> received_{};  // oldest first
  std::size_t received_count_ = 0;
  std::size_t next_ = 0;       // to be handed out
  bool nothing_more_ = false;  // was there when these were fetched
  CanHealth health_;
  RestartPolicy restart_;
};

static_assert(CanBusOfMany<SocketCan>);

}  // namespace vergence::canopen
