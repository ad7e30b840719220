#include "hal/canopen/drive_state.hpp"

namespace vergence::canopen {

DriveState decode_state(std::uint16_t statusword) {
  // Bits 0 to 3, 5 and 6. Bit 5 counts in some states only, which have two rows for the others.
  switch (statusword & 0x6F) {
    case 0x00:
    case 0x20: return DriveState::kNotReady;
    case 0x40:
    case 0x60: return DriveState::kSwitchOnDisabled;
    case 0x21: return DriveState::kReadyToSwitchOn;
    case 0x23: return DriveState::kSwitchedOn;
    case 0x27: return DriveState::kOperationEnabled;
    case 0x07: return DriveState::kQuickStopActive;
    case 0x0F:
    case 0x2F: return DriveState::kFaultReaction;
    case 0x08:
    case 0x28: return DriveState::kFault;
    default: return DriveState::kUnknown;
  }
}

std::uint16_t state_bits(DriveState state) {
  switch (state) {
    case DriveState::kNotReady: return 0x00;
    case DriveState::kSwitchOnDisabled: return 0x40;
    case DriveState::kReadyToSwitchOn: return 0x21;
    case DriveState::kSwitchedOn: return 0x23;
    case DriveState::kOperationEnabled: return 0x27;
    case DriveState::kQuickStopActive: return 0x07;
    case DriveState::kFaultReaction: return 0x0F;
    case DriveState::kFault: return 0x08;
    case DriveState::kUnknown: return 0x6F;
  }
  return 0x6F;
}

const char* describe(DriveState state) {
  switch (state) {
    case DriveState::kNotReady: return "not ready to switch on";
    case DriveState::kSwitchOnDisabled: return "switch on disabled";
    case DriveState::kReadyToSwitchOn: return "ready to switch on";
    case DriveState::kSwitchedOn: return "switched on";
    case DriveState::kOperationEnabled: return "operation enabled";
    case DriveState::kQuickStopActive: return "quick stop active";
    case DriveState::kFaultReaction: return "fault reaction active";
    case DriveState::kFault: return "fault";
    case DriveState::kUnknown: return "no state of CiA 402";
  }
  return "no state of CiA 402";
}

std::uint16_t controlword(DriveCommand command) {
  switch (command) {
    case DriveCommand::kNone:
    case DriveCommand::kDisableVoltage: return 0x0000;
    case DriveCommand::kShutdown: return 0x0006;
    case DriveCommand::kSwitchOn: return 0x0007;
    case DriveCommand::kEnableOperation: return 0x000F;
    case DriveCommand::kQuickStop: return 0x0002;
    case DriveCommand::kFaultReset: return 0x0080;
  }
  return 0x0000;
}

DriveCommand decode_command(std::uint16_t controlword, std::uint16_t before) {
  constexpr std::uint16_t kReset = 0x80;
  if ((controlword & kReset) != 0) {
    return (before & kReset) == 0 ? DriveCommand::kFaultReset : DriveCommand::kNone;
  }
  if ((controlword & 0x02) == 0) return DriveCommand::kDisableVoltage;
  if ((controlword & 0x04) == 0) return DriveCommand::kQuickStop;
  if ((controlword & 0x01) == 0) return DriveCommand::kShutdown;
  return (controlword & 0x08) == 0 ? DriveCommand::kSwitchOn : DriveCommand::kEnableOperation;
}

DriveState next_state(DriveState state, DriveCommand command) {
  for (const DriveTransition& transition : kDriveTransitions) {
    if (transition.from == state && transition.command == command) return transition.to;
  }
  return state;
}

DriveCommand command_towards(DriveGoal goal, DriveState state, DriveCommand before) {
  switch (goal) {
    case DriveGoal::kOff: return DriveCommand::kDisableVoltage;
    case DriveGoal::kQuickStop: return DriveCommand::kQuickStop;
    case DriveGoal::kReset:
      if (state == DriveState::kFault && before != DriveCommand::kFaultReset)
        return DriveCommand::kFaultReset;
      return DriveCommand::kDisableVoltage;
    case DriveGoal::kOn: break;
  }
  switch (state) {
    case DriveState::kSwitchOnDisabled: return DriveCommand::kShutdown;
    case DriveState::kReadyToSwitchOn: return DriveCommand::kSwitchOn;
    case DriveState::kSwitchedOn:
    case DriveState::kOperationEnabled: return DriveCommand::kEnableOperation;
    default: return DriveCommand::kDisableVoltage;
  }
}

HomingState decode_homing(std::uint16_t statusword) {
  switch (statusword & 0x3400) {
    case 0x0000: return HomingState::kInProgress;
    case 0x0400: return HomingState::kNotDone;
    case 0x1000: return HomingState::kAttained;
    case 0x1400: return HomingState::kDone;
    case 0x2000: return HomingState::kErrorMoving;
    case 0x2400: return HomingState::kError;
    default: return HomingState::kUnknown;
  }
}

const char* describe(HomingState state) {
  switch (state) {
    case HomingState::kUnknown: return "unknown";
    case HomingState::kInProgress: return "in progress";
    case HomingState::kNotDone: return "not started, or interrupted";
    case HomingState::kAttained: return "attained, still moving";
    case HomingState::kDone: return "done";
    case HomingState::kErrorMoving: return "failed, still moving";
    case HomingState::kError: return "failed";
  }
  return "unknown";
}

}  // namespace vergence::canopen
