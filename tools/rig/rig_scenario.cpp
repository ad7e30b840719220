#include "tools/rig/rig_scenario.hpp"

#include <algorithm>
#include <array>

#include "algo/limits.hpp"
#include "tools/io/toml_reader.hpp"

namespace vergence::rig {
namespace {

struct KindName {
  const char* name;
  FaultKind kind;
};

constexpr std::array kKinds = {
    KindName{"drive-silent", FaultKind::kDriveSilent},
    KindName{"drive-emergency", FaultKind::kDriveEmergency},
    KindName{"heartbeat-lost", FaultKind::kHeartbeatLost},
    KindName{"statusword-broken", FaultKind::kStatuswordBroken},
    KindName{"wrong-node", FaultKind::kWrongNode},
    KindName{"foreign-traffic", FaultKind::kForeignTraffic},
    KindName{"bus-off", FaultKind::kBusOff},
    KindName{"camera-unplugged", FaultKind::kCameraUnplugged},
    KindName{"camera-stalled", FaultKind::kCameraStalled},
    KindName{"camera-dropping", FaultKind::kCameraDropping},
    KindName{"camera-broken", FaultKind::kCameraBroken},
    KindName{"eye-late", FaultKind::kEyeLate},
    KindName{"eyes-out-of-step", FaultKind::kEyesOutOfStep},
    KindName{"target-absent", FaultKind::kTargetAbsent},
    KindName{"controller-killed", FaultKind::kControllerKilled},
    KindName{"controller-stopped", FaultKind::kControllerStopped},
    KindName{"clock-step", FaultKind::kClockStep},
};

FaultKind kind_of(const tools::TomlReader& table, const std::string& name) {
  const auto found =
      std::find_if(kKinds.begin(), kKinds.end(), [&](const KindName& k) { return name == k.name; });
  if (found != kKinds.end()) return found->kind;
  std::string known;
  for (const KindName& k : kKinds) known += (known.empty() ? "" : ", ") + std::string(k.name);
  table.fail("kind", "is '" + name + "'", "one of " + known);
}

Expectation expectation_of(const tools::TomlReader& table) {
  const std::string text = table.text_or("expect", "nothing");
  if (text == "nothing") return Expectation::kNothing;
  if (text == "stop") return Expectation::kStop;
  if (text == "rest") return Expectation::kRest;
  if (text != "carry-on") table.fail("expect", "is '" + text + "'", "one of nothing, stop, rest, carry-on");
  return Expectation::kCarryOn;
}

FaultEvent fault_of(const tools::TomlReader& table) {
  table.allow_only(
      {"kind", "at_s", "for_s", "joint", "eye", "value", "expect", "within_s", "again_within_s"});
  constexpr tools::Range kTime{0, 1e4};
  FaultEvent fault;
  fault.name = table.text("kind");
  fault.kind = kind_of(table, fault.name);
  fault.at_s = table.number("at_s", kTime);
  fault.for_s = table.number_or("for_s", 0, kTime);
  fault.joint = static_cast<std::size_t>(table.integer_or("joint", 1, 1, kMaxJoints) - 1);
  const std::string eye = table.text_or("eye", "left");
  if (eye != "left" && eye != "right") table.fail("eye", "is '" + eye + "'", "left or right");
  fault.side = eye == "right" ? 1 : 0;
  fault.value = table.number_or("value", 0);
  fault.expect = expectation_of(table);
  fault.within_s = table.number_or("within_s", 0.2, kTime);
  fault.again_within_s = table.number_or("again_within_s", 1, kTime);
  if (fault.expect == Expectation::kRest && fault.for_s <= fault.within_s) {
    table.fail("for_s", "the fault is over before the rest can be seen", "longer than within_s");
  }
  return fault;
}

}  // namespace

RigScenario read_scenario(const std::filesystem::path& file) {
  const tools::TomlReader root = tools::TomlReader::from_file(file);
  root.allow_only({"title",
                   "description",
                   "robot",
                   "program",
                   "arguments",
                   "scene",
                   "duration_s",
                   "frames_per_s",
                   "patient_operator",
                   "settle_s",
                   "hand_rms_mm",
                   "start",
                   "pen_from_s",
                   "arm_rests",
                   "eye_steps",
                   "stamp_to_mid_exposure_ms",
                   "judge",
                   "sway",
                   "operator",
                   "fault"});
  constexpr tools::Range kTime{0, 1e4};
  RigScenario scenario;
  scenario.name = file.stem().string();
  scenario.title = root.text("title");
  scenario.description = root.text("description");
  scenario.scene = file.parent_path() / root.text("scene");
  scenario.duration_s = root.number("duration_s", kTime);
  scenario.frames_per_s = root.number_or("frames_per_s", 30, {1, 60});
  scenario.patient_operator = root.boolean_or("patient_operator", true);
  scenario.settle_s = root.number_or("settle_s", 3, kTime);
  scenario.hand_rms_mm = root.number_or("hand_rms_mm", 0, kTime);
  scenario.arm_rests = root.boolean_or("arm_rests", false);
  scenario.eye_steps = root.integer_or("eye_steps", 0, 0, 100'000);
  const std::string start = root.text_or("start", "ahead");
  if (start != "ahead" && start != "over-pool")
    root.fail("start", "is '" + start + "'", "ahead or over-pool");
  scenario.over_pool = start == "over-pool";
  scenario.pen_from_s = root.number_or("pen_from_s", 0, kTime);
  for (const tools::TomlReader& table : root.tables("operator", true)) {
    table.allow_only({"at_s", "say"});
    scenario.operators.push_back({table.number("at_s", kTime), table.text("say")});
  }
  for (const tools::TomlReader& table : root.tables("sway", true)) {
    table.allow_only({"joint", "amplitude_rad", "omega_rad_s"});
    scenario.sways.push_back({static_cast<std::size_t>(table.integer("joint", 1, kMaxJoints) - 1),
                              table.number("amplitude_rad", {0, 1}), table.number("omega_rad_s", {0, 100})});
  }
  for (const tools::TomlReader& table : root.tables("fault", true))
    scenario.faults.push_back(fault_of(table));
  std::stable_sort(scenario.faults.begin(), scenario.faults.end(),
                   [](const FaultEvent& a, const FaultEvent& b) { return a.at_s < b.at_s; });
  return scenario;
}

}  // namespace vergence::rig
