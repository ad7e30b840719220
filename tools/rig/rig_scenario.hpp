// What happens in a run of the rig: a scene, an operator, faults at their times, and what is expected of
// each. Read from TOML; docs/rig.md has the keys.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "tools/rig/sway.hpp"

namespace vergence::rig {

enum class FaultKind {
  kDriveSilent,       // without power: neither hears nor says anything
  kDriveEmergency,    // says so and stops
  kHeartbeatLost,     // the drive's; all else works
  kStatuswordBroken,  // means nothing in CiA 402
  kWrongNode,         // somebody answers in a drive's name
  kForeignTraffic,
  kBusOff,
  kCameraUnplugged,
  kCameraStalled,
  kCameraDropping,  // a share of the pictures
  kCameraBroken,    // pictures are flagged
  kEyeLate,         // one eye shows what was there before
  kEyesOutOfStep,   // they give pictures in turn: none has its partner
  kTargetAbsent,
  kControllerKilled,
  kControllerStopped,  // by a signal, and goes on later
  kClockStep,
};

enum class Expectation {
  kNothing,
  kStop,     // the tool at rest within the time, and it stays there
  kRest,     // the tool at rest within the time, drives on, until it is over; then it goes on
  kCarryOn,  // the arm does not stop for it
};

struct FaultEvent {
  FaultKind kind = FaultKind::kDriveSilent;
  double at_s = 0;
  double for_s = 0;  // 0: to the end
  std::size_t joint = 0;
  int side = 0;      // of the cameras: 0 left, 1 right
  double value = 0;  // per cent, ms, frames a ms, or a number as the kind has it
  Expectation expect = Expectation::kNothing;
  double within_s = 0.2;
  double again_within_s = 1;  // after the end, of a rest
  std::string name;
};

struct OperatorEvent {
  double at_s = 0;
  std::string say;
};

struct RigScenario {
  std::string name;
  std::string title;
  std::string description;
  std::filesystem::path scene;
  double duration_s = 10;
  double frames_per_s = 30;
  // The operator arms and asks for servoing by himself until he has got it once; then, and otherwise, only
  // this.
  bool patient_operator = true;
  std::vector<OperatorEvent> operators;
  std::vector<FaultEvent> faults;  // by rising time
  std::vector<Sway> sways;         // while drives are off
  double settle_s = 3;             // from then on errors of the hand count
  double hand_rms_mm = 0;          // that is wanted; 0: none in particular
  bool arm_rests = false;          // drives stay off, the bus is only read from, the eyes do no more than:
  std::int64_t eye_steps = 0;      // each motor, there and back
  bool over_pool = false;          // where the hand starts: looking down, instead of ahead
  double pen_from_s = 0;           // from then on a pen is let go when it will hit; 0: there is none
};

// Throws InputError naming file, line and key.
[[nodiscard]] RigScenario read_scenario(const std::filesystem::path& file);

}  // namespace vergence::rig
