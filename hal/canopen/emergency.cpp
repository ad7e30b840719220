#include "hal/canopen/emergency.hpp"

#include "hal/canopen/bytes.hpp"
#include "hal/canopen/nmt.hpp"

namespace vergence::canopen {
namespace {

struct Words {
  std::uint16_t code;
  std::uint16_t mask;
  const char* words;
};

// The first row that fits counts: single codes, then ever wider classes.
constexpr Words kWords[] = {
    {0x0000, 0xFF00, "error reset, or no error"},
    {kEmergencyFollowingError, 0xFFFF, "following error"},
    {0x8110, 0xFFFF, "CAN overrun: messages lost"},
    {0x8120, 0xFFFF, "CAN in error passive mode"},
    {kEmergencyHeartbeat, 0xFFFF, "heartbeat of the master missing"},
    {0x8140, 0xFFFF, "recovered from bus off"},
    {0x8150, 0xFFFF, "two nodes send with one identifier"},
    {0x8210, 0xFFFF, "PDO not processed: wrong length"},
    {0x8220, 0xFFFF, "PDO longer than its mapping"},
    {0x7305, 0xFFFF, "incremental encoder 1 at fault"},
    {0x3210, 0xFFFF, "DC link: overvoltage"},
    {0x3220, 0xFFFF, "DC link: undervoltage"},
    {0x4310, 0xFFFF, "drive too hot"},
    {0x2100, 0xFF00, "current at the device's input"},
    {0x2200, 0xFF00, "current inside the device"},
    {0x2300, 0xFF00, "current at the device's output: short circuit, earth leakage or overload"},
    {0x2000, 0xF000, "current"},
    {0x3100, 0xFF00, "mains voltage"},
    {0x3200, 0xFF00, "voltage inside the device"},
    {0x3300, 0xFF00, "output voltage"},
    {0x3000, 0xF000, "voltage"},
    {0x4100, 0xFF00, "ambient temperature"},
    {0x4200, 0xFF00, "device temperature"},
    {0x4000, 0xF000, "temperature"},
    {0x5000, 0xF000, "device hardware"},
    {0x6100, 0xFF00, "software of the device"},
    {0x6200, 0xFF00, "user software"},
    {0x6300, 0xFF00, "data set of the device"},
    {0x6000, 0xF000, "device software"},
    {0x7100, 0xFF00, "power module: brake, motor blocked or commutation"},
    {0x7300, 0xFF00, "sensor"},
    {0x7000, 0xF000, "additional modules"},
    {0x8100, 0xFF00, "communication"},
    {0x8200, 0xFF00, "protocol error"},
    {0x8300, 0xFF00, "torque control"},
    {0x8400, 0xFF00, "velocity control"},
    {0x8500, 0xFF00, "position control"},
    {0x8600, 0xFF00, "positioning controller"},
    {kEmergencySync, 0xFF00, "SYNC missing or out of step"},
    {0x8000, 0xF000, "monitoring"},
    {0x9000, 0xF000, "external error"},
    {0xF000, 0xFF00, "additional functions"},
    {0xFF00, 0xFF00, "device specific"},
    {0x1000, 0xF000, "generic error"},
};

}  // namespace

bool decode_emergency(const CanFrame& frame, std::uint8_t node_id, Emergency& emergency) {
  if (frame.id != kEmergencyCobId + node_id || frame.size != 8 || frame.is_remote || frame.is_error) {
    return false;
  }
  emergency.code = static_cast<std::uint16_t>(get_number(frame.data, 2));
  emergency.error_register = frame.data[2];
  for (std::size_t i = 0; i < 5; ++i) emergency.manufacturer[i] = frame.data[3 + i];
  return true;
}

CanFrame emergency_frame(std::uint8_t node_id, const Emergency& emergency) {
  CanFrame frame;
  frame.id = kEmergencyCobId + node_id;
  frame.size = 8;
  put_number(frame.data, 2, emergency.code);
  frame.data[2] = emergency.error_register;
  for (std::size_t i = 0; i < 5; ++i) frame.data[3 + i] = emergency.manufacturer[i];
  return frame;
}

const char* describe_emergency(std::uint16_t code) {
  for (const Words& row : kWords) {
    if ((code & row.mask) == row.code) return row.words;
  }
  return "a code that is not in CiA 301";
}

}  // namespace vergence::canopen
