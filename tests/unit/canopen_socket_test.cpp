// The socket, where there is an interface to open: `ip link add vcan0 type vcan && ip link set vcan0 up`.
#include "hal/canopen/socket_can.hpp"

#include <gtest/gtest.h>
#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <ctime>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "tests/support/can_recorder.hpp"

namespace vergence::canopen {
namespace {

using testing::can_frame;

TEST(SocketCanTest, WhatIsNotThereIsSaid) {
  SocketCan socket;
  EXPECT_EQ(socket.open("", {}), SocketStep::kName);
  EXPECT_EQ(socket.open("a_name_that_is_too_long", {}), SocketStep::kName);
  const SocketStep step = socket.open("no_such_can", {});
  EXPECT_TRUE(step == SocketStep::kInterface || step == SocketStep::kSocket) << describe(step);
  EXPECT_NE(socket.last_errno(), 0);
  EXPECT_FALSE(socket.is_open());
  std::set<std::string> words;
  for (int i = 0; i <= static_cast<int>(SocketStep::kBind); ++i)
    words.insert(describe(static_cast<SocketStep>(i)));
  EXPECT_EQ(words.size(), static_cast<std::size_t>(SocketStep::kBind) + 1);
}

TEST(SocketCanTest, AClosedSocketIsABusThatIsDown) {
  SocketCan socket;
  CanFrame frame;
  EXPECT_FALSE(socket.receive(frame));
  EXPECT_FALSE(socket.send(can_frame(0x123, {1})));
  EXPECT_EQ(socket.health().state, BusState::kDown);
  EXPECT_EQ(socket.health().tx_failed, 1U);
  const std::vector<CanFrame> three(3, can_frame(0x123, {1}));
  EXPECT_EQ(socket.send(three), 0U);
  EXPECT_EQ(socket.health().tx_failed, 4U);
  EXPECT_EQ(socket.send(std::span<const CanFrame>()), 0U);
  EXPECT_EQ(socket.health().tx_failed, 4U);
}

class VirtualCanTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const CanFilter filters[] = {{0x181, 0x7FF}, {0x700, 0x780}};
    const SocketStep step = ours.open("vcan0", filters);
    if (step != SocketStep::kOk) {
      GTEST_SKIP() << "vcan0: " << describe(step) << " (" << std::strerror(ours.last_errno()) << ")";
    }
    ASSERT_EQ(theirs.open("vcan0", filters), SocketStep::kOk);
  }

  SocketCan ours;
  SocketCan theirs;
};

TEST_F(VirtualCanTest, FiltersAndStampsWhatComes) {
  timespec now{};
  ASSERT_EQ(clock_gettime(CLOCK_MONOTONIC, &now), 0);
  const std::int64_t now_ns = now.tv_sec * 1'000'000'000LL + now.tv_nsec;
  ours.process(now_ns);
  ASSERT_TRUE(theirs.send(can_frame(0x181, {1, 2, 3})));
  ASSERT_TRUE(theirs.send(can_frame(0x182, {4})));
  ASSERT_TRUE(theirs.send(can_frame(0x705, {5})));
  CanFrame frame;
  ASSERT_TRUE(ours.receive(frame));
  EXPECT_EQ(frame.id, 0x181U);
  EXPECT_EQ(frame.size, 3);
  EXPECT_EQ(frame.data[2], 3);
  EXPECT_NE(frame.stamp_ns, 0);
  ASSERT_TRUE(ours.receive(frame));
  EXPECT_EQ(frame.id, 0x705U);
  EXPECT_FALSE(ours.receive(frame));  // and does not wait
}

TEST_F(VirtualCanTest, CountsWhatTheKernelThrewAway) {
  for (int i = 0; i < 5000; ++i) (void)theirs.send(can_frame(0x181, {1}));
  CanFrame frame;
  int received = 0;
  while (ours.receive(frame)) ++received;
  ASSERT_TRUE(theirs.send(can_frame(0x181, {1})));
  ASSERT_TRUE(ours.receive(frame));  // brings the count
  EXPECT_LT(received, 5000);
  EXPECT_GT(ours.health().rx_overflows, 0U);
}

// Fewer, as many as and more than are taken from the kernel in a call.
TEST_F(VirtualCanTest, SeveralInACallKeepTheirOrder) {
  for (const int count : {1, 15, 16, 17, 32, 100}) {
    std::vector<CanFrame> frames;
    for (int i = 0; i < count; ++i) frames.push_back(can_frame(0x181, {i, count}));
    ASSERT_EQ(theirs.send(frames), frames.size());
    CanFrame frame;
    for (int i = 0; i < count; ++i) {
      ASSERT_TRUE(ours.receive(frame)) << i << " of " << count;
      EXPECT_EQ(frame.data[0], i);
      EXPECT_EQ(frame.data[1], count);
      EXPECT_NE(frame.stamp_ns, 0);
    }
    EXPECT_FALSE(ours.receive(frame)) << count;
    // Now something is there again.
    ASSERT_TRUE(theirs.send(can_frame(0x181, {77})));
    ASSERT_TRUE(ours.receive(frame)) << count;
    EXPECT_EQ(frame.data[0], 77);
    EXPECT_FALSE(ours.receive(frame));
  }
  EXPECT_EQ(ours.health().rx_overflows, 0U);
}

TEST_F(VirtualCanTest, ErrorFramesCountWhenTheirTurnComes) {
  const int raw = ::socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC, CAN_RAW);
  ASSERT_GE(raw, 0);
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = static_cast<int>(if_nametoindex("vcan0"));
  ASSERT_EQ(bind(raw, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  struct can_frame error {};
  error.can_id = CAN_ERR_FLAG | CAN_ERR_BUSOFF;
  error.can_dlc = CAN_ERR_DLC;
  ASSERT_TRUE(theirs.send(can_frame(0x181, {1})));
  ASSERT_EQ(write(raw, &error, sizeof error), static_cast<ssize_t>(sizeof error));
  ASSERT_TRUE(theirs.send(can_frame(0x181, {2})));
  close(raw);
  CanFrame frame;
  ASSERT_TRUE(ours.receive(frame));
  EXPECT_EQ(frame.data[0], 1);
  EXPECT_EQ(ours.health().error_frames, 0U);
  ASSERT_TRUE(ours.receive(frame));
  EXPECT_EQ(frame.data[0], 2);
  EXPECT_EQ(ours.health().bus_offs, 1U);
  EXPECT_EQ(ours.health().state, BusState::kOff);
  EXPECT_FALSE(ours.receive(frame));
}

TEST_F(VirtualCanTest, WhatWasNotTakenIsForgottenByClosing) {
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(theirs.send(can_frame(0x181, {i})));
  CanFrame frame;
  ASSERT_TRUE(ours.receive(frame));
  ours.close();
  EXPECT_FALSE(ours.receive(frame));
  const CanFilter all{0, 0};
  ASSERT_EQ(ours.open("vcan0", std::span(&all, 1)), SocketStep::kOk);
  EXPECT_FALSE(ours.receive(frame));
}

}  // namespace
}  // namespace vergence::canopen
