#include "hal/canopen/can_frame.hpp"

namespace vergence::canopen {

CanErrors decode_errors(const CanFrame& frame) {
  CanErrors errors;
  if (!frame.is_error) return errors;
  errors.bus_off = (frame.id & kErrorBusOff) != 0;
  errors.restarted = (frame.id & kErrorRestarted) != 0;
  errors.no_acknowledge = (frame.id & kErrorNoAcknowledge) != 0;
  errors.tx_timeout = (frame.id & kErrorTxTimeout) != 0;
  errors.lost_arbitration = (frame.id & kErrorLostArbitration) != 0;
  errors.transceiver = (frame.id & kErrorTransceiver) != 0;
  errors.protocol = (frame.id & (kErrorProtocol | kErrorBus)) != 0;
  if ((frame.id & kErrorController) != 0 && frame.size > 1) {
    const std::uint8_t controller = frame.data[1];
    errors.rx_overflow = (controller & kControllerRxOverflow) != 0;
    errors.tx_overflow = (controller & kControllerTxOverflow) != 0;
    errors.warning = (controller & kControllerWarning) != 0;
    errors.passive = (controller & kControllerPassive) != 0;
    errors.active = (controller & kControllerActive) != 0;
  }
  return errors;
}

const char* describe(const CanErrors& errors) {
  if (errors.bus_off) return "bus off: the controller has left the bus after too many errors";
  if (errors.restarted) return "the controller is back on the bus";
  if (errors.rx_overflow) return "the controller lost received frames";
  if (errors.tx_overflow) return "the controller lost frames to be sent";
  if (errors.passive) return "error passive: many errors; check termination, bit rate and wiring";
  if (errors.no_acknowledge) return "nobody acknowledges: is any other node powered, at this bit rate?";
  if (errors.transceiver) return "the transceiver reports a wiring fault";
  if (errors.tx_timeout) return "a frame could not be sent in time";
  if (errors.warning) return "the error counters have reached the warning level";
  if (errors.protocol) return "a frame was damaged on the bus";
  if (errors.lost_arbitration) return "arbitration was lost";
  if (errors.active) return "error active: no trouble any more";
  return "no error";
}

}  // namespace vergence::canopen
