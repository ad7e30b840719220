#include "firmware_like/config/config_fields.hpp"

#include <linux/videodev2.h>

#include <array>
#include <cmath>
#include <numbers>
#include <string_view>

#include "algo/motion_limits.hpp"
#include "firmware_like/task_table.hpp"
#include "hal/canopen/bus_load.hpp"
#include "hal/clock.hpp"

namespace vergence {
namespace {

using C = ControllerConfig;
using P = Place;

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kMilli_ns = 1e6;
constexpr double kMicro_ns = 1e3;

constexpr std::size_t at(int i) {
  return static_cast<std::size_t>(i);
}

// ---- control ----------------------------------------------------------------------------------------------

// Kept as a rotation. Written one after the other, so that in between it may be any.
constexpr ConfigField target_orientation() {
  ConfigField field{"target_in_hand_e",
                    FieldKind::kNumber,
                    "how the target is to be turned, in the hand: vector part of the quaternion",
                    3,
                    -1,
                    1};
  field.get = [](const C& c, P p) { return to_pose(c.robot.relation.T_Ed_M).e[p.element]; };
  field.set = [](C& c, P p, double value) {
    Pose pose = to_pose(c.robot.relation.T_Ed_M);
    pose.e[p.element] = value;
    if (pose.e.norm() > 1) pose.e.normalize();
    c.robot.relation.T_Ed_M.R = to_transform(pose).R;
  };
  return field;
}

constexpr std::array kControl = {
    number("position_per_s", 0, 50, "K_PP [3.26]: the hand's error of position falls with this",
           [](C& c, P) -> double& { return c.robot.gains.position_per_s; }),
    number("position_rate", 0, 0.9, "K_VP [3.26], of the difference of velocities",
           [](C& c, P) -> double& { return c.robot.gains.position_rate; }),
    number("orientation_per_s", 0, 50, "K_PO [3.27], of half the angle",
           [](C& c, P) -> double& { return c.robot.gains.orientation_per_s; }),
    number("orientation_rate", 0, 0.9, "K_VO [3.27]",
           [](C& c, P) -> double& { return c.robot.gains.orientation_rate; }),
    number("feed_forward", 0, 1, "share of the target's own velocity the hand is given",
           [](C& c, P) -> double& { return c.robot.gains.feed_forward; }),
    number("joint_per_s", 0, 50, "K_PQ [3.31], of the held joints",
           [](C& c, P) -> double& { return c.robot.joint_servo.position_per_s; }),
    numbers("target_in_hand_mm", 3, -5000, 5000,
            "where the target is to be, in the hand: x right, y down, z ahead",
            [](C& c, P p) -> double& { return c.robot.relation.T_Ed_M.t_mm[p.element]; }),
    target_orientation(),
    flag("position_only", "the hand keeps its orientation and follows the position alone",
         [](C& c, P) -> bool& { return c.robot.relation.position_only; }),
    number(
        "release_offset_ms", 1, 500, "a frame's pose acts so long after its stamp, ready or not",
        [](C& c, P) -> std::int64_t& { return c.robot.release_offset_ns; }, kMilli_ns),
    number(
        "drive_lag_ms", 0, 500, "lag of the drives' velocity loop, which the hand is led by",
        [](C& c, P) -> std::int64_t& { return c.robot.drive_lag_ns; }, kMilli_ns),
    number(
        "believe_ms", 10, 10'000, "after the last sighting the target counts as lost",
        [](C& c, P) -> std::int64_t& { return c.robot.believe_ns; }, kMilli_ns),
    number("least_confidence", 0, 1, "of a sighting that is acted on",
           [](C& c, P) -> double& { return c.robot.least_confidence; }),
    number("position_noise_mm", 0.001, 100, "standard deviation of a sighting, each axis",
           [](C& c, P) -> double& { return c.robot.target_motion.position_noise_mm; }),
    number("rotation_noise_rad", 1e-5, 1, "standard deviation of a sighting, about each axis",
           [](C& c, P) -> double& { return c.robot.target_motion.rotation_noise_rad; }),
    number("jerk_mm_per_s3", 1, 1e6, "how abruptly the target is expected to move",
           [](C& c, P) -> double& { return c.robot.target_motion.jerk_mm_per_s3; }),
    number("angular_jerk_rad_per_s3", 0.01, 1e4, "how abruptly the target is expected to turn",
           [](C& c, P) -> double& { return c.robot.target_motion.angular_jerk_rad_per_s3; }),
    integer("seed", 0, 9'007'199'254'740'991, "of the genetic search",
            [](C& c, P) -> std::uint64_t& { return c.robot.tracker.seed; }),
};

// ---- limits -----------------------------------------------------------------------------------------------

constexpr std::array kLimits = {
    number("velocity_mm_per_s", 0.1, 5000, "of the tool's point",
           [](C& c, P) -> double& { return c.robot.hand_limits.linear_velocity_mm_per_s; }),
    number("angular_velocity_rad_per_s", 0.001, 20, "of the hand",
           [](C& c, P) -> double& { return c.robot.hand_limits.angular_velocity_rad_per_s; }),
    number("acceleration_mm_per_s2", 1, 50'000, "of the tool's point",
           [](C& c, P) -> double& { return c.robot.hand_limits.linear_acceleration_mm_per_s2; }),
    number("angular_acceleration_rad_per_s2", 0.01, 200, "of the hand",
           [](C& c, P) -> double& { return c.robot.hand_limits.angular_acceleration_rad_per_s2; }),
    numbers("box_min_mm", 3, -5000, 5000, "corner of the box the tool never leaves, in the world",
            [](C& c, P p) -> double& { return c.robot.hand_limits.box_min_mm[p.element]; }),
    numbers("box_max_mm", 3, -5000, 5000, "the opposite corner",
            [](C& c, P p) -> double& { return c.robot.hand_limits.box_max_mm[p.element]; }),
    number("least_distance_mm", 0, 5000, "of the tool to the target; 0: none",
           [](C& c, P) -> double& { return c.robot.hand_limits.least_distance_mm; }),
    numbers("tool_mm", 3, -2000, 2000, "the point all this holds for, in the hand",
            [](C& c, P p) -> double& { return c.robot.tool_mm[p.element]; }),
    number(
        "following_error_deg", 0.01, 90, "a joint farther than this from where it was sent: safe stop",
        [](C& c, P) -> double& { return c.robot.following_error_rad; }, kDegree),
};

constexpr std::array kHealth = {
    number(
        "arm_timeout_ms", 2, 1000, "without the drives' positions: they count as gone",
        [](C& c, P) -> std::int64_t& { return c.robot.arm_timeout_ns; }, kMilli_ns),
    number(
        "camera_timeout_ms", 50, 60'000, "without a pair of pictures: the cameras count as gone",
        [](C& c, P) -> std::int64_t& { return c.robot.camera_timeout_ns; }, kMilli_ns),
    integer("most_missed_deadlines", 1, 1000, "of the arm's task, in a row; one more: safe stop",
            [](C& c, P) -> int& { return c.robot.most_missed_deadlines; }),
};

// ---- arm --------------------------------------------------------------------------------------------------

constexpr std::array<const char*, 2> kCyclicModes = {"velocity", "position"};

// Two are told of it: the task and the bus.
constexpr ConfigField arm_period() {
  ConfigField field = integer("period_ms", 1, 2, "of SYNC and of the arm's task: 2 is 500 Hz, 1 is 1 kHz",
                              [](C& c, P) -> std::int64_t& { return c.robot.arm_period_ns; });
  field.scale = kMilli_ns;
  field.set = [](C& c, P, double value) {
    c.robot.arm_period_ns = std::llround(value);
    c.can.arm.sync_period_ns = c.robot.arm_period_ns;
  };
  return field;
}

constexpr std::array kCan = {
    flag("present", "there is an arm; without one, the hand stands still",
         [](C& c, P) -> bool& { return c.robot.has_arm; }),
    text("interface", "of the network: can0, vcan0",
         [](C& c, P) -> InterfaceText& { return c.can.interface; }),
    text("interface_2", "of a second bus, for the axes that say bus = 2; empty: there is none",
         [](C& c, P) -> InterfaceText& { return c.can.interface_2; }),
    arm_period(),
    flag("share_targets", "targets of two axes in one frame: less load, of drives that know dummy entries",
         [](C& c, P) -> bool& { return c.can.arm.share_targets; }),
    integer("bitrate_bit_per_s", 10'000, 1'000'000, "of each bus, for its load",
            [](C& c, P) -> std::int64_t& { return c.can.bitrate_bit_per_s; }),
    choice("mode", kCyclicModes, "cyclic synchronous velocity (CSV) or position (CSP) of CiA 402",
           [](C& c, P) -> canopen::CyclicMode& { return c.can.arm.mode; }),
    integer("master_node", 1, 127, "our own node, whose heartbeat the drives watch",
            [](C& c, P) -> std::uint8_t& { return c.can.arm.master_node_id; }),
    flag("read_homing", "ask the drives whether they are homed",
         [](C& c, P) -> bool& { return c.can.arm.read_homing; }),
    flag("must_be_homed", "a drive that is not homed is a fault",
         [](C& c, P) -> bool& { return c.can.arm.must_be_homed; }),
    number(
        "heartbeat_ms", 1, 1000, "of drives and master",
        [](C& c, P) -> std::int64_t& { return c.can.arm.heartbeat_ns; }, kMilli_ns),
    number(
        "heartbeat_timeout_ms", 2, 5000, "without a heartbeat: all axes stop",
        [](C& c, P) -> std::int64_t& { return c.can.arm.heartbeat_timeout_ns; }, kMilli_ns),
    number(
        "boot_timeout_ms", 100, 60'000, "until every drive must have booted",
        [](C& c, P) -> std::int64_t& { return c.can.arm.boot_timeout_ns; }, kMilli_ns),
    number(
        "sdo_timeout_ms", 10, 10'000, "for an answer while booting",
        [](C& c, P) -> std::int64_t& { return c.can.arm.sdo_timeout_ns; }, kMilli_ns),
    number(
        "enable_timeout_ms", 100, 60'000, "until every drive must be on; brakes are released meanwhile",
        [](C& c, P) -> std::int64_t& { return c.can.arm.enable_timeout_ns; }, kMilli_ns),
    number(
        "stop_timeout_ms", 10, 60'000, "a quick stop may take",
        [](C& c, P) -> std::int64_t& { return c.can.arm.stop_timeout_ns; }, kMilli_ns),
    integer("tolerated_missing_pdos", 0, 1, "positions that may be missing in a row",
            [](C& c, P) -> int& { return c.can.arm.tolerated_missing_pdos; }),
    integer("most_missed_commands", 1, 100,
            "periods without a command from the controller; one more: all stop",
            [](C& c, P) -> int& { return c.can.arm.most_missed_commands; }),
};

canopen::CanopenAxisConfig& axis(C& c, P p) {
  return c.can.arm.axis[at(p.instance)];
}

// Counted from 1, as people do.
constexpr ConfigField bus_of_axis() {
  ConfigField field{"bus", FieldKind::kInteger, "that the drive is on: 1 is interface, 2 interface_2"};
  field.low = 1;
  field.high = canopen::kMaxBuses;
  field.get = [](const C& c, P p) { return 1.0 + c.can.arm.axis[at(p.instance)].bus; };
  field.set = [](C& c, P p, double value) { axis(c, p).bus = static_cast<std::uint8_t>(value - 1); };
  return field;
}

constexpr std::array kAxis = {
    integer("node", 1, 127, "of the drive", [](C& c, P p) -> std::uint8_t& { return axis(c, p).node_id; }),
    bus_of_axis(),
    number(
        "counts_per_turn", -1e9, 1e9,
        "encoder counts of a whole turn of the joint, gear included; negative: it turns the other way",
        [](C& c, P p) -> double& { return axis(c, p).counts_per_rad; }, 0.5 / std::numbers::pi),
    integer("zero_counts", -2'147'483'648., 2'147'483'647, "where the joint's angle is zero",
            [](C& c, P p) -> std::int32_t& { return axis(c, p).zero_counts; }),
    number(
        "velocity_units_per_turn_per_s", -1e9, 1e9,
        "units of object 0x60FF for a turn of the joint a second; left out: counts_per_turn",
        [](C& c, P p) -> double& { return axis(c, p).velocity_units_per_rad_per_s; }, 0.5 / std::numbers::pi),
    number("quick_stop_rad_per_s2", 0.1, 1000, "deceleration of the drive's quick stop",
           [](C& c, P p) -> double& { return axis(c, p).quick_stop_rad_per_s2; }),
    number(
        "following_error_deg", 0.01, 90, "a joint farther than this from where it was sent: all axes stop",
        [](C& c, P p) -> double& { return axis(c, p).following_error_rad; }, kDegree),
    integer("vendor", 0, 4'294'967'295., "object 0x1018:01 must be this; 0: any",
            [](C& c, P p) -> std::uint32_t& { return axis(c, p).vendor_id; }),
};

// ---- cameras ----------------------------------------------------------------------------------------------

constexpr std::array<const char*, 2> kEyes = {"left", "right"};
constexpr std::array<const char*, 4> kPixelFormats = {"YUYV", "UYVY", "NV12", "RGB24"};
constexpr std::array<std::uint32_t, 4> kFourccs = {V4L2_PIX_FMT_YUYV, V4L2_PIX_FMT_UYVY, V4L2_PIX_FMT_NV12,
                                                   V4L2_PIX_FMT_RGB24};
constexpr std::array<const char*, 3> kMemories = {"mmap", "dmabuf", "userptr"};
constexpr std::array<const char*, 3> kControlModes = {"leave", "set", "auto_then_lock"};

v4l2::VideoConfig& eye(C& c, P p) {
  return c.cameras.eyes[at(p.instance)];
}
const v4l2::VideoConfig& eye(const C& c, P p) {
  return c.cameras.eyes[at(p.instance)];
}

constexpr ConfigField pixel_format() {
  ConfigField field{"format", FieldKind::kChoice, "of the pixels, as the camera gives them"};
  field.choices = kPixelFormats;
  field.high = static_cast<double>(kFourccs.size()) - 1;
  field.get = [](const C& c, P p) {
    double found = -1;
    for (std::size_t i = 0; i < kFourccs.size(); ++i) {
      if (kFourccs[i] == eye(c, p).fourcc) found = static_cast<double>(i);
    }
    return found;
  };
  field.set = [](C& c, P p, double value) { eye(c, p).fourcc = kFourccs[static_cast<std::size_t>(value)]; };
  return field;
}

constexpr ConfigField frame_rate() {
  ConfigField field{"frames_per_s", FieldKind::kInteger, "0: as the camera has it"};
  field.high = 1000;
  field.get = [](const C& c, P p) { return static_cast<double>(eye(c, p).interval.denominator); };
  field.set = [](C& c, P p, double value) {
    eye(c, p).interval = {value > 0 ? 1U : 0U, static_cast<std::uint32_t>(value)};
  };
  return field;
}

template <v4l2::ControlRole kRole>
constexpr ConfigField control_mode(const char* key) {
  return choice(key, kControlModes, "leave it, set it to the value, or let the camera find one and lock that",
                [](C& c, P p) -> v4l2::ControlMode& {
                  return eye(c, p).controls[static_cast<std::size_t>(kRole)].mode;
                });
}
template <v4l2::ControlRole kRole>
constexpr ConfigField control_value(const char* key, const char* meaning) {
  return integer(key, -2'147'483'648., 2'147'483'647, meaning, [](C& c, P p) -> std::int32_t& {
    return eye(c, p).controls[static_cast<std::size_t>(kRole)].value;
  });
}

constexpr std::array kCamera = {
    text("device", "a path that survives unplugging, as those in /dev/v4l/by-path",
         [](C& c, P p) -> std::array<char, v4l2::kMaxVideoPath>& { return eye(c, p).path; }),
    integer("input", -1, 31, "of the device; -1: as it is",
            [](C& c, P p) -> int& { return eye(c, p).input; }),
    flag("dv_timings", "take over the timings of an HDMI, DVI or SDI source",
         [](C& c, P p) -> bool& { return eye(c, p).dv_timings; }),
    pixel_format(),
    frame_rate(),
    choice("memory", kMemories, "who owns the pictures' memory",
           [](C& c, P p) -> v4l2::BufferMemory& { return eye(c, p).memory; }),
    integer("buffers", v4l2::kMinVideoBuffers, v4l2::kMaxVideoBuffers, "pictures in flight",
            [](C& c, P p) -> int& { return eye(c, p).buffers; }),
    control_mode<v4l2::ControlRole::kExposure>("exposure"),
    control_value<v4l2::ControlRole::kExposure>("exposure_100us", "in units of 100 us"),
    control_mode<v4l2::ControlRole::kGain>("gain"),
    control_value<v4l2::ControlRole::kGain>("gain_value", "in the driver's units"),
    control_mode<v4l2::ControlRole::kWhiteBalance>("white_balance"),
    control_value<v4l2::ControlRole::kWhiteBalance>("white_balance_K", "colour temperature"),
    control_mode<v4l2::ControlRole::kRedBalance>("red_balance"),
    control_value<v4l2::ControlRole::kRedBalance>("red_balance_value", "of cameras that have no temperature"),
    control_mode<v4l2::ControlRole::kBlueBalance>("blue_balance"),
    control_value<v4l2::ControlRole::kBlueBalance>("blue_balance_value",
                                                   "of cameras that have no temperature"),
    control_mode<v4l2::ControlRole::kFocus>("focus"),
    control_value<v4l2::ControlRole::kFocus>("focus_value", "in the driver's units"),
    number(
        "settle_ms", 0, 60'000, "what auto_then_lock gets",
        [](C& c, P p) -> std::int64_t& { return eye(c, p).settle_ns; }, kMilli_ns),
    number(
        "stamp_to_mid_exposure_ms", -1000, 1000, "added to the driver's stamp",
        [](C& c, P p) -> std::int64_t& { return eye(c, p).stamp_to_mid_exposure_ns; }, kMilli_ns),
    number(
        "stall_ms", 20, 10'000, "without a good picture: the stream is restarted",
        [](C& c, P p) -> std::int64_t& { return eye(c, p).stall_ns; }, kMilli_ns),
    number(
        "first_frame_ms", 20, 60'000, "the same, until the first picture",
        [](C& c, P p) -> std::int64_t& { return eye(c, p).first_frame_ns; }, kMilli_ns),
    number(
        "give_up_ms", 100, 600'000, "of trouble, until it is a fault",
        [](C& c, P p) -> std::int64_t& { return eye(c, p).give_up_ns; }, kMilli_ns),
};

constexpr std::array kPairing = {
    number(
        "max_skew_ms", 0.001, 1000, "between the stamps of a pair",
        [](C& c, P) -> std::int64_t& { return c.cameras.max_skew_ns; }, kMilli_ns),
};

// ---- eyes -------------------------------------------------------------------------------------------------

constexpr std::array<const char*, 3> kMotors = {"tilt", "pan_right", "pan_left"};
constexpr std::array<const char*, 3> kEndActions = {"none", "fault", "home"};

step::MotorConfig& motor(C& c, P p) {
  return c.motors.motors[at(p.instance)];
}
JointLimits& eye_limits(C& c, P p) {
  return c.robot.eye_limits[at(p.instance)];
}

constexpr std::array kEyeMount = {
    flag("present", "the cameras turn; without, they stand as the rig file says",
         [](C& c, P) -> bool& { return c.robot.has_eyes; }),
    number("half_baseline_mm", 1, 5000, "half the distance of the pan axes",
           [](C& c, P) -> double& { return c.robot.mount.half_baseline_mm; }),
    number("tilt_axis_y_mm", -5000, 5000, "of the tilt axis in the hand",
           [](C& c, P) -> double& { return c.robot.mount.tilt_axis_y_mm; }),
    number("tilt_axis_z_mm", -5000, 5000, "of the tilt axis in the hand",
           [](C& c, P) -> double& { return c.robot.mount.tilt_axis_z_mm; }),
    number("gain_per_period", 0.001, 1, "K_P [3.35]: share of the error made good in a period",
           [](C& c, P) -> double& { return c.robot.eye_control.gain_per_period; }),
    text("step_chip", "label of the GPIO chip of all step and direction lines",
         [](C& c, P) -> step::GpioName& { return c.lines.outputs_chip; }),
    text("enable_chip", "label of the chip of the enable line",
         [](C& c, P) -> step::GpioName& { return c.lines.enable_chip; }),
    text("enable_line", "name of the line that switches the drives on",
         [](C& c, P) -> step::GpioName& { return c.lines.enable.name; }),
    flag("enable_inverted", "low is on", [](C& c, P) -> bool& { return c.lines.enable.inverted; }),
    text("switch_chip", "label of the chip of the end switches",
         [](C& c, P) -> step::GpioName& { return c.lines.inputs_chip; }),
    number(
        "poll_us", 10, 100'000, "how often switches are read",
        [](C& c, P) -> std::int64_t& { return c.motors.poll_ns; }, kMicro_ns),
    number(
        "settle_ms", 0, 10'000, "from the enable line to the first pulse",
        [](C& c, P) -> std::int64_t& { return c.motors.settle_ns; }, kMilli_ns),
};

constexpr std::array kMotor = {
    number(
        "steps_per_turn", 1, 1e7, "of the eye, gear and microsteps included",
        [](C& c, P p) -> double& { return c.robot.eye_control.steps_per_rad[at(p.instance)]; },
        0.5 / std::numbers::pi),
    number(
        "min_deg", -180, 180, "end of the range",
        [](C& c, P p) -> double& { return eye_limits(c, p).min_rad; }, kDegree),
    number(
        "max_deg", -180, 180, "end of the range",
        [](C& c, P p) -> double& { return eye_limits(c, p).max_rad; }, kDegree),
    number("velocity_rad_per_s", 0.001, 100, "of the eye",
           [](C& c, P p) -> double& { return eye_limits(c, p).velocity_rad_per_s; }),
    number("acceleration_rad_per_s2", 0.01, 1e5, "of the eye",
           [](C& c, P p) -> double& { return eye_limits(c, p).acceleration_rad_per_s2; }),
    number("jerk_rad_per_s3", 0.1, 1e8, "of the eye",
           [](C& c, P p) -> double& { return eye_limits(c, p).jerk_rad_per_s3; }),
    text("step_line", "name of the line",
         [](C& c, P p) -> step::GpioName& { return c.lines.outputs[at(2 * p.instance)].name; }),
    flag("step_inverted", "low is active",
         [](C& c, P p) -> bool& { return c.lines.outputs[at(2 * p.instance)].inverted; }),
    text("direction_line", "name of the line",
         [](C& c, P p) -> step::GpioName& { return c.lines.outputs[at(2 * p.instance + 1)].name; }),
    flag("direction_inverted", "low is the positive direction",
         [](C& c, P p) -> bool& { return c.lines.outputs[at(2 * p.instance + 1)].inverted; }),
    text("low_switch", "name of the line of the switch at the low end; empty: there is none",
         [](C& c, P p) -> step::GpioName& { return c.lines.inputs[at(2 * p.instance)].name; }),
    flag("low_switch_inverted", "low is pressed",
         [](C& c, P p) -> bool& { return c.lines.inputs[at(2 * p.instance)].inverted; }),
    choice("low_end", kEndActions, "what the switch at the low end means",
           [](C& c, P p) -> step::EndAction& { return motor(c, p).low_end; }),
    text("high_switch", "name of the line of the switch at the high end; empty: there is none",
         [](C& c, P p) -> step::GpioName& { return c.lines.inputs[at(2 * p.instance + 1)].name; }),
    flag("high_switch_inverted", "low is pressed",
         [](C& c, P p) -> bool& { return c.lines.inputs[at(2 * p.instance + 1)].inverted; }),
    choice("high_end", kEndActions, "what the switch at the high end means",
           [](C& c, P p) -> step::EndAction& { return motor(c, p).high_end; }),
    integer("home_steps", -1e9, 1e9, "position at the home switch",
            [](C& c, P p) -> std::int64_t& { return motor(c, p).home_steps; }),
    integer("home_tolerance_steps", 0, 1e9, "home found farther off than this: steps were lost",
            [](C& c, P p) -> std::int64_t& { return motor(c, p).home_tolerance_steps; }),
    number(
        "steplen_us", 0.1, 100'000, "step line active, at least",
        [](C& c, P p) -> std::int64_t& { return motor(c, p).timing.steplen_ns; }, kMicro_ns),
    number(
        "stepspace_us", 0.1, 100'000, "step line at rest, at least",
        [](C& c, P p) -> std::int64_t& { return motor(c, p).timing.stepspace_ns; }, kMicro_ns),
    number(
        "dirsetup_us", 0, 100'000, "direction unchanged before a step, at least",
        [](C& c, P p) -> std::int64_t& { return motor(c, p).timing.dirsetup_ns; }, kMicro_ns),
    number(
        "dirhold_us", 0, 100'000, "direction unchanged after a step, at least",
        [](C& c, P p) -> std::int64_t& { return motor(c, p).timing.dirhold_ns; }, kMicro_ns),
    number(
        "jitter_us", 0, 10'000, "of this machine's edges, as `vergence bench rt` measures it",
        [](C& c, P p) -> std::int64_t& { return motor(c, p).timing.jitter_ns; }, kMicro_ns),
    number(
        "max_rate_steps_per_s", 0.001, 1e6, "no faster, whatever is asked for",
        [](C& c, P p) -> std::int64_t& { return motor(c, p).timing.max_rate_millisteps_per_s; },
        step::kMillistepsPerStep),
    number(
        "ramp_us", 1, 10'000, "the rate changes so often while it changes",
        [](C& c, P p) -> std::int64_t& { return motor(c, p).timing.ramp_ns; }, kMicro_ns),
    number(
        "ramp_steps_per_s2", 0.001, 1e8, "and this quickly; no slower than acceleration_rad_per_s2",
        [](C& c, P p) -> std::int64_t& { return motor(c, p).timing.acceleration_millisteps_per_s2; },
        step::kMillistepsPerStep),
};

// ---- the program ------------------------------------------------------------------------------------------

constexpr std::array<const char*, 2> kPolicies = {"fifo", "deadline"};

template <TaskId kTask>
constexpr ConfigField core(const char* key, const char* meaning) {
  return integer(key, 0, 1023, meaning,
                 [](C& c, P) -> int& { return c.runtime.core[static_cast<std::size_t>(kTask)]; });
}

constexpr std::array kRuntime = {
    choice("policy", kPolicies, "SCHED_FIFO, or SCHED_DEADLINE for the arm's task",
           [](C& c, P) -> SchedulingPolicy& { return c.runtime.policy; }),
    core<TaskId::kArm>("core_arm", "the arm's task is pinned to it; keep it isolated"),
    core<TaskId::kEyes>("core_eyes", "of the eyes' task"),
    core<TaskId::kVision>("core_vision", "of the vision task"),
    core<TaskId::kCapture>("core_capture", "of the thread that waits for the cameras"),
    core<TaskId::kSteps>("core_steps", "of the thread that makes step pulses"),
    text("command_socket", "where commands are taken",
         [](C& c, P) -> PathText& { return c.runtime.command_socket; }),
    text("telemetry", "name of the shared memory, as shm_open() wants it",
         [](C& c, P) -> PathText& { return c.runtime.telemetry; }),
    text("black_box", "the file's name, to which a number is added",
         [](C& c, P) -> PathText& { return c.runtime.black_box; }),
};

constexpr std::array kSections = {
    ConfigSection{"control", "how the hand follows the target", {}, 0, kControl},
    ConfigSection{"limits", "what the hand is never allowed", {}, 0, kLimits},
    ConfigSection{"health", "when devices and deadlines count as lost", {}, 0, kHealth},
    ConfigSection{"can", "the arm's drives", {}, 0, kCan},
    ConfigSection{"can.axis", "one for each joint, from the base", {}, kMaxJoints, kAxis},
    ConfigSection{"cameras", "the two together", {}, 0, kPairing},
    ConfigSection{"cameras", "each of them; what both share may stand in [cameras]", kEyes, 0, kCamera},
    ConfigSection{"eyes", "the mount of the cameras", {}, 0, kEyeMount},
    ConfigSection{"eyes", "each motor; what all share may stand in [eyes]", kMotors, 0, kMotor},
    ConfigSection{"runtime", "how the program runs", {}, 0, kRuntime},
};

bool is_beyond(double rate, std::int64_t most_millisteps_per_s) {
  return rate * step::kMillistepsPerStep > static_cast<double>(most_millisteps_per_s) * (1 + 1e-9);
}

ConfigConflict find_eye_conflict(const C& c) {
  for (std::size_t i = 0; i < kEyeMotors; ++i) {
    const step::StepTiming& timing = c.motors.motors[i].timing;
    if (const step::TimingError error = step::check(timing); error != step::TimingError::kNone) {
      return {"eyes", kMotors[i], step::describe(error)};
    }
    const JointLimits& limits = c.robot.eye_limits[i];
    if (!(limits.min_rad < limits.max_rad)) return {"eyes", kMotors[i], "min_deg is not below max_deg"};
    if (check(limits, seconds(task(TaskId::kEyes).period_ns)) != Status::kOk) {
      return {"eyes", kMotors[i],
              "jerk_rad_per_s3 is too low: acceleration_rad_per_s2 would hardly ever be reached"};
    }
    const double steps_per_rad = c.robot.eye_control.steps_per_rad[i];
    if (is_beyond(limits.velocity_rad_per_s * steps_per_rad, timing.max_rate_millisteps_per_s)) {
      return {"eyes", kMotors[i],
              "velocity_rad_per_s is more than max_rate_steps_per_s: lower it, or use fewer microsteps"};
    }
    if (is_beyond(limits.acceleration_rad_per_s2 * steps_per_rad, timing.acceleration_millisteps_per_s2)) {
      return {"eyes", kMotors[i], "acceleration_rad_per_s2 is more than ramp_steps_per_s2"};
    }
    // A switch that is not wired is never pressed, and nobody would notice.
    const step::MotorConfig& motor = c.motors.motors[i];
    const bool low_missing = motor.low_end != step::EndAction::kNone && c.lines.inputs[2 * i].name[0] == '\0';
    const bool high_missing =
        motor.high_end != step::EndAction::kNone && c.lines.inputs[2 * i + 1].name[0] == '\0';
    if (low_missing || high_missing) {
      return {"eyes", kMotors[i], "an end has an action but no switch: name its line, or say none"};
    }
  }
  return {};
}

// Interfaces and the axes' buses.
ConfigConflict find_bus_conflict(const C& c) {
  const bool has_second = c.can.interface_2[0] != '\0';
  const bool uses_second = canopen::bus_count(c.can.arm) > 1;
  if (uses_second && !has_second) {
    return {"can", "interface_2", "an axis is on bus 2, which has no interface: name it, or say bus = 1"};
  }
  if (has_second && !uses_second) {
    return {"can", "interface_2", "no axis is on it: say bus = 2 at those that are, or leave it out"};
  }
  if (has_second && std::string_view(c.can.interface.data()) == c.can.interface_2.data()) {
    return {"can", "interface_2", "is that of the first bus as well: the two must differ"};
  }
  return {};
}

ConfigConflict find_arm_conflict(const C& c) {
  if (c.can.arm.axes != c.robot.arm.joints) {
    return {"can", "axis", "there must be as many [[can.axis]] as the arm has joints"};
  }
  if (c.can.arm.sync_period_ns != c.robot.arm_period_ns) {
    return {"can", "period_ms", "SYNC must have the period of the arm's task"};
  }
  const canopen::ConfigResult found = canopen::check(c.can.arm);
  if (found.finding != canopen::ConfigFinding::kNone)
    return {"can", "axis", canopen::describe(found.finding)};
  if (const ConfigConflict conflict = find_bus_conflict(c); conflict.problem[0] != '\0') return conflict;
  for (int bus = 0; bus < canopen::bus_count(c.can.arm); ++bus) {
    if (canopen::bus_load_permille(c.can.arm, bus, c.can.bitrate_bit_per_s) >
        canopen::kMostBusLoad_permille) {
      return {"can", "bitrate_bit_per_s",
              bus == 0
                  ? "the first bus would be loaded by more than 80 %: take a faster one, period_ms = 2, "
                    "share_targets = true, or fewer drives a bus"
                  : "the second bus would be loaded by more than 80 %: take a faster one, period_ms = 2, "
                    "share_targets = true, or fewer drives a bus"};
    }
  }
  return {};
}

}  // namespace

std::span<const ConfigSection> config_sections() {
  return kSections;
}

bool is_in_range(const ConfigField& field, double kept) {
  if (!std::isfinite(kept)) return false;
  // A little beyond: scaling rounds.
  const double slack = 1e-9 * (std::abs(field.low) + std::abs(field.high));
  const double written = kept / field.scale;
  if (written < field.low - slack || written > field.high + slack) return false;
  const bool whole = field.kind != FieldKind::kNumber;
  return !whole || kept == std::floor(kept);
}

ConfigConflict find_conflict(const ControllerConfig& config) {
  if (config.robot.has_arm) {
    if (const ConfigConflict found = find_arm_conflict(config); found.problem[0] != '\0') return found;
  }
  if (config.robot.has_eyes) {
    if (const ConfigConflict found = find_eye_conflict(config); found.problem[0] != '\0') return found;
  }
  const HandLimits& limits = config.robot.hand_limits;
  if (!(limits.box_min_mm.array() < limits.box_max_mm.array()).all()) {
    return {"limits", "box_max_mm", "is not above box_min_mm in every axis"};
  }
  for (std::size_t i = 0; i < 2; ++i) {
    if (config.cameras.eyes[i].path[0] == '\0') return {"cameras", kEyes[i], "device is not set"};
  }
  return {};
}

}  // namespace vergence
