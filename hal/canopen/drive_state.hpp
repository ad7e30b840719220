// The state machine of a drive [CiA 402-2, 7.2]: what its statusword says, and which controlword takes it
// from one state to the next, as one table for the master and for simulated drives.
#pragma once

#include <array>
#include <cstdint>

namespace vergence::canopen {

enum class DriveState : std::uint8_t {
  kNotReady,
  kSwitchOnDisabled,
  kReadyToSwitchOn,
  kSwitchedOn,
  kOperationEnabled,
  kQuickStopActive,
  kFaultReaction,
  kFault,
  kUnknown,  // bits the standard gives no state; to be treated as a fault
};

inline constexpr std::uint16_t kStatusVoltage = 0x0010;
inline constexpr std::uint16_t kStatusWarning = 0x0080;
inline constexpr std::uint16_t kStatusRemote = 0x0200;
inline constexpr std::uint16_t kStatusTargetReached = 0x0400;
inline constexpr std::uint16_t kStatusLimitActive = 0x0800;
inline constexpr std::uint16_t kStatusFollows = 0x1000;         // in the cyclic modes
inline constexpr std::uint16_t kStatusFollowingError = 0x2000;  // in the cyclic position mode

// Of the statusword, object 0x6041.
[[nodiscard]] DriveState decode_state(std::uint16_t statusword);
// The bits of it that say the state; the other bits are zero.
[[nodiscard]] std::uint16_t state_bits(DriveState state);
[[nodiscard]] const char* describe(DriveState state);
[[nodiscard]] constexpr bool is_fault(DriveState state) {
  return state == DriveState::kFault || state == DriveState::kFaultReaction || state == DriveState::kUnknown;
}

// Commands of the controlword, object 0x6040.
enum class DriveCommand : std::uint8_t {
  kNone,  // bits that command nothing
  kShutdown,
  kSwitchOn,  // also: disable operation
  kEnableOperation,
  kDisableVoltage,
  kQuickStop,
  kFaultReset,  // by the edge of its bit
};

[[nodiscard]] std::uint16_t controlword(DriveCommand command);
// With the controlword before, since a fault is reset by a rising edge.
[[nodiscard]] DriveCommand decode_command(std::uint16_t controlword, std::uint16_t before);

// Transitions by command, with the standard's numbers; 0, 1, 13 and 14 are the drive's own.
struct DriveTransition {
  std::uint8_t number;
  DriveState from;
  DriveCommand command;
  DriveState to;
};
inline constexpr std::array kDriveTransitions = {
    DriveTransition{2, DriveState::kSwitchOnDisabled, DriveCommand::kShutdown, DriveState::kReadyToSwitchOn},
    DriveTransition{3, DriveState::kReadyToSwitchOn, DriveCommand::kSwitchOn, DriveState::kSwitchedOn},
    DriveTransition{4, DriveState::kSwitchedOn, DriveCommand::kEnableOperation,
                    DriveState::kOperationEnabled},
    DriveTransition{5, DriveState::kOperationEnabled, DriveCommand::kSwitchOn, DriveState::kSwitchedOn},
    DriveTransition{6, DriveState::kSwitchedOn, DriveCommand::kShutdown, DriveState::kReadyToSwitchOn},
    DriveTransition{7, DriveState::kReadyToSwitchOn, DriveCommand::kDisableVoltage,
                    DriveState::kSwitchOnDisabled},
    DriveTransition{7, DriveState::kReadyToSwitchOn, DriveCommand::kQuickStop, DriveState::kSwitchOnDisabled},
    DriveTransition{8, DriveState::kOperationEnabled, DriveCommand::kShutdown, DriveState::kReadyToSwitchOn},
    DriveTransition{9, DriveState::kOperationEnabled, DriveCommand::kDisableVoltage,
                    DriveState::kSwitchOnDisabled},
    DriveTransition{10, DriveState::kSwitchedOn, DriveCommand::kDisableVoltage,
                    DriveState::kSwitchOnDisabled},
    DriveTransition{10, DriveState::kSwitchedOn, DriveCommand::kQuickStop, DriveState::kSwitchOnDisabled},
    DriveTransition{11, DriveState::kOperationEnabled, DriveCommand::kQuickStop,
                    DriveState::kQuickStopActive},
    DriveTransition{12, DriveState::kQuickStopActive, DriveCommand::kDisableVoltage,
                    DriveState::kSwitchOnDisabled},
    DriveTransition{15, DriveState::kFault, DriveCommand::kFaultReset, DriveState::kSwitchOnDisabled},
    DriveTransition{16, DriveState::kQuickStopActive, DriveCommand::kEnableOperation,
                    DriveState::kOperationEnabled},
};

// A command that has no row changes nothing.
[[nodiscard]] DriveState next_state(DriveState state, DriveCommand command);

enum class DriveGoal : std::uint8_t {
  kOff,        // switch on disabled
  kOn,         // operation enabled
  kQuickStop,  // braking, or at rest after it
  kReset,      // off, and out of a fault
};

// The next command on the way. Out of a quick stop the way leads through off: transition 16 is optional.
// Reset is an edge: of two calls in a fault, with the last command as `before`, one commands nothing.
[[nodiscard]] DriveCommand command_towards(DriveGoal goal, DriveState state, DriveCommand before);

// Homing, as bits 10, 12 and 13 of the statusword say it while the drive is in homing mode.
enum class HomingState : std::uint8_t {
  kUnknown,  // not read
  kInProgress,
  kNotDone,   // not started, or interrupted
  kAttained,  // and still moving
  kDone,
  kErrorMoving,
  kError,
};
[[nodiscard]] HomingState decode_homing(std::uint16_t statusword);
[[nodiscard]] const char* describe(HomingState state);

}  // namespace vergence::canopen
