// Reads and writes objects of one node [CiA 301, 7.2.4]: expedited up to four bytes, in segments beyond. One
// transfer at a time, which ends by an answer, an abort or a timeout; nothing waits.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "hal/canopen/can_bus.hpp"
#include "hal/canopen/sdo_abort.hpp"

namespace vergence::canopen {

inline constexpr std::size_t kMaxSdoBytes = 128;  // of one object

enum class SdoState : std::uint8_t {
  kIdle,
  kBusy,
  kDone,
  kAborted,  // abort_code() says why
};

class SdoClient {
 public:
  // The timeout is that of one answer.
  void init(std::uint8_t node_id, std::int64_t timeout_ns);

  // False, and nothing happens, while a transfer is busy, and where there is nothing to write or too much.
  [[nodiscard]] bool write(std::uint16_t index, std::uint8_t sub, std::span<const std::uint8_t> bytes,
                           std::int64_t now_ns);
  [[nodiscard]] bool read(std::uint16_t index, std::uint8_t sub, std::int64_t now_ns);

  // Frames of other nodes, and answers about another object than the one asked for, are ignored: they come
  // late, from a transfer that timed out.
  void receive(const CanFrame& frame, std::int64_t now_ns);
  // Sends what is to be sent, and what was refused again; notices that an answer is overdue.
  void process(std::int64_t now_ns, const FrameSink& sink);

  [[nodiscard]] SdoState state() const { return state_; }
  [[nodiscard]] std::uint32_t abort_code() const { return abort_code_; }
  // What was read, until the next transfer.
  [[nodiscard]] std::span<const std::uint8_t> bytes() const { return std::span(bytes_).first(size_); }

 private:
  enum class Phase : std::uint8_t {
    kInitWrite,
    kWriteSegment,
    kInitRead,
    kReadSegment
  };

  void begin(Phase phase, std::uint16_t index, std::uint8_t sub, std::int64_t now_ns);
  void ask(std::uint8_t command, std::int64_t now_ns);  // a request, all of it zero behind the command
  void put_object();
  void put_segment(std::int64_t now_ns);
  void on_read_started(const CanFrame& frame, std::int64_t now_ns);
  void on_read_segment(const CanFrame& frame, std::int64_t now_ns);
  void finish();
  void abort(std::uint32_t code);
  [[nodiscard]] bool is_about_object(const CanFrame& frame) const;

  std::uint8_t node_id_ = 0;
  std::int64_t timeout_ns_ = 0;
  SdoState state_ = SdoState::kIdle;
  Phase phase_ = Phase::kInitWrite;
  std::uint16_t index_ = 0;
  std::uint8_t sub_ = 0;
  bool toggle_ = false;
  bool last_segment_ = false;
  std::uint32_t abort_code_ = kAbortNone;
  std::array<std::uint8_t, kMaxSdoBytes> bytes_{};
  std::size_t size_ = 0;
  std::size_t moved_ = 0;      // bytes transferred
  std::size_t announced_ = 0;  // bytes a read in segments said it has; 0: it did not say
  CanFrame request_;
  bool to_send_ = false;
  std::int64_t asked_ns_ = 0;
};

}  // namespace vergence::canopen
