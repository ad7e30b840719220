#include "tools/bringup/ask_drives.hpp"

#include <algorithm>
#include <cstddef>

#include "hal/canopen/axis_pdos.hpp"
#include "hal/canopen/bytes.hpp"
#include "hal/canopen/emergency.hpp"
#include "hal/canopen/objects.hpp"
#include "hal/canopen/sdo_client.hpp"

namespace vergence::tools {
namespace {

using canopen::CanFrame;

constexpr std::int64_t kTick_ns = 200'000;
constexpr std::int64_t kScanPause_ns = 1'000'000;  // between two nodes: a bus of 125 kbit/s keeps up
constexpr std::int64_t kScanPatience_ns = 100'000'000;
constexpr int kMostFrames = 1000;   // a tick
constexpr int kMostUnanswered = 3;  // then a drive is left alone

CanFrame who_are_you(std::uint8_t node) {
  CanFrame frame;
  frame.id = canopen::kSdoRequestCobId + node;
  frame.size = 8;
  frame.data[0] = 0x40;
  canopen::put_number(std::span(frame.data).subspan(1), 2, canopen::kDeviceType);
  return frame;
}

// Process data of a configured axis: nothing, from it, or to it.
enum class AxisData : std::uint8_t {
  kNone,
  kFeedback,
  kCommand,
};

AxisData axis_data(std::uint32_t id, const canopen::CanopenArmConfig& config, int bus) {
  for (int i = 0; i < config.axes; ++i) {
    if (config.axis[static_cast<std::size_t>(i)].bus != bus) continue;
    const canopen::AxisPdos pdos = canopen::axis_pdos(config, i);
    if (id == pdos.position.cob_id || id == pdos.statusword.cob_id) return AxisData::kFeedback;
    if (id == pdos.target.cob_id || id == pdos.controlword.cob_id) return AxisData::kCommand;
  }
  return AxisData::kNone;
}

class Asker {
 public:
  Asker(ReadOnlyBus& bus, const canopen::CanopenArmConfig& config, int number)
      : bus_(&bus), config_(&config) {
    seen_.bus = number;
  }

  [[nodiscard]] CanObservation ask(double seconds) {
    wait(static_cast<std::int64_t>(seconds * 1e9));
    scan();
    for (int i = 0; i < config_->axes; ++i) ask_drive(config_->axis[static_cast<std::size_t>(i)]);
    seen_.health = bus_->health();
    return std::move(seen_);
  }

 private:
  // One turn: what came is noted, what is due is sent, and time passes.
  void tick(canopen::SdoClient* client = nullptr) {
    const std::int64_t now = bus_->now_ns();
    bus_->process(now);
    CanFrame frame;
    for (int i = 0; i < kMostFrames && bus_->receive(frame); ++i) {
      note(frame, now);
      if (client == nullptr) continue;
      const bool was_busy = client->state() == canopen::SdoState::kBusy;
      client->receive(frame, now);
      if (was_busy && client->state() != canopen::SdoState::kBusy) {
        answered_ns_ = frame.stamp_ns != 0 ? frame.stamp_ns : now;
      }
    }
    if (client != nullptr) {
      client->process(now, canopen::FrameSink(*bus_));
    }
    bus_->sleep_until(now + kTick_ns);
  }
  void wait(std::int64_t span_ns) {
    for (const std::int64_t until = bus_->now_ns() + span_ns; bus_->now_ns() < until;) tick();
  }

  void note(const CanFrame& frame, std::int64_t now) {
    if (frame.is_error || frame.is_remote) return;
    const std::int64_t stamp = frame.stamp_ns != 0 ? frame.stamp_ns : now;
    if (frame.id == canopen::kNmtCobId || frame.id == canopen::kSyncCobId) {
      ++seen_.foreign_commands;
      return;
    }
    const AxisData data = axis_data(frame.id, *config_, seen_.bus);
    if (data == AxisData::kCommand) ++seen_.foreign_commands;
    if (data != AxisData::kNone) return;
    HeardNode& node = seen_.heard[frame.id & 0x7F];
    switch (frame.id & ~0x7FU) {
      case canopen::kEmergencyCobId: {
        canopen::Emergency emergency;
        const auto id = static_cast<std::uint8_t>(frame.id & 0x7F);
        if (canopen::decode_emergency(frame, id, emergency)) node.emergency = emergency.code;
        return;
      }
      case canopen::kSdoRequestCobId: ++seen_.foreign_commands; return;
      case canopen::kSdoResponseCobId: seen_.found[frame.id & 0x7F] = true; return;
      case canopen::kHeartbeatCobId: note_heartbeat(frame, stamp, node); return;
      case 0x180:
      case 0x280:
      case 0x380:
      case 0x480: ++node.others; return;
      default: return;
    }
  }

  static void note_heartbeat(const CanFrame& frame, std::int64_t stamp, HeardNode& node) {
    if (frame.size != 1) return;
    node.state = canopen::decode_nmt_state(frame.data[0]);
    if (node.state == canopen::NmtState::kBootUp) {
      ++node.boots;
      return;
    }
    if (node.heartbeats == 0) node.first_ns = stamp;
    node.last_ns = stamp;
    ++node.heartbeats;
  }

  // Everyone once; who answers is noted as it comes.
  void scan() {
    for (int node = 1; node <= canopen::kMaxNodeId; ++node) {
      (void)bus_->send(who_are_you(static_cast<std::uint8_t>(node)));
      wait(kScanPause_ns);
    }
    wait(kScanPatience_ns);
  }

  [[nodiscard]] ObjectReading read(canopen::SdoClient& client, std::uint16_t index, std::uint8_t sub) {
    ObjectReading reading;
    const std::int64_t begun = bus_->now_ns();
    answered_ns_ = begun;
    if (!client.read(index, sub, begun)) return reading;
    while (client.state() == canopen::SdoState::kBusy) tick(&client);
    round_trip_ns_ = std::max<std::int64_t>(answered_ns_ - begun, 0);
    if (client.state() == canopen::SdoState::kDone) {
      reading.state = ObjectReading::State::kRead;
      reading.bytes.assign(client.bytes().begin(), client.bytes().end());
      return reading;
    }
    reading.abort_code = client.abort_code();
    reading.state = reading.abort_code == canopen::kAbortTimeout ? ObjectReading::State::kNoAnswer
                                                                 : ObjectReading::State::kRefused;
    return reading;
  }

  void ask_drive(const canopen::CanopenAxisConfig& axis) {
    DriveObservation& drive = seen_.drives.emplace_back();
    if (axis.bus != seen_.bus) return;
    canopen::SdoClient client;
    client.init(axis.node_id, config_->sdo_timeout_ns);
    drive.device_type = read(client, canopen::kDeviceType, 0);
    if (!drive.answers()) return;
    drive.vendor = read(client, canopen::kIdentity, 1);
    drive.name = read(client, canopen::kDeviceName, 0);
    drive.heartbeat_ms = read(client, canopen::kHeartbeatProducer, 0);
    drive.error_register = read(client, canopen::kErrorRegister, 0);
    for (int i = 0; i < kRoundTrips && drive.unanswered < kMostUnanswered; ++i) {
      if (read(client, canopen::kStatusword, 0).state == ObjectReading::State::kNoAnswer) {
        ++drive.unanswered;
      } else {
        drive.round_trips_ns.push_back(round_trip_ns_);
      }
    }
    drive.statusword = read(client, canopen::kStatusword, 0);
    drive.position = read(client, canopen::kPositionActual, 0);
  }

  ReadOnlyBus* bus_;
  const canopen::CanopenArmConfig* config_;
  CanObservation seen_;
  std::int64_t answered_ns_ = 0;
  std::int64_t round_trip_ns_ = 0;
};

}  // namespace

CanObservation ask_drives(ReadOnlyBus& bus, const canopen::CanopenArmConfig& config, double seconds,
                          int number) {
  return Asker(bus, config, number).ask(seconds);
}

}  // namespace vergence::tools
