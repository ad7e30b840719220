#include "tools/bringup/can_checks.hpp"

#include <linux/can/netlink.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "hal/canopen/bytes.hpp"
#include "hal/canopen/drive_state.hpp"
#include "hal/canopen/emergency.hpp"
#include "hal/canopen/objects.hpp"
#include "hal/canopen/sdo_abort.hpp"

namespace vergence::tools {
namespace {

using canopen::DriveState;
using State = ObjectReading::State;

constexpr std::uint32_t kShortestQueue = 16;  // a period's frames, and the next one's while the bus is busy
constexpr double kSlow_ms = 20;
constexpr double kHeartbeatTolerance = 0.2;
constexpr double kDegPerRad = 180 / std::numbers::pi;

double to_ms(std::int64_t ns) {
  return static_cast<double>(ns) * 1e-6;
}

// ---- the interface
// ------------------------------------------------------------------------------------------

std::string bring_up(const CanConfig& config, int bus) {
  const char* const name = config.interface_of(bus);
  return format(
      "sudo ip link set %s down; sudo ip link set %s type can bitrate %lld restart-ms 100; "
      "sudo ip link set %s txqueuelen 32 up",
      name, name, static_cast<long long>(config.bitrate_bit_per_s), name);
}

const char* name_of_state(std::uint32_t state) {
  switch (state) {
    case CAN_STATE_ERROR_ACTIVE: return "error active (well)";
    case CAN_STATE_ERROR_WARNING: return "error warning";
    case CAN_STATE_ERROR_PASSIVE: return "error passive";
    case CAN_STATE_BUS_OFF: return "bus off";
    case CAN_STATE_STOPPED: return "stopped";
    case CAN_STATE_SLEEPING: return "asleep";
    default: return "unknown";
  }
}

constexpr const char* kWiring =
    "check the wiring: CAN-H and CAN-L not swapped, 120 ohms at both ends (60 between H and L), all nodes at "
    "one bit "
    "rate and powered";

// Both need a driver that tells.
void judge_counters(const CanLink& link, Findings& found) {
  if (!link.state) {
    found.skip("bus state", link.is_virtual ? "a virtual bus has none" : "the driver does not tell");
  } else {
    Outcome outcome = *link.state == CAN_STATE_ERROR_ACTIVE ? Outcome::kPass : Outcome::kFail;
    if (*link.state == CAN_STATE_ERROR_WARNING || *link.state == CAN_STATE_ERROR_PASSIVE)
      outcome = Outcome::kWarn;
    found.judge(outcome, "bus state", name_of_state(*link.state), kWiring);
  }
  if (!link.errors) {
    found.skip("error counters", link.is_virtual ? "a virtual bus has none" : "the driver does not tell");
    return;
  }
  found.judge(link.errors->tx == 0 && link.errors->rx == 0 ? Outcome::kPass : Outcome::kWarn,
              "error counters", format("%u sending, %u receiving", link.errors->tx, link.errors->rx),
              kWiring);
}

void judge_bitrate(const CanObservation& seen, const CanConfig& config, Findings& found) {
  const CanLink& link = seen.link;
  constexpr const char* kCheck = "bit rate";
  if (!link.bitrate_bit_per_s) {
    return found.skip(kCheck, link.is_virtual
                                  ? "a virtual bus has none"
                                  : "the driver does not tell (slcan: look at how it was set up)");
  }
  const bool is_as_asked = *link.bitrate_bit_per_s == config.bitrate_bit_per_s;
  found.judge(
      is_as_asked ? Outcome::kPass : Outcome::kFail, kCheck,
      format("%u bit/s of %lld", *link.bitrate_bit_per_s, static_cast<long long>(config.bitrate_bit_per_s)),
      bring_up(config, seen.bus));
}

// True where it can be listened to.
bool judge_link(const CanObservation& seen, const CanConfig& config, Findings& found) {
  const CanLink& link = seen.link;
  const char* const name = config.interface_of(seen.bus);
  constexpr const char* kCheck = "interface";
  if (link.was_told && (!link.exists || !link.is_can)) {
    found.fail(
        kCheck, format(link.exists ? "%s is no CAN interface" : "%s is not there", name),
        "`ip -details link` lists what is there; plug the adapter in, load its driver, set can.interface" +
            std::string(seen.bus > 0 ? "_2" : ""));
    return false;
  }
  if (link.was_told && !link.is_up) {
    found.fail(kCheck, format("%s is down", name), bring_up(config, seen.bus));
    return false;
  }
  if (!seen.open_problem.empty()) {
    found.fail(kCheck, format("%s: %s", name, seen.open_problem.c_str()),
               "`ip -details link show` tells more");
    return false;
  }
  found.pass(kCheck, format("%s is up%s", name, link.is_virtual ? ", virtual" : ""));
  return true;
}

void judge_settings(const CanObservation& seen, const CanConfig& config, Findings& found) {
  const CanLink& link = seen.link;
  const char* const name = config.interface_of(seen.bus);
  found.judge(link.tx_queue >= kShortestQueue || !link.was_told ? Outcome::kPass : Outcome::kWarn,
              "transmit queue", format("%u frames", link.tx_queue),
              format("sudo ip link set %s txqueuelen 32", name));
  if (!link.restart_ms) return found.skip("restart after bus-off", "the driver does not tell");
  found.judge(
      *link.restart_ms > 0 ? Outcome::kPass : Outcome::kWarn, "restart after bus-off",
      *link.restart_ms > 0 ? format("after %u ms", *link.restart_ms) : "never by itself",
      format("sudo ip link set %s down; sudo ip link set %s type can restart-ms 100; sudo ip link set %s up; "
             "or give vergenced CAP_NET_ADMIN",
             name, name, name));
}

// ---- the bus
// ------------------------------------------------------------------------------------------------

void judge_health(const canopen::CanHealth& health, Findings& found) {
  const std::string measured =
      format("%u error frames, %u frames lost, %u not taken, %u bus-offs", health.error_frames,
             health.rx_overflows, health.tx_refused + health.tx_failed, health.bus_offs);
  Outcome outcome = health.error_frames > 0 || health.rx_overflows > 0 ? Outcome::kWarn : Outcome::kPass;
  if (health.bus_offs > 0 || health.tx_refused + health.tx_failed > 0) outcome = Outcome::kFail;
  std::string remedy = kWiring;
  if (health.error_frames > 0) remedy = std::string(canopen::describe(health.last_errors)) + ": " + remedy;
  found.judge(outcome, "traffic", measured, remedy);
}

bool is_configured(int node, int bus, const canopen::CanopenArmConfig& arm) {
  for (int i = 0; i < arm.axes; ++i) {
    const canopen::CanopenAxisConfig& axis = arm.axis[static_cast<std::size_t>(i)];
    if (axis.bus == bus && axis.node_id == node) return true;
  }
  return false;
}

std::string list_of_strangers(const CanObservation& seen, const canopen::CanopenArmConfig& arm) {
  std::string list;
  for (int node = 1; node <= canopen::kMaxNodeId; ++node) {
    const HeardNode& heard = seen.heard[static_cast<std::size_t>(node)];
    const bool is_there = seen.found[static_cast<std::size_t>(node)] || heard.heartbeats > 0 ||
                          heard.boots > 0 || heard.others > 0 || heard.emergency != 0;
    if (!is_there || is_configured(node, seen.bus, arm)) continue;
    list += (list.empty() ? "" : ", ") + std::to_string(node);
  }
  return list;
}

void judge_others(const CanObservation& seen, const CanConfig& config, Findings& found) {
  const int master = config.arm.master_node_id;
  const HeardNode& as_master = seen.heard[static_cast<std::size_t>(master)];
  const bool has_rival = seen.foreign_commands > 0 || as_master.heartbeats > 0;
  found.judge(has_rival ? Outcome::kFail : Outcome::kPass, "no other master",
              format("%d commands, %d heartbeats of node %d, not ours", seen.foreign_commands,
                     as_master.heartbeats, master),
              "another program or controller commands this bus: stop it (vergenced? a set-up tool?)");
  const std::string strangers = list_of_strangers(seen, config.arm);
  found.judge(strangers.empty() ? Outcome::kPass : Outcome::kWarn, "no other nodes",
              strangers.empty() ? "none" : "nodes " + strangers,
              "a node with a wrong id, or one the configuration leaves out: [[can.axis]] node");
}

// ---- a drive
// ------------------------------------------------------------------------------------------------

std::string name_of(std::size_t axis, const char* check) {
  return format("axis %zu %s", axis + 1, check);
}

std::string text_of(const ObjectReading& reading) {
  std::string text;
  for (const std::uint8_t byte : reading.bytes) {
    if (byte >= 0x20 && byte < 0x7F) text += static_cast<char>(byte);
  }
  return text;
}

std::string failure_of(const ObjectReading& reading) {
  return reading.state == State::kRefused ? canopen::describe_abort(reading.abort_code) : "no answer";
}

void judge_presence(std::size_t axis, const CanObservation& seen, const canopen::CanopenAxisConfig& config,
                    const std::string& strangers, Findings& found) {
  const HeardNode& heard = seen.heard[config.node_id];
  const std::string check = name_of(axis, "answers");
  const std::string state = heard.heartbeats > 0 ? canopen::describe(heard.state) : "no heartbeat";
  if (seen.drives[axis].answers()) {
    return found.pass(check, format("node %d, %s", config.node_id, state.c_str()));
  }
  std::string remedy = "power on, cable, bit rate and node id of the drive";
  if (heard.state == canopen::NmtState::kStopped) {
    remedy = "it is stopped, and so answers no questions: switch it off and on";
  } else if (!strangers.empty()) {
    remedy += "; unexpected are nodes " + strangers + ": does one of them carry the wrong id?";
  }
  found.fail(check, format("node %d, %s, answers no SDO", config.node_id, state.c_str()), remedy);
}

void judge_identity(const std::string& check, const DriveObservation& drive,
                    const canopen::CanopenAxisConfig& config, Findings& found) {
  if (!drive.device_type.was_read()) {
    return found.fail(check, "object 0x1000: " + failure_of(drive.device_type),
                      "a device that does not say what it is cannot be used");
  }
  const std::uint32_t profile = drive.device_type.number() & 0xFFFF;
  const std::string vendor =
      drive.vendor.was_read() ? format("vendor 0x%x", drive.vendor.number()) : "vendor unknown";
  const std::string name = text_of(drive.name);
  const std::string measured =
      format("CiA %u, %s%s%s", profile, vendor.c_str(), name.empty() ? "" : ", ", name.c_str());
  if (profile != canopen::kDriveProfile) {
    return found.fail(check, measured, "no drive of CiA 402: is the node id the right one?");
  }
  const bool is_wanted =
      config.vendor_id == 0 || (drive.vendor.was_read() && drive.vendor.number() == config.vendor_id);
  found.judge(
      is_wanted ? Outcome::kPass : Outcome::kFail, check, measured,
      format("expected vendor 0x%x: another drive, or correct [[can.axis]] vendor", config.vendor_id));
}

void judge_heartbeat(const std::string& check, const DriveObservation& drive, const HeardNode& heard,
                     Findings& found) {
  if (!drive.heartbeat_ms.was_read()) {
    return found.fail(check, "object 0x1017: " + failure_of(drive.heartbeat_ms),
                      "the controller watches drives by their heartbeat: use one that has it");
  }
  const double set_ms = drive.heartbeat_ms.number();
  if (set_ms == 0) return found.pass(check, "0x1017 is 0: off until the controller sets it");
  if (heard.heartbeats < 3) {
    return found.judge(heard.heartbeats > 0 ? Outcome::kWarn : Outcome::kFail, check,
                       format("0x1017 is %.0f ms, %d heard", set_ms, heard.heartbeats),
                       "listen longer (--seconds), or frames are lost: check the wiring");
  }
  const double period_ms = to_ms(heard.last_ns - heard.first_ns) / (heard.heartbeats - 1);
  const bool is_kept = std::abs(period_ms / set_ms - 1) <= kHeartbeatTolerance;
  found.judge(is_kept ? Outcome::kPass : Outcome::kWarn, check,
              format("every %.1f ms, 0x1017 is %.0f", period_ms, set_ms),
              "heartbeats come unevenly: is the bus overloaded, or are frames lost?");
}

void judge_round_trips(const std::string& check, const DriveObservation& drive, const CanConfig& config,
                       Findings& found) {
  if (drive.round_trips_ns.empty()) {
    return found.fail(check, format("%d unanswered", drive.unanswered), kWiring);
  }
  std::vector<std::int64_t> sorted = drive.round_trips_ns;
  std::sort(sorted.begin(), sorted.end());
  const double median_ms = to_ms(sorted[sorted.size() / 2]);
  const double largest_ms = to_ms(sorted.back());
  const std::string measured = format("median %.2f ms, largest %.2f ms of %zu, %d unanswered", median_ms,
                                      largest_ms, sorted.size(), drive.unanswered);
  const double patience_ms = to_ms(config.arm.sdo_timeout_ns);
  if (drive.unanswered > 0) return found.fail(check, measured, kWiring);
  found.judge(median_ms > kSlow_ms || largest_ms > patience_ms / 2 ? Outcome::kWarn : Outcome::kPass, check,
              measured, format("the drive is slow or busy; can.sdo_timeout_ms is %.0f", patience_ms));
}

void judge_drive_state(const std::string& check, const DriveObservation& drive, const HeardNode& heard,
                       Findings& found) {
  if (!drive.statusword.was_read()) {
    return found.fail(check, "object 0x6041: " + failure_of(drive.statusword),
                      "no drive of CiA 402, or one that must be set up first by its maker's tool");
  }
  const auto word = static_cast<std::uint16_t>(drive.statusword.number());
  const DriveState state = canopen::decode_state(word);
  std::string measured = format("%s, statusword 0x%04x", canopen::describe(state), word);
  if (drive.error_register.was_read() && drive.error_register.number() != 0) {
    measured += format(", error register 0x%02x", drive.error_register.number());
  }
  if (heard.emergency != 0) {
    measured +=
        format(", emergency 0x%04x (%s)", heard.emergency, canopen::describe_emergency(heard.emergency));
  }
  if (canopen::is_fault(state)) {
    return found.fail(
        check, measured,
        "mend the cause the drive's manual gives for it; `vergence ctl reset` clears the fault later");
  }
  if (state == DriveState::kOperationEnabled || state == DriveState::kSwitchedOn ||
      state == DriveState::kQuickStopActive) {
    return found.warn(check, measured,
                      "somebody has switched it on: find out who, and press the emergency stop");
  }
  if ((word & canopen::kStatusVoltage) == 0) {
    return found.warn(
        check, measured,
        "the power stage has no voltage: release the emergency stop and safe torque off, switch the "
        "motor supply on");
  }
  found.judge((word & canopen::kStatusWarning) != 0 ? Outcome::kWarn : Outcome::kPass, check, measured,
              "the drive warns: its manual says of what");
}

void judge_position(const std::string& check, const DriveObservation& drive,
                    const canopen::CanopenAxisConfig& config, Findings& found) {
  if (!drive.position.was_read()) {
    return found.fail(check, "object 0x6064: " + failure_of(drive.position), "the controller needs it");
  }
  const auto counts = static_cast<std::int32_t>(drive.position.number());
  const double rad = (static_cast<double>(counts) - config.zero_counts) / config.counts_per_rad;
  const bool is_inside = rad >= config.min_rad && rad <= config.max_rad;
  found.judge(
      is_inside ? Outcome::kPass : Outcome::kWarn, check,
      format("%.2f deg, %d counts, range %.0f to %.0f deg", rad * kDegPerRad, counts,
             config.min_rad * kDegPerRad, config.max_rad * kDegPerRad),
      "outside its range: home the drive, and compare zero_counts and counts_per_turn with the joint's real "
      "angle");
}

constexpr std::array kDriveChecks = {"identity", "heartbeat", "round trip", "drive", "position"};

void skip_drive(std::size_t axis, const char* why, Findings& found) {
  for (const char* const check : kDriveChecks) found.skip(name_of(axis, check), why);
}

void judge_drives(const CanObservation& seen, const CanConfig& config, Findings& found) {
  const std::string strangers = list_of_strangers(seen, config.arm);
  for (std::size_t axis = 0; axis < seen.drives.size(); ++axis) {
    const canopen::CanopenAxisConfig& its = config.arm.axis[axis];
    if (its.bus != seen.bus) continue;
    const DriveObservation& drive = seen.drives[axis];
    judge_presence(axis, seen, its, strangers, found);
    if (!drive.answers()) {
      skip_drive(axis, "the node does not answer", found);
      continue;
    }
    const HeardNode& heard = seen.heard[its.node_id];
    judge_identity(name_of(axis, kDriveChecks[0]), drive, its, found);
    judge_heartbeat(name_of(axis, kDriveChecks[1]), drive, heard, found);
    judge_round_trips(name_of(axis, kDriveChecks[2]), drive, config, found);
    judge_drive_state(name_of(axis, kDriveChecks[3]), drive, heard, found);
    judge_position(name_of(axis, kDriveChecks[4]), drive, its, found);
  }
}

std::vector<Finding> judge_bus(const CanObservation& seen, const CanConfig& config) {
  Findings found("can");
  if (!judge_link(seen, config, found)) {
    for (const char* const check :
         {"bit rate", "bus state", "error counters", "traffic", "no other master", "no other nodes"}) {
      found.skip(check, "the interface cannot be used");
    }
    for (int axis = 0; axis < config.arm.axes; ++axis) {
      if (config.arm.axis[static_cast<std::size_t>(axis)].bus != seen.bus) continue;
      found.skip(name_of(static_cast<std::size_t>(axis), "answers"), "the interface cannot be used");
      skip_drive(static_cast<std::size_t>(axis), "the interface cannot be used", found);
    }
    return found.take();
  }
  judge_bitrate(seen, config, found);
  judge_counters(seen.link, found);
  judge_settings(seen, config, found);
  judge_health(seen.health, found);
  judge_others(seen, config, found);
  judge_drives(seen, config, found);
  return found.take();
}

}  // namespace

std::uint32_t ObjectReading::number() const {
  return canopen::get_number(bytes, bytes.size());
}

std::vector<Finding> judge(const CanObservation& seen, const CanConfig& config) {
  std::vector<Finding> findings = judge_bus(seen, config);
  if (canopen::bus_count(config.arm) == 1) return findings;
  for (Finding& finding : findings) {
    if (!finding.check.starts_with("axis ")) finding.check = format("bus %d ", seen.bus + 1) + finding.check;
  }
  return findings;
}

}  // namespace vergence::tools
