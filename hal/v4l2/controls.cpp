#include "hal/v4l2/controls.hpp"

#include <linux/videodev2.h>

#include <cerrno>

namespace vergence::v4l2 {
namespace {

// How a role is spelt in the kernel's controls: the automatic, its settings for off and on, and the value.
// A second choice where drivers differ; equal to the first where they do not.
struct Spelling {
  std::uint32_t automatic;
  std::int32_t off;
  std::array<std::int32_t, 2> on;
  std::array<std::uint32_t, 2> value;
};

constexpr std::array<Spelling, kControlRoles> kSpellings = {{
    {V4L2_CID_EXPOSURE_AUTO,
     V4L2_EXPOSURE_MANUAL,
     {V4L2_EXPOSURE_APERTURE_PRIORITY, V4L2_EXPOSURE_AUTO},
     {V4L2_CID_EXPOSURE_ABSOLUTE, V4L2_CID_EXPOSURE}},
    {V4L2_CID_AUTOGAIN, 0, {1, 1}, {V4L2_CID_GAIN, V4L2_CID_ANALOGUE_GAIN}},
    {V4L2_CID_AUTO_WHITE_BALANCE,
     0,
     {1, 1},
     {V4L2_CID_WHITE_BALANCE_TEMPERATURE, V4L2_CID_WHITE_BALANCE_TEMPERATURE}},
    {V4L2_CID_AUTO_WHITE_BALANCE, 0, {1, 1}, {V4L2_CID_RED_BALANCE, V4L2_CID_RED_BALANCE}},
    {V4L2_CID_AUTO_WHITE_BALANCE, 0, {1, 1}, {V4L2_CID_BLUE_BALANCE, V4L2_CID_BLUE_BALANCE}},
    {V4L2_CID_FOCUS_AUTO, 0, {1, 1}, {V4L2_CID_FOCUS_ABSOLUTE, V4L2_CID_FOCUS_ABSOLUTE}},
}};

struct Driver {
  VideoSystem& system;
  int handle;

  // Whether the device has the control, and its range. Only a plain "no" means that it has not.
  int query(std::uint32_t id, bool& exists, v4l2_queryctrl& range) {
    range = {};
    range.id = id;
    const int e = system.control(handle, VIDIOC_QUERYCTRL, &range);
    exists = e == 0 && (range.flags & V4L2_CTRL_FLAG_DISABLED) == 0;
    return e == EINVAL || e == ENOTTY ? 0 : e;
  }
  int set(std::uint32_t id, std::int32_t value) {
    v4l2_control control{id, value};
    return system.control(handle, VIDIOC_S_CTRL, &control);
  }
  int get(std::uint32_t id, std::int32_t& value) {
    v4l2_control control{id, 0};
    const int e = system.control(handle, VIDIOC_G_CTRL, &control);
    if (e == 0) value = control.value;
    return e;
  }
};

VideoError find(Driver driver, const Spelling& spelling, v4l2_queryctrl& range) {
  for (const std::uint32_t id : spelling.value) {
    bool exists = false;
    if (const int e = driver.query(id, exists, range); e != 0) return {VideoFault::kControlRefused, e, id};
    if (exists) return {};
  }
  return {VideoFault::kControlMissing, 0, spelling.value[0]};
}

VideoError hold(Driver driver, std::uint32_t id, std::int32_t value) {
  if (const int e = driver.set(id, value); e != 0) return {VideoFault::kControlRefused, e, id, value, 0};
  std::int32_t got = 0;
  if (const int e = driver.get(id, got); e != 0) return {VideoFault::kControlRefused, e, id, value, 0};
  if (got != value) return {VideoFault::kControlNotHeld, 0, id, value, got};
  return {};
}

VideoError switch_off_automatic(Driver driver, const Spelling& spelling) {
  bool exists = false;
  v4l2_queryctrl range{};
  if (const int e = driver.query(spelling.automatic, exists, range); e != 0)
    return {VideoFault::kControlRefused, e, spelling.automatic};
  return exists ? hold(driver, spelling.automatic, spelling.off) : VideoError{};
}

// Keeps the camera from making the frame interval longer in the dark; few have it.
VideoError hold_frame_rate(Driver driver) {
  bool exists = false;
  v4l2_queryctrl range{};
  if (const int e = driver.query(V4L2_CID_EXPOSURE_AUTO_PRIORITY, exists, range); e != 0)
    return {VideoFault::kControlRefused, e, V4L2_CID_EXPOSURE_AUTO_PRIORITY};
  return exists ? hold(driver, V4L2_CID_EXPOSURE_AUTO_PRIORITY, 0) : VideoError{};
}

VideoError hold_role(Driver driver, std::size_t role, const v4l2_queryctrl& range, std::int32_t value) {
  if (value < range.minimum) return {VideoFault::kControlRange, 0, range.id, value, range.minimum};
  if (value > range.maximum) return {VideoFault::kControlRange, 0, range.id, value, range.maximum};
  VideoError error = switch_off_automatic(driver, kSpellings[role]);
  if (is_ok(error) && role == static_cast<std::size_t>(ControlRole::kExposure))
    error = hold_frame_rate(driver);
  if (is_ok(error)) error = hold(driver, range.id, value);
  return error;
}

}  // namespace

void Controls::configure(const std::array<ControlSetting, kControlRoles>& settings) {
  for (std::size_t i = 0; i < roles_.size(); ++i)
    roles_[i] = {settings[i], settings[i].mode == ControlMode::kSet, false, settings[i].value};
}

bool Controls::needs_settling() const {
  for (const Held& role : roles_)
    if (role.setting.mode == ControlMode::kAutoThenLock && !role.is_known) return true;
  return false;
}

VideoError Controls::begin(VideoSystem& system, int handle) {
  Driver driver{system, handle};
  // What is known comes first: what the automatics find depends on it.
  for (std::size_t i = 0; i < roles_.size(); ++i) {
    if (roles_[i].setting.mode == ControlMode::kLeave || !roles_[i].is_known) continue;
    v4l2_queryctrl range{};
    VideoError error = find(driver, kSpellings[i], range);
    if (is_ok(error)) error = hold_role(driver, i, range, roles_[i].value);
    if (!is_ok(error)) return error;
  }
  for (std::size_t i = 0; i < roles_.size(); ++i) {
    if (roles_[i].setting.mode != ControlMode::kAutoThenLock || roles_[i].is_known) continue;
    const Spelling& spelling = kSpellings[i];
    bool exists = false;
    v4l2_queryctrl range{};
    if (const int e = driver.query(spelling.automatic, exists, range); e != 0)
      return {VideoFault::kControlRefused, e, spelling.automatic};
    if (!exists) return {VideoFault::kControlMissing, 0, spelling.automatic};
    VideoError error = hold(driver, spelling.automatic, spelling.on[0]);
    if (!is_ok(error)) error = hold(driver, spelling.automatic, spelling.on[1]);
    if (!is_ok(error)) return error;
  }
  return {};
}

VideoError Controls::lock(VideoSystem& system, int handle) {
  Driver driver{system, handle};
  // All that was found is read before any automatic is switched off: some share one.
  std::array<v4l2_queryctrl, kControlRoles> ranges{};
  for (std::size_t i = 0; i < roles_.size(); ++i) {
    Held& role = roles_[i];
    role.is_held = false;
    if (role.setting.mode == ControlMode::kLeave) continue;
    if (const VideoError error = find(driver, kSpellings[i], ranges[i]); !is_ok(error)) return error;
    if (role.is_known) continue;
    if (const int e = driver.get(ranges[i].id, role.value); e != 0)
      return {VideoFault::kControlRefused, e, ranges[i].id};
  }
  for (std::size_t i = 0; i < roles_.size(); ++i) {
    Held& role = roles_[i];
    if (role.setting.mode == ControlMode::kLeave) continue;
    if (const VideoError error = hold_role(driver, i, ranges[i], role.value); !is_ok(error)) return error;
    role.is_held = true;
  }
  // Values found count as found once all are held: a lock that failed half-way is tried again as a whole.
  for (Held& role : roles_) role.is_known = role.is_known || role.is_held;
  return {};
}

bool Controls::is_held(ControlRole role) const {
  return roles_[static_cast<std::size_t>(role)].is_held;
}

std::int32_t Controls::held(ControlRole role) const {
  return roles_[static_cast<std::size_t>(role)].value;
}

ControlReading read_control(VideoSystem& system, int handle, ControlRole role) {
  Driver driver{system, handle};
  const Spelling& spelling = kSpellings[static_cast<std::size_t>(role)];
  ControlReading reading;
  v4l2_queryctrl range{};
  reading.exists = is_ok(find(driver, spelling, range)) && driver.get(range.id, reading.value) == 0;
  std::int32_t automatic = spelling.off;
  const bool answers = driver.query(spelling.automatic, reading.has_automatic, range) == 0 &&
                       reading.has_automatic && driver.get(spelling.automatic, automatic) == 0;
  reading.is_automatic = answers && automatic != spelling.off;
  return reading;
}

}  // namespace vergence::v4l2
