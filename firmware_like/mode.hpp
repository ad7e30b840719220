// What the controller is doing, and what makes it do something else: one table.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace vergence {

enum class Mode : std::uint8_t {
  kInit,      // waiting for the devices to answer
  kSelfTest,  // they do: are they what the configuration says?
  kIdle,      // drives off
  kSearch,    // drives on, hand at rest, looking for the target
  kTrack,     // the eyes follow the target, the hand is at rest
  kServo,     // the hand follows too
  kHold,      // the hand is at rest because the operator wants it so; the eyes follow
  kSafeStop,  // a controlled stop, then drives off; stays until it is reset
  kFault,     // drives off, and something is broken; stays until it is reset
};
inline constexpr std::size_t kModes = 9;

enum class Event : std::uint8_t {
  kDevicesReady,
  kSelfTestPassed,
  kSelfTestFailed,
  kArm,          // operator: drives on
  kDisarm,       // operator: drives off
  kTargetFound,  // and believed
  kTargetLost,
  kServo,  // operator: the hand is to follow
  kHold,   // operator: the hand is to rest
  kStop,   // operator, watchdog or signal
  kDeadlineMissed,
  kFollowingError,  // the hand is not where it was sent
  kDeviceFault,     // a drive, a motor or the cameras gave up
  kReset,           // operator, once everything is at rest
};
inline constexpr std::size_t kEvents = 14;

struct Transition {
  Mode from;
  Event event;
  Mode to;
};

// An event that has no row changes nothing.
inline constexpr std::array kTransitions = {
    Transition{Mode::kInit, Event::kDevicesReady, Mode::kSelfTest},
    Transition{Mode::kInit, Event::kDeviceFault, Mode::kFault},
    Transition{Mode::kInit, Event::kStop, Mode::kFault},

    Transition{Mode::kSelfTest, Event::kSelfTestPassed, Mode::kIdle},
    Transition{Mode::kSelfTest, Event::kSelfTestFailed, Mode::kFault},
    Transition{Mode::kSelfTest, Event::kDeviceFault, Mode::kFault},
    Transition{Mode::kSelfTest, Event::kStop, Mode::kFault},

    Transition{Mode::kIdle, Event::kArm, Mode::kSearch},
    Transition{Mode::kIdle, Event::kDeviceFault, Mode::kFault},
    Transition{Mode::kIdle, Event::kStop, Mode::kSafeStop},

    Transition{Mode::kSearch, Event::kTargetFound, Mode::kTrack},
    Transition{Mode::kSearch, Event::kHold, Mode::kHold},
    Transition{Mode::kSearch, Event::kDisarm, Mode::kIdle},
    Transition{Mode::kSearch, Event::kStop, Mode::kSafeStop},
    Transition{Mode::kSearch, Event::kDeadlineMissed, Mode::kSafeStop},
    Transition{Mode::kSearch, Event::kFollowingError, Mode::kSafeStop},
    Transition{Mode::kSearch, Event::kDeviceFault, Mode::kSafeStop},

    Transition{Mode::kTrack, Event::kTargetLost, Mode::kSearch},
    Transition{Mode::kTrack, Event::kServo, Mode::kServo},
    Transition{Mode::kTrack, Event::kHold, Mode::kHold},
    Transition{Mode::kTrack, Event::kDisarm, Mode::kIdle},
    Transition{Mode::kTrack, Event::kStop, Mode::kSafeStop},
    Transition{Mode::kTrack, Event::kDeadlineMissed, Mode::kSafeStop},
    Transition{Mode::kTrack, Event::kFollowingError, Mode::kSafeStop},
    Transition{Mode::kTrack, Event::kDeviceFault, Mode::kSafeStop},

    Transition{Mode::kServo, Event::kTargetLost, Mode::kSearch},
    Transition{Mode::kServo, Event::kHold, Mode::kHold},
    // While the hand moves, drives are not just switched off under it.
    Transition{Mode::kServo, Event::kDisarm, Mode::kSafeStop},
    Transition{Mode::kServo, Event::kStop, Mode::kSafeStop},
    Transition{Mode::kServo, Event::kDeadlineMissed, Mode::kSafeStop},
    Transition{Mode::kServo, Event::kFollowingError, Mode::kSafeStop},
    Transition{Mode::kServo, Event::kDeviceFault, Mode::kSafeStop},

    Transition{Mode::kHold, Event::kServo, Mode::kSearch},
    Transition{Mode::kHold, Event::kDisarm, Mode::kIdle},
    Transition{Mode::kHold, Event::kStop, Mode::kSafeStop},
    Transition{Mode::kHold, Event::kDeadlineMissed, Mode::kSafeStop},
    Transition{Mode::kHold, Event::kFollowingError, Mode::kSafeStop},
    Transition{Mode::kHold, Event::kDeviceFault, Mode::kSafeStop},

    Transition{Mode::kSafeStop, Event::kDeviceFault, Mode::kFault},
    Transition{Mode::kSafeStop, Event::kReset, Mode::kIdle},

    Transition{Mode::kFault, Event::kReset, Mode::kInit},
};

[[nodiscard]] constexpr Mode next_mode(Mode mode, Event event) {
  for (const Transition& transition : kTransitions) {
    if (transition.from == mode && transition.event == event) return transition.to;
  }
  return mode;
}

[[nodiscard]] const char* to_string(Mode mode);
[[nodiscard]] const char* to_string(Event event);

// Whether the drives are on.
[[nodiscard]] constexpr bool is_armed(Mode mode) {
  return mode == Mode::kSearch || mode == Mode::kTrack || mode == Mode::kServo || mode == Mode::kHold;
}

}  // namespace vergence
