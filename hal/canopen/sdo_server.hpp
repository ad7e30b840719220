// The drive's side of SDO [CiA 301, 7.2.4]: answers one client, one transfer at a time.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "hal/canopen/can_frame.hpp"
#include "hal/canopen/drive_objects.hpp"

namespace vergence::canopen {

class SdoServer {
 public:
  void init(std::uint8_t node_id);

  // False where the frame is no request to this node, or needs no answer. `written` becomes the index of an
  // object whose new value is complete, else 0.
  [[nodiscard]] bool receive(const CanFrame& request, DriveObjects& objects, CanFrame& answer,
                             std::uint16_t& written);

 private:
  enum class Transfer : std::uint8_t {
    kNone,
    kWrite,
    kRead
  };

  void start_write(const CanFrame& request, DriveObjects& objects, CanFrame& answer, std::uint16_t& written);
  void write_segment(const CanFrame& request, DriveObjects& objects, CanFrame& answer,
                     std::uint16_t& written);
  void start_read(const DriveObjects& objects, CanFrame& answer);
  void read_segment(const CanFrame& request, CanFrame& answer);
  void put_object(CanFrame& answer) const;
  void abort(std::uint32_t code, CanFrame& answer);

  std::uint8_t node_id_ = 0;
  Transfer transfer_ = Transfer::kNone;
  std::uint16_t index_ = 0;
  std::uint8_t sub_ = 0;
  bool toggle_ = false;
  std::array<std::uint8_t, DriveObjects::kMaxBytes> bytes_{};
  std::size_t size_ = 0;
  std::size_t moved_ = 0;
};

}  // namespace vergence::canopen
