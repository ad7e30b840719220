// The buffers of one stream: who has each of them, and where its picture is.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "algo/image.hpp"
#include "hal/v4l2/negotiation.hpp"

namespace vergence::v4l2 {

struct DequeuedBuffer {
  int index = -1;
  std::uint32_t sequence = 0;
  bool is_flagged = false;  // the driver says that the picture may be damaged
  bool is_whole = false;    // it has all bytes of a picture; only then is `image` valid
  bool has_monotonic_stamp = false;
  std::int64_t stamp_ns = 0;  // the driver's
  ImageView image;
};

class BufferRing {
 public:
  // From the driver, or from us: as many as the driver grants of `wanted`, at least kMinVideoBuffers. After
  // an error nothing is held.
  [[nodiscard]] VideoError allocate(VideoSystem& system, int handle, const StreamFormat& format,
                                    BufferMemory memory, int wanted);
  // Nobody may look at a picture any more: held() is 0.
  void release();

  // Gives the driver every buffer that nobody holds, and lets it begin.
  [[nodiscard]] VideoError start();
  // Takes back what the driver has; what is held stays held and readable.
  void stop();

  // 0, EAGAIN where none is ready, EBADMSG where the answer makes no sense, or what the driver says. The
  // buffer is held until give_back().
  [[nodiscard]] int dequeue(DequeuedBuffer& got);
  // 0, or what the driver says; a buffer it refused lies idle until the next start().
  [[nodiscard]] int give_back(int index);

  [[nodiscard]] int count() const { return count_; }
  [[nodiscard]] int held() const;    // by us
  [[nodiscard]] int queued() const;  // with the driver

 private:
  enum class Owner : std::uint8_t {
    kIdle,
    kDriver,
    kUser,
  };
  struct Plane {
    std::uint8_t* memory = nullptr;
    std::size_t bytes = 0;
    int exported = -1;  // handle of the DMA-BUF
  };
  struct Buffer {
    Owner owner = Owner::kIdle;
    std::array<Plane, kMaxVideoPlanes> planes{};
  };
  struct Message;

  [[nodiscard]] VideoError request(std::uint32_t wanted, std::uint32_t& granted);
  [[nodiscard]] VideoError prepare(int index);
  [[nodiscard]] VideoError prepare_plane(int index, int number, std::size_t bytes, std::int64_t offset);
  [[nodiscard]] int queue(int index);
  [[nodiscard]] int sync(int index, std::uint64_t flags);
  [[nodiscard]] int owned_by(Owner owner) const;
  void locate(const Message& message, DequeuedBuffer& got) const;

  VideoSystem* system_ = nullptr;
  int handle_ = -1;
  StreamFormat format_;
  BufferMemory memory_ = BufferMemory::kMapped;
  std::array<Buffer, kMaxVideoBuffers> buffers_{};
  int count_ = 0;
  bool is_streaming_ = false;
};

}  // namespace vergence::v4l2
