#include "firmware_like/mode.hpp"

namespace vergence {

const char* to_string(Mode mode) {
  switch (mode) {
    case Mode::kInit: return "init";
    case Mode::kSelfTest: return "self-test";
    case Mode::kIdle: return "idle";
    case Mode::kSearch: return "search";
    case Mode::kTrack: return "track";
    case Mode::kServo: return "servo";
    case Mode::kHold: return "hold";
    case Mode::kSafeStop: return "safe-stop";
    case Mode::kFault: return "fault";
  }
  return "unknown mode";
}

const char* to_string(Event event) {
  switch (event) {
    case Event::kDevicesReady: return "devices ready";
    case Event::kSelfTestPassed: return "self-test passed";
    case Event::kSelfTestFailed: return "self-test failed";
    case Event::kArm: return "arm";
    case Event::kDisarm: return "disarm";
    case Event::kTargetFound: return "target found";
    case Event::kTargetLost: return "target lost";
    case Event::kServo: return "servo";
    case Event::kHold: return "hold";
    case Event::kStop: return "stop";
    case Event::kDeadlineMissed: return "deadline missed";
    case Event::kFollowingError: return "following error";
    case Event::kDeviceFault: return "device fault";
    case Event::kReset: return "reset";
  }
  return "unknown event";
}

}  // namespace vergence
