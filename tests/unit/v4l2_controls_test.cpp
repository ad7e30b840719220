// Values that hold: set, or found once by the camera itself.
#include <gtest/gtest.h>

#include "hal/v4l2/controls.hpp"
#include "tests/support/fake_video_system.hpp"

namespace vergence::v4l2 {
namespace {

using testing::FakeControl;

class V4l2Controls : public ::testing::Test {
 protected:
  V4l2Controls() {
    system.devices = {&device};
    device.controls[V4L2_CID_EXPOSURE_AUTO] = {0, 3, V4L2_EXPOSURE_APERTURE_PRIORITY};
    device.controls[V4L2_CID_EXPOSURE_ABSOLUTE] = {
        1, 5000, 300, V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_MANUAL, 156};
    device.controls[V4L2_CID_EXPOSURE_AUTO_PRIORITY] = {0, 1, 1};
    device.controls[V4L2_CID_GAIN] = {0, 64, 0};
    device.controls[V4L2_CID_AUTO_WHITE_BALANCE] = {0, 1, 1};
    device.controls[V4L2_CID_WHITE_BALANCE_TEMPERATURE] = {2800, 6500, 4000, V4L2_CID_AUTO_WHITE_BALANCE,
                                                           0,    4650};
    device.controls[V4L2_CID_FOCUS_AUTO] = {0, 1, 1};
    device.controls[V4L2_CID_FOCUS_ABSOLUTE] = {0, 250, 0, V4L2_CID_FOCUS_AUTO, 0, 35, 5};
    EXPECT_EQ(system.open("/dev/video0", handle), 0);
  }
  void ask(ControlRole role, ControlMode mode, std::int32_t value = 0) {
    settings[static_cast<std::size_t>(role)] = {mode, value};
    controls.configure(settings);
  }
  [[nodiscard]] std::int32_t value(std::uint32_t id) { return device.controls[id].value; }

  testing::FakeVideoDevice device;
  testing::FakeVideoSystem system;
  int handle = -1;
  std::array<ControlSetting, kControlRoles> settings{};
  Controls controls;
};

TEST_F(V4l2Controls, HoldsWhatIsSetWithTheAutomaticsOff) {
  ask(ControlRole::kExposure, ControlMode::kSet, 100);
  ask(ControlRole::kGain, ControlMode::kSet, 16);  // this camera has no automatic gain
  ask(ControlRole::kWhiteBalance, ControlMode::kSet, 5000);
  ask(ControlRole::kFocus, ControlMode::kSet, 40);
  EXPECT_FALSE(controls.needs_settling());
  ASSERT_TRUE(is_ok(controls.lock(system, handle)));
  EXPECT_EQ(value(V4L2_CID_EXPOSURE_AUTO), V4L2_EXPOSURE_MANUAL);
  EXPECT_EQ(value(V4L2_CID_EXPOSURE_AUTO_PRIORITY), 0);
  EXPECT_EQ(value(V4L2_CID_EXPOSURE_ABSOLUTE), 100);
  EXPECT_EQ(value(V4L2_CID_GAIN), 16);
  EXPECT_EQ(value(V4L2_CID_AUTO_WHITE_BALANCE), 0);
  EXPECT_EQ(value(V4L2_CID_WHITE_BALANCE_TEMPERATURE), 5000);
  EXPECT_EQ(value(V4L2_CID_FOCUS_AUTO), 0);
  EXPECT_EQ(value(V4L2_CID_FOCUS_ABSOLUTE), 40);
  EXPECT_TRUE(controls.is_held(ControlRole::kFocus));
  EXPECT_FALSE(controls.is_held(ControlRole::kRedBalance));
}

TEST_F(V4l2Controls, LeavesTheRestAlone) {
  controls.configure(settings);
  device.errors[VIDIOC_QUERYCTRL] = EIO;  // not even asked
  ASSERT_TRUE(is_ok(controls.lock(system, handle)));
  EXPECT_EQ(value(V4L2_CID_AUTO_WHITE_BALANCE), 1);
}

TEST_F(V4l2Controls, FindsAValueOnceAndHoldsItEverAfter) {
  ask(ControlRole::kExposure, ControlMode::kAutoThenLock);
  ask(ControlRole::kWhiteBalance, ControlMode::kAutoThenLock);
  device.controls[V4L2_CID_EXPOSURE_AUTO].value = V4L2_EXPOSURE_MANUAL;
  ASSERT_TRUE(controls.needs_settling());
  ASSERT_TRUE(is_ok(controls.begin(system, handle)));
  EXPECT_EQ(value(V4L2_CID_EXPOSURE_AUTO), V4L2_EXPOSURE_APERTURE_PRIORITY);
  ASSERT_TRUE(is_ok(controls.lock(system, handle)));
  EXPECT_EQ(controls.held(ControlRole::kExposure), 156);
  EXPECT_EQ(value(V4L2_CID_EXPOSURE_AUTO), V4L2_EXPOSURE_MANUAL);
  EXPECT_EQ(value(V4L2_CID_EXPOSURE_ABSOLUTE), 156);
  EXPECT_EQ(value(V4L2_CID_WHITE_BALANCE_TEMPERATURE), 4650);

  // Another light, another camera: the same values.
  device.controls[V4L2_CID_EXPOSURE_ABSOLUTE].found = 999;
  device.unplug();
  device.plug();
  EXPECT_EQ(system.open("/dev/video0", handle), 0);
  EXPECT_FALSE(controls.needs_settling());
  ASSERT_TRUE(is_ok(controls.lock(system, handle)));
  EXPECT_EQ(value(V4L2_CID_EXPOSURE_ABSOLUTE), 156);
}

TEST_F(V4l2Controls, WhatIsSetIsHeldWhileTheRestIsFound) {
  ask(ControlRole::kExposure, ControlMode::kAutoThenLock);
  ask(ControlRole::kGain, ControlMode::kSet, 16);
  ASSERT_TRUE(is_ok(controls.begin(system, handle)));
  EXPECT_EQ(value(V4L2_CID_GAIN), 16);
  EXPECT_EQ(value(V4L2_CID_EXPOSURE_AUTO), V4L2_EXPOSURE_APERTURE_PRIORITY);
}

TEST_F(V4l2Controls, TriesTheOtherKindOfAutomaticExposure) {
  device.controls[V4L2_CID_EXPOSURE_AUTO] = {0, 1, V4L2_EXPOSURE_MANUAL};  // 3 is out of its range
  ask(ControlRole::kExposure, ControlMode::kAutoThenLock);
  ASSERT_TRUE(is_ok(controls.begin(system, handle)));
  EXPECT_EQ(value(V4L2_CID_EXPOSURE_AUTO), V4L2_EXPOSURE_AUTO);
}

TEST_F(V4l2Controls, TakesTheOtherNameOfAGain) {
  device.controls.erase(V4L2_CID_GAIN);
  device.controls[V4L2_CID_ANALOGUE_GAIN] = {0, 100, 0};
  ask(ControlRole::kGain, ControlMode::kSet, 20);
  ASSERT_TRUE(is_ok(controls.lock(system, handle)));
  EXPECT_EQ(value(V4L2_CID_ANALOGUE_GAIN), 20);
}

TEST_F(V4l2Controls, BalancesShareAnAutomaticAndAreReadBeforeItIsOff) {
  device.controls[V4L2_CID_RED_BALANCE] = {0, 255, 10, V4L2_CID_AUTO_WHITE_BALANCE, 0, 130};
  device.controls[V4L2_CID_BLUE_BALANCE] = {0, 255, 10, V4L2_CID_AUTO_WHITE_BALANCE, 0, 140};
  ask(ControlRole::kRedBalance, ControlMode::kAutoThenLock);
  ask(ControlRole::kBlueBalance, ControlMode::kAutoThenLock);
  ASSERT_TRUE(is_ok(controls.begin(system, handle)));
  ASSERT_TRUE(is_ok(controls.lock(system, handle)));
  EXPECT_EQ(value(V4L2_CID_RED_BALANCE), 130);
  EXPECT_EQ(value(V4L2_CID_BLUE_BALANCE), 140);
}

TEST_F(V4l2Controls, NamesTheControlThatIsMissing) {
  ask(ControlRole::kRedBalance, ControlMode::kSet, 100);
  VideoError error = controls.lock(system, handle);
  EXPECT_EQ(error.fault, VideoFault::kControlMissing);
  EXPECT_EQ(error.id, V4L2_CID_RED_BALANCE);
  EXPECT_TRUE(is_permanent(error));
  settings = {};
  ask(ControlRole::kGain, ControlMode::kAutoThenLock);
  error = controls.begin(system, handle);
  EXPECT_EQ(error.fault, VideoFault::kControlMissing);
  EXPECT_EQ(error.id, V4L2_CID_AUTOGAIN);
}

TEST_F(V4l2Controls, SaysWhichEndOfTheRangeWasPassed) {
  ask(ControlRole::kExposure, ControlMode::kSet, 6000);
  VideoError error = controls.lock(system, handle);
  EXPECT_EQ(error.fault, VideoFault::kControlRange);
  EXPECT_EQ(error.got, 5000);
  ask(ControlRole::kExposure, ControlMode::kSet, 0);
  error = controls.lock(system, handle);
  EXPECT_EQ(error.got, 1);
}

TEST_F(V4l2Controls, ReadsBackAndRefusesAnotherValueThanAsked) {
  ask(ControlRole::kFocus, ControlMode::kSet, 42);  // steps of 5
  const VideoError error = controls.lock(system, handle);
  EXPECT_EQ(error.fault, VideoFault::kControlNotHeld);
  EXPECT_EQ(error.asked, 42);
  EXPECT_EQ(error.got, 40);
  EXPECT_FALSE(controls.is_held(ControlRole::kFocus));
}

TEST_F(V4l2Controls, ACameraThatFailsForAMomentIsNotOneWithoutTheControl) {
  ask(ControlRole::kGain, ControlMode::kSet, 20);
  device.errors[VIDIOC_QUERYCTRL] = EIO;
  const VideoError error = controls.lock(system, handle);
  EXPECT_EQ(error.fault, VideoFault::kControlRefused);
  EXPECT_FALSE(is_permanent(error));
}

}  // namespace
}  // namespace vergence::v4l2
