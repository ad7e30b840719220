// The object dictionary of a simulated drive: what can be read and written, and what the standard refuses.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "hal/canopen/pdo.hpp"
#include "hal/canopen/sdo_abort.hpp"

namespace vergence::canopen {

class DriveObjects {
 public:
  static constexpr std::size_t kMaxObjects = 96;
  static constexpr std::size_t kMaxBytes = 40;  // of one object
  static constexpr std::size_t kMaxRefusals = 8;
  static constexpr std::uint8_t kMappablePdos = 2;  // each way, from number 1

  // With the standard's values for this node.
  void init(std::uint8_t node_id, std::uint32_t vendor_id);
  // Back to those, as a reset of communication does; identity and refusals stay.
  void reset();

  // An abort code, or kAbortNone.
  [[nodiscard]] std::uint32_t read(std::uint16_t index, std::uint8_t sub,
                                   std::span<const std::uint8_t>& bytes) const;
  [[nodiscard]] std::uint32_t write(std::uint16_t index, std::uint8_t sub,
                                    std::span<const std::uint8_t> bytes);

  // For the drive itself, without checks. An object that is not there counts as zero.
  [[nodiscard]] std::uint32_t number(std::uint16_t index, std::uint8_t sub) const;
  [[nodiscard]] std::size_t size(std::uint16_t index, std::uint8_t sub) const;
  void set(std::uint16_t index, std::uint8_t sub, std::uint32_t value);

  // From now on every access to it is aborted with this code.
  void refuse(std::uint16_t index, std::uint8_t sub, std::uint32_t code);

 private:
  enum class Access : std::uint8_t {
    kRead,
    kWrite,
    kBoth
  };
  struct Object {
    std::uint16_t index = 0;
    std::uint8_t sub = 0;
    Access access = Access::kRead;
    std::uint8_t size = 0;
    std::uint8_t most = 0;  // bytes a value of variable length may have; 0: its length is fixed
    std::array<std::uint8_t, kMaxBytes> bytes{};
  };
  struct Refusal {
    std::uint16_t index = 0;
    std::uint8_t sub = 0;
    std::uint32_t code = kAbortNone;
  };

  void add(std::uint16_t index, std::uint8_t sub, Access access, std::uint8_t size, std::uint32_t value);
  void add_text(std::uint16_t index, Access access, const char* text);
  void add_pdo(PdoDirection direction, std::uint8_t number);
  [[nodiscard]] const Object* find(std::uint16_t index, std::uint8_t sub) const;
  [[nodiscard]] std::uint32_t missing(std::uint16_t index) const;
  [[nodiscard]] std::uint32_t refusal(std::uint16_t index, std::uint8_t sub) const;
  [[nodiscard]] std::uint32_t judge(std::uint16_t index, std::uint8_t sub, std::uint32_t value) const;
  [[nodiscard]] std::uint32_t judge_mapping(std::uint16_t index, std::uint8_t sub, std::uint32_t value) const;

  std::uint8_t node_id_ = 0;
  std::uint32_t vendor_id_ = 0;
  std::array<Object, kMaxObjects> objects_{};
  std::size_t count_ = 0;
  std::array<Refusal, kMaxRefusals> refusals_{};
  std::size_t refusal_count_ = 0;
};

}  // namespace vergence::canopen
