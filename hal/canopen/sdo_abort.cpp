#include "hal/canopen/sdo_abort.hpp"

namespace vergence::canopen {

const char* describe_abort(std::uint32_t code) {
  switch (code) {
    case kAbortNone: return "no abort";
    case kAbortToggle: return "toggle bit not alternated";
    case kAbortTimeout: return "no answer in time";
    case kAbortCommand: return "command specifier not valid or unknown";
    case 0x05040002: return "invalid block size";
    case 0x05040003: return "invalid sequence number";
    case 0x05040004: return "CRC error";
    case kAbortMemory: return "out of memory";
    case kAbortAccess: return "unsupported access to an object";
    case kAbortWriteOnly: return "attempt to read a write-only object";
    case kAbortReadOnly: return "attempt to write a read-only object";
    case kAbortNoObject: return "object does not exist";
    case kAbortNotMappable: return "object cannot be mapped to a PDO";
    case kAbortPdoLength: return "mapped objects exceed the length of a PDO";
    case 0x06040043: return "parameter incompatible";
    case 0x06040047: return "incompatible inside the device";
    case 0x06060000: return "access failed because of the hardware";
    case kAbortLength: return "length of the value does not match the object";
    case kAbortTooLong: return "value too long for the object";
    case kAbortTooShort: return "value too short for the object";
    case kAbortNoSubIndex: return "sub-index does not exist";
    case kAbortValue: return "value outside the range of the object";
    case 0x06090031: return "value too high";
    case 0x06090032: return "value too low";
    case 0x06090036: return "maximum is less than minimum";
    case 0x060A0023: return "resource not available";
    case kAbortGeneral: return "general error";
    case 0x08000020: return "value cannot be transferred or stored";
    case 0x08000021: return "value cannot be stored: the device is under local control";
    case kAbortDeviceState: return "value cannot be stored in the device's present state";
    case 0x08000023: return "no object dictionary";
    case 0x08000024: return "no data available";
    default: return "a code that is not in CiA 301";
  }
}

}  // namespace vergence::canopen
