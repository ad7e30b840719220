#include "hal/canopen/drive_objects.hpp"

#include <algorithm>
#include <cstring>

#include "hal/canopen/bytes.hpp"
#include "hal/canopen/objects.hpp"

namespace vergence::canopen {
namespace {

bool is_mapping(std::uint16_t index) {
  return (index >= kRpdoMapping && index < kRpdoMapping + kPdos) ||
         (index >= kTpdoMapping && index < kTpdoMapping + kPdos);
}

bool is_rpdo_mapping(std::uint16_t index) {
  return index >= kRpdoMapping && index < kRpdoMapping + kPdos;
}

// Of an entry that only skips bytes; 0: it is none.
std::size_t dummy_bytes(std::uint16_t index, std::uint8_t sub) {
  if (sub != 0) return 0;
  switch (index) {
    case kDummyUnsigned8: return 1;
    case kDummyUnsigned16: return 2;
    case kDummyUnsigned32: return 4;
    default: return 0;
  }
}

}  // namespace

void DriveObjects::init(std::uint8_t node_id, std::uint32_t vendor_id) {
  *this = {};
  node_id_ = node_id;
  vendor_id_ = vendor_id;
  reset();
}

void DriveObjects::reset() {
  count_ = 0;
  add(kDeviceType, 0, Access::kRead, 4, 0x00020000 | kDriveProfile);  // a servo drive
  add(kErrorRegister, 0, Access::kRead, 1, 0);
  add(kCyclePeriod, 0, Access::kBoth, 4, 0);
  add_text(kDeviceName, Access::kRead, "simulated CiA 402 drive");
  add(kHeartbeatConsumer, 0, Access::kRead, 1, 1);
  add(kHeartbeatConsumer, 1, Access::kBoth, 4, 0);
  add(kHeartbeatProducer, 0, Access::kBoth, 2, 0);
  add(kIdentity, 0, Access::kRead, 1, 1);
  add(kIdentity, 1, Access::kRead, 4, vendor_id_);
  for (std::uint8_t number = 1; number <= kPdos; ++number) {
    add_pdo(PdoDirection::kToDrive, number);
    add_pdo(PdoDirection::kFromDrive, number);
  }
  add_text(0x2000, Access::kBoth, "a note, as long as it likes");
  add(kAbortConnectionOption, 0, Access::kBoth, 2, 1);
  add(kControlword, 0, Access::kBoth, 2, 0);
  add(kStatusword, 0, Access::kRead, 2, 0);
  add(kQuickStopOption, 0, Access::kBoth, 2, 2);
  add(kModeOfOperation, 0, Access::kBoth, 1, 0);
  add(kModeDisplay, 0, Access::kRead, 1, 0);
  add(kPositionActual, 0, Access::kRead, 4, 0);
  add(kFollowingErrorWindow, 0, Access::kBoth, 4, 0xFFFFFFFF);
  add(kFollowingErrorTime, 0, Access::kBoth, 2, 0);
  add(kVelocityActual, 0, Access::kRead, 4, 0);
  add(kTargetPosition, 0, Access::kBoth, 4, 0);
  add(kQuickStopDeceleration, 0, Access::kBoth, 4, 1'000'000);
  add(kInterpolationPeriod, 1, Access::kBoth, 1, 1);
  add(kInterpolationPeriod, 2, Access::kBoth, 1, 0xFD);
  add(kTargetVelocity, 0, Access::kBoth, 4, 0);
}

void DriveObjects::add(std::uint16_t index, std::uint8_t sub, Access access, std::uint8_t size,
                       std::uint32_t value) {
  if (count_ == kMaxObjects) return;
  Object object{index, sub, access, size, 0, {}};
  put_number(object.bytes, size, value);
  objects_[count_++] = object;
}

void DriveObjects::add_text(std::uint16_t index, Access access, const char* text) {
  if (count_ == kMaxObjects) return;
  const std::size_t length = std::min(std::strlen(text), kMaxBytes);
  Object object{index, 0, access, static_cast<std::uint8_t>(length), kMaxBytes, {}};
  std::copy_n(text, length, object.bytes.begin());
  objects_[count_++] = object;
}

// Communication and mapping, at first of controlword or statusword, and in PDO 2 of the mode as well; PDOs
// beyond can only be switched off.
void DriveObjects::add_pdo(PdoDirection direction, std::uint8_t number) {
  const bool to_drive = direction == PdoDirection::kToDrive;
  const auto communication =
      static_cast<std::uint16_t>((to_drive ? kRpdoCommunication : kTpdoCommunication) + number - 1);
  const std::uint32_t cob_id = default_pdo_cob_id(direction, number, node_id_);
  add(communication, 1, Access::kBoth, 4, to_drive ? cob_id : cob_id | kPdoNoRemote);
  if (number > kMappablePdos) return;
  add(communication, 2, Access::kBoth, 1, kOnEvent);
  if (!to_drive) {
    add(communication, kPdoInhibitSub, Access::kBoth, 2, 0);
    add(communication, kPdoTimerSub, Access::kBoth, 2, 0);
  }
  const auto mapping = static_cast<std::uint16_t>(communication + 0x200);
  const std::uint32_t word = to_drive ? kControlword : kStatusword;
  const std::uint32_t mode = to_drive ? kModeOfOperation : kModeDisplay;
  add(mapping, 0, Access::kBoth, 1, number);
  add(mapping, 1, Access::kBoth, 4, word << 16 | 16);
  add(mapping, 2, Access::kBoth, 4, number == 2 ? mode << 16 | 8 : 0);
  for (std::uint8_t sub = 3; sub <= kMaxPdoEntries; ++sub) add(mapping, sub, Access::kBoth, 4, 0);
}

const DriveObjects::Object* DriveObjects::find(std::uint16_t index, std::uint8_t sub) const {
  for (std::size_t i = 0; i < count_; ++i) {
    if (objects_[i].index == index && objects_[i].sub == sub) return &objects_[i];
  }
  return nullptr;
}

std::uint32_t DriveObjects::missing(std::uint16_t index) const {
  for (std::size_t i = 0; i < count_; ++i) {
    if (objects_[i].index == index) return kAbortNoSubIndex;
  }
  return kAbortNoObject;
}

std::uint32_t DriveObjects::refusal(std::uint16_t index, std::uint8_t sub) const {
  for (std::size_t i = 0; i < refusal_count_; ++i) {
    if (refusals_[i].index == index && refusals_[i].sub == sub) return refusals_[i].code;
  }
  return kAbortNone;
}

std::uint32_t DriveObjects::read(std::uint16_t index, std::uint8_t sub,
                                 std::span<const std::uint8_t>& bytes) const {
  if (const std::uint32_t code = refusal(index, sub); code != kAbortNone) return code;
  const Object* object = find(index, sub);
  if (object == nullptr) return missing(index);
  if (object->access == Access::kWrite) return kAbortWriteOnly;
  bytes = std::span(object->bytes).first(object->size);
  return kAbortNone;
}

std::uint32_t DriveObjects::judge_mapping(std::uint16_t index, std::uint8_t sub, std::uint32_t value) const {
  const auto communication = static_cast<std::uint16_t>(index - 0x200);
  if ((number(communication, 1) & kPdoOff) == 0) return kAbortDeviceState;
  if (sub == 0) {
    std::uint32_t bits = 0;
    for (std::uint32_t i = 1; i <= value && i <= kMaxPdoEntries; ++i) {
      bits += number(index, static_cast<std::uint8_t>(i)) & 0xFF;
    }
    return value <= kMaxPdoEntries && bits <= 64 ? kAbortNone : kAbortPdoLength;
  }
  if (number(index, 0) != 0) return kAbortAccess;
  const auto object = static_cast<std::uint16_t>(value >> 16);
  const auto object_sub = static_cast<std::uint8_t>(value >> 8);
  const std::size_t skipped = is_rpdo_mapping(index) ? dummy_bytes(object, object_sub) : 0;
  const std::size_t mapped = skipped > 0 ? skipped : size(object, object_sub);
  return mapped > 0 && mapped <= 4 && mapped * 8 == (value & 0xFF) ? kAbortNone : kAbortNotMappable;
}

std::uint32_t DriveObjects::judge(std::uint16_t index, std::uint8_t sub, std::uint32_t value) const {
  if (is_mapping(index)) return judge_mapping(index, sub, value);
  const bool is_tpdo = index >= kTpdoCommunication && index < kTpdoCommunication + kPdos;
  if (is_tpdo && sub == kPdoInhibitSub && (number(index, 1) & kPdoOff) == 0) return kAbortDeviceState;
  if (index == kModeOfOperation && value != kModeHoming && value != kModeCyclicPosition &&
      value != kModeCyclicVelocity) {
    return kAbortValue;
  }
  return kAbortNone;
}

std::uint32_t DriveObjects::write(std::uint16_t index, std::uint8_t sub,
                                  std::span<const std::uint8_t> bytes) {
  if (const std::uint32_t code = refusal(index, sub); code != kAbortNone) return code;
  const Object* object = find(index, sub);
  if (object == nullptr) return missing(index);
  if (object->access == Access::kRead) return kAbortReadOnly;
  const std::size_t most = object->most != 0 ? object->most : object->size;
  if (bytes.size() > most) return kAbortTooLong;
  if (object->most == 0 && bytes.size() < most) return kAbortTooShort;
  if (object->most == 0) {
    const std::uint32_t code = judge(index, sub, get_number(bytes, bytes.size()));
    if (code != kAbortNone) return code;
  }
  Object& own = objects_[static_cast<std::size_t>(object - objects_.data())];
  std::copy(bytes.begin(), bytes.end(), own.bytes.begin());
  own.size = static_cast<std::uint8_t>(bytes.size());
  return kAbortNone;
}

std::uint32_t DriveObjects::number(std::uint16_t index, std::uint8_t sub) const {
  const Object* object = find(index, sub);
  return object == nullptr ? 0 : get_number(object->bytes, object->size);
}

std::size_t DriveObjects::size(std::uint16_t index, std::uint8_t sub) const {
  const Object* object = find(index, sub);
  return object == nullptr ? 0 : object->size;
}

void DriveObjects::set(std::uint16_t index, std::uint8_t sub, std::uint32_t value) {
  const Object* object = find(index, sub);
  if (object == nullptr) return;
  put_number(objects_[static_cast<std::size_t>(object - objects_.data())].bytes, object->size, value);
}

void DriveObjects::refuse(std::uint16_t index, std::uint8_t sub, std::uint32_t code) {
  if (refusal_count_ < kMaxRefusals) refusals_[refusal_count_++] = {index, sub, code};
}

}  // namespace vergence::canopen
