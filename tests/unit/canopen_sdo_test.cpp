// SDO against byte sequences written by hand from CiA 301, 7.2.4.3: both sides, and every way a transfer
// ends.
#include <gtest/gtest.h>

#include <string>

#include "hal/canopen/sdo_client.hpp"
#include "hal/canopen/sdo_server.hpp"
#include "tests/support/can_recorder.hpp"

namespace vergence::canopen {
namespace {

using testing::can_frame;
using testing::CanRecorder;

constexpr std::int64_t kTimeout_ns = 1000;

// A client of node 5 whose requests are looked at, and that is answered by hand.
class SdoClientTest : public ::testing::Test {
 protected:
  SdoClientTest() { client.init(5, kTimeout_ns); }

  bool write(std::uint16_t index, std::uint8_t sub, std::vector<std::uint8_t> bytes) {
    return client.write(index, sub, bytes, t_ns);
  }
  std::vector<int> request() {
    client.process(t_ns, FrameSink(bus));
    const CanFrame frame = bus.take();
    if (frame.id != 0x605 || frame.size != 8) return {};
    return {frame.data.begin(), frame.data.end()};
  }
  void answer(std::initializer_list<int> bytes) { client.receive(can_frame(0x585, bytes), t_ns); }
  std::vector<int> bytes() const { return {client.bytes().begin(), client.bytes().end()}; }

  CanRecorder bus;
  SdoClient client;
  std::int64_t t_ns = 0;
};

using Bytes = std::vector<int>;

TEST_F(SdoClientTest, WritesUpToFourBytesInOneFrame) {
  const Bytes sent[] = {{0x2F, 0x60, 0x60, 0x00, 0x09, 0, 0, 0},
                        {0x2B, 0x60, 0x60, 0x00, 0x09, 0x0A, 0, 0},
                        {0x27, 0x60, 0x60, 0x00, 0x09, 0x0A, 0x0B, 0},
                        {0x23, 0x60, 0x60, 0x00, 0x09, 0x0A, 0x0B, 0x0C}};
  std::vector<std::uint8_t> value;
  for (std::size_t size = 1; size <= 4; ++size) {
    value.push_back(static_cast<std::uint8_t>(8 + size));
    ASSERT_TRUE(write(0x6060, 0, value));
    EXPECT_EQ(request(), sent[size - 1]);
    EXPECT_EQ(client.state(), SdoState::kBusy);
    answer({0x60, 0x60, 0x60, 0x00, 0, 0, 0, 0});
    EXPECT_EQ(client.state(), SdoState::kDone);
  }
}

TEST_F(SdoClientTest, ReadsUpToFourBytesInOneFrame) {
  ASSERT_TRUE(client.read(0x1018, 2, t_ns));
  EXPECT_EQ(request(), (Bytes{0x40, 0x18, 0x10, 0x02, 0, 0, 0, 0}));
  answer({0x4B, 0x18, 0x10, 0x02, 0x34, 0x12, 0, 0});
  EXPECT_EQ(client.state(), SdoState::kDone);
  EXPECT_EQ(bytes(), (Bytes{0x34, 0x12}));
  ASSERT_TRUE(client.read(0x1018, 2, t_ns));
  (void)request();
  answer({0x42, 0x18, 0x10, 0x02, 1, 2, 3, 4});  // without its size
  EXPECT_EQ(bytes(), (Bytes{1, 2, 3, 4}));
}

TEST_F(SdoClientTest, WritesSegmentsWithAlternatingToggle) {
  ASSERT_TRUE(write(0x2000, 3, {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16}));
  EXPECT_EQ(request(), (Bytes{0x21, 0x00, 0x20, 0x03, 16, 0, 0, 0}));
  answer({0x60, 0x00, 0x20, 0x03, 0, 0, 0, 0});
  EXPECT_EQ(request(), (Bytes{0x00, 1, 2, 3, 4, 5, 6, 7}));
  answer({0x20, 0, 0, 0, 0, 0, 0, 0});
  EXPECT_EQ(request(), (Bytes{0x10, 8, 9, 10, 11, 12, 13, 14}));
  answer({0x30, 0, 0, 0, 0, 0, 0, 0});
  EXPECT_EQ(request(), (Bytes{0x0B, 15, 16, 0, 0, 0, 0, 0}));  // five bytes empty, the last segment
  EXPECT_EQ(client.state(), SdoState::kBusy);
  answer({0x20, 0, 0, 0, 0, 0, 0, 0});
  EXPECT_EQ(client.state(), SdoState::kDone);
}

TEST_F(SdoClientTest, ReadsSegmentsWithAlternatingToggle) {
  ASSERT_TRUE(client.read(0x1008, 0, t_ns));
  (void)request();
  answer({0x41, 0x08, 0x10, 0x00, 10, 0, 0, 0});
  EXPECT_EQ(request(), (Bytes{0x60, 0, 0, 0, 0, 0, 0, 0}));
  answer({0x00, 'a', 'b', 'c', 'd', 'e', 'f', 'g'});
  EXPECT_EQ(request(), (Bytes{0x70, 0, 0, 0, 0, 0, 0, 0}));
  answer({0x19, 'h', 'i', 'j', 0, 0, 0, 0});
  EXPECT_EQ(client.state(), SdoState::kDone);
  EXPECT_EQ(std::string(client.bytes().begin(), client.bytes().end()), "abcdefghij");
}

TEST_F(SdoClientTest, AbortsWhatDoesNotAlternate) {
  ASSERT_TRUE(client.read(0x1008, 0, t_ns));
  (void)request();
  answer({0x41, 0x08, 0x10, 0x00, 10, 0, 0, 0});
  (void)request();
  answer({0x10, 'a', 'b', 'c', 'd', 'e', 'f', 'g'});
  EXPECT_EQ(client.state(), SdoState::kAborted);
  EXPECT_EQ(client.abort_code(), kAbortToggle);
  EXPECT_EQ(request(), (Bytes{0x80, 0x08, 0x10, 0x00, 0x00, 0x00, 0x03, 0x05}));
  ASSERT_TRUE(write(0x2000, 0, {1, 2, 3, 4, 5}));
  (void)request();
  answer({0x60, 0x00, 0x20, 0x00, 0, 0, 0, 0});
  (void)request();
  answer({0x30, 0, 0, 0, 0, 0, 0, 0});
  EXPECT_EQ(client.abort_code(), kAbortToggle);
}

TEST_F(SdoClientTest, TellsWhyTheNodeAborts) {
  ASSERT_TRUE(write(0x1017, 0, {20, 0}));
  (void)request();
  answer({0x80, 0x17, 0x10, 0x00, 0x00, 0x00, 0x02, 0x06});
  EXPECT_EQ(client.state(), SdoState::kAborted);
  EXPECT_EQ(client.abort_code(), kAbortNoObject);
  EXPECT_STREQ(describe_abort(client.abort_code()), "object does not exist");
  EXPECT_EQ(request(), Bytes{});  // nothing is left to be said
}

TEST_F(SdoClientTest, GivesUpAfterItsTimeoutAndSaysSo) {
  ASSERT_TRUE(client.read(0x1000, 0, t_ns));
  EXPECT_EQ(request().size(), 8U);
  t_ns = kTimeout_ns;
  EXPECT_EQ(request(), Bytes{});
  EXPECT_EQ(client.state(), SdoState::kBusy);
  t_ns = kTimeout_ns + 1;
  EXPECT_EQ(request(), (Bytes{0x80, 0x00, 0x10, 0x00, 0x00, 0x00, 0x04, 0x05}));
  EXPECT_EQ(client.abort_code(), kAbortTimeout);
}

TEST_F(SdoClientTest, TimesEachSegmentByItself) {
  ASSERT_TRUE(write(0x2000, 0, {1, 2, 3, 4, 5, 6, 7, 8}));
  (void)request();
  t_ns = 900;
  answer({0x60, 0x00, 0x20, 0x00, 0, 0, 0, 0});
  (void)request();
  t_ns = 1800;
  (void)request();
  EXPECT_EQ(client.state(), SdoState::kBusy);
  t_ns = 1901;
  (void)request();
  EXPECT_EQ(client.abort_code(), kAbortTimeout);
}

TEST_F(SdoClientTest, LateAnswersAboutAnotherObjectAreIgnored) {
  ASSERT_TRUE(client.read(0x6041, 0, t_ns));
  (void)request();
  answer({0x4B, 0x40, 0x60, 0x00, 1, 0, 0, 0});
  answer({0x80, 0x40, 0x60, 0x00, 0, 0, 0, 8});
  client.receive(can_frame(0x586, {0x4B, 0x41, 0x60, 0x00, 1, 0, 0, 0}), t_ns);  // of another node
  client.receive(can_frame(0x585, {0x4B, 0x41, 0x60, 0x00, 1}), t_ns);           // cut off
  EXPECT_EQ(client.state(), SdoState::kBusy);
  answer({0x4B, 0x41, 0x60, 0x00, 7, 0, 0, 0});
  EXPECT_EQ(bytes(), (Bytes{7, 0}));
}

TEST_F(SdoClientTest, RefusesAnswersThatDoNotFit) {
  struct Case {
    std::initializer_list<int> first;
    std::initializer_list<int> second;
    std::uint32_t code;
  };
  const Case cases[] = {
      {{0x60, 0x08, 0x10, 0, 0, 0, 0, 0}, {}, kAbortCommand},
      {{0x41, 0x08, 0x10, 0, 129, 0, 0, 0}, {}, kAbortMemory},
      {{0x41, 0x08, 0x10, 0, 3, 0, 0, 0}, {0x01, 1, 2, 3, 4, 5, 6, 7}, kAbortTooLong},
      {{0x41, 0x08, 0x10, 0, 9, 0, 0, 0}, {0x01, 1, 2, 3, 4, 5, 6, 7}, kAbortTooShort},
      {{0x41, 0x08, 0x10, 0, 9, 0, 0, 0}, {0x20, 1, 2, 3, 4, 5, 6, 7}, kAbortCommand},
  };
  for (const Case& c : cases) {
    ASSERT_TRUE(client.read(0x1008, 0, t_ns));
    (void)request();
    answer(c.first);
    if (c.second.size() != 0) {
      (void)request();
      answer(c.second);
    }
    EXPECT_EQ(client.state(), SdoState::kAborted);
    EXPECT_EQ(client.abort_code(), c.code);
    EXPECT_EQ(request().at(0), 0x80);
  }
}

TEST_F(SdoClientTest, WithoutSizeAReadEndsAtItsBuffer) {
  ASSERT_TRUE(client.read(0x1008, 0, t_ns));
  (void)request();
  answer({0x40, 0x08, 0x10, 0, 0, 0, 0, 0});
  bool toggle = false;
  int segments = 0;
  while (client.state() == SdoState::kBusy && segments < 100) {
    (void)request();
    answer({toggle ? 0x10 : 0x00, 1, 2, 3, 4, 5, 6, 7});
    toggle = !toggle;
    ++segments;
  }
  EXPECT_EQ(client.abort_code(), kAbortMemory);
  EXPECT_EQ(segments, 19);  // 18 segments are 126 bytes
}

TEST_F(SdoClientTest, SendsAgainWhatTheBusRefused) {
  ASSERT_TRUE(client.read(0x1000, 0, t_ns));
  bus.is_full = true;
  EXPECT_EQ(request(), Bytes{});
  answer({0x43, 0x00, 0x10, 0x00, 1, 2, 3, 4});  // cannot be the answer: nothing was asked yet
  EXPECT_EQ(client.state(), SdoState::kBusy);
  bus.is_full = false;
  EXPECT_EQ(request().size(), 8U);
}

TEST_F(SdoClientTest, RefusesWhatItCannotDo) {
  EXPECT_FALSE(write(0x2000, 0, {}));
  EXPECT_FALSE(write(0x2000, 0, std::vector<std::uint8_t>(kMaxSdoBytes + 1)));
  EXPECT_TRUE(write(0x2000, 0, std::vector<std::uint8_t>(kMaxSdoBytes)));
  EXPECT_FALSE(client.read(0x1000, 0, t_ns));  // busy
}

// The drive's side.
class SdoServerTest : public ::testing::Test {
 protected:
  SdoServerTest() {
    objects.init(5, 0x1D5);
    server.init(5);
  }
  Bytes ask(std::initializer_list<int> bytes) {
    CanFrame answer;
    if (!server.receive(can_frame(0x605, bytes), objects, answer, written)) return {};
    EXPECT_EQ(answer.id, 0x585U);
    return {answer.data.begin(), answer.data.end()};
  }

  DriveObjects objects;
  SdoServer server;
  std::uint16_t written = 0;
};

TEST_F(SdoServerTest, AnswersInOneFrame) {
  EXPECT_EQ(ask({0x40, 0x00, 0x10, 0x00, 0, 0, 0, 0}),
            (Bytes{0x43, 0x00, 0x10, 0x00, 0x92, 0x01, 0x02, 0x00}));
  EXPECT_EQ(ask({0x2B, 0x17, 0x10, 0x00, 20, 0, 0, 0}), (Bytes{0x60, 0x17, 0x10, 0x00, 0, 0, 0, 0}));
  EXPECT_EQ(written, 0x1017);
  EXPECT_EQ(objects.number(0x1017, 0), 20U);
  EXPECT_EQ(ask({0x40, 0x17, 0x10, 0x00, 0, 0, 0, 0}), (Bytes{0x4B, 0x17, 0x10, 0x00, 20, 0, 0, 0}));
}

TEST_F(SdoServerTest, AnswersInSegments) {
  EXPECT_EQ(ask({0x21, 0x00, 0x20, 0x00, 9, 0, 0, 0}), (Bytes{0x60, 0x00, 0x20, 0x00, 0, 0, 0, 0}));
  EXPECT_EQ(ask({0x00, 'a', 'b', 'c', 'd', 'e', 'f', 'g'}), (Bytes{0x20, 0, 0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(written, 0);
  EXPECT_EQ(ask({0x1B, 'h', 'i', 0, 0, 0, 0, 0}), (Bytes{0x30, 0, 0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(written, 0x2000);
  EXPECT_EQ(ask({0x40, 0x00, 0x20, 0x00, 0, 0, 0, 0}), (Bytes{0x41, 0x00, 0x20, 0x00, 9, 0, 0, 0}));
  EXPECT_EQ(ask({0x60, 0, 0, 0, 0, 0, 0, 0}), (Bytes{0x00, 'a', 'b', 'c', 'd', 'e', 'f', 'g'}));
  EXPECT_EQ(ask({0x70, 0, 0, 0, 0, 0, 0, 0}), (Bytes{0x1B, 'h', 'i', 0, 0, 0, 0, 0}));
}

TEST_F(SdoServerTest, AbortsByTheStandardsCodes) {
  const auto code_of = [](const Bytes& answer) {
    return answer.empty() || answer[0] != 0x80
               ? 0U
               : static_cast<std::uint32_t>(answer[4] | answer[5] << 8 | answer[6] << 16 | answer[7] << 24);
  };
  EXPECT_EQ(code_of(ask({0x40, 0x34, 0x12, 0x00, 0, 0, 0, 0})), kAbortNoObject);
  EXPECT_EQ(code_of(ask({0x40, 0x18, 0x10, 0x09, 0, 0, 0, 0})), kAbortNoSubIndex);
  EXPECT_EQ(code_of(ask({0x23, 0x00, 0x10, 0x00, 0, 0, 0, 0})), kAbortReadOnly);
  EXPECT_EQ(code_of(ask({0x2F, 0x17, 0x10, 0x00, 0, 0, 0, 0})), kAbortTooShort);
  EXPECT_EQ(code_of(ask({0x23, 0x17, 0x10, 0x00, 0, 0, 0, 0})), kAbortTooLong);
  EXPECT_EQ(code_of(ask({0x2F, 0x60, 0x60, 0x00, 77, 0, 0, 0})), kAbortValue);
  EXPECT_EQ(code_of(ask({0x60, 0, 0, 0, 0, 0, 0, 0})), kAbortCommand);  // no read was begun
  EXPECT_EQ(code_of(ask({0xE0, 0, 0, 0, 0, 0, 0, 0})), kAbortCommand);
  (void)ask({0x40, 0x08, 0x10, 0x00, 0, 0, 0, 0});
  EXPECT_EQ(code_of(ask({0x70, 0, 0, 0, 0, 0, 0, 0})), kAbortToggle);
  // A PDO is mapped while it is off and its mapping empty, with objects that are there.
  EXPECT_EQ(code_of(ask({0x2F, 0x00, 0x16, 0x00, 0, 0, 0, 0})), kAbortDeviceState);
  (void)ask({0x23, 0x00, 0x14, 0x01, 0x05, 0x02, 0, 0x80});
  EXPECT_EQ(code_of(ask({0x23, 0x00, 0x16, 0x01, 0x10, 0, 0x40, 0x60})), kAbortAccess);
  EXPECT_EQ(ask({0x2F, 0x00, 0x16, 0x00, 0, 0, 0, 0}).at(0), 0x60);
  EXPECT_EQ(code_of(ask({0x23, 0x00, 0x16, 0x01, 0x10, 0, 0x34, 0x12})), kAbortNotMappable);
  for (int sub = 1; sub <= 3; ++sub) {
    EXPECT_EQ(ask({0x23, 0x00, 0x16, sub, 0x20, 0, 0xFF, 0x60}).at(0), 0x60);
  }
  EXPECT_EQ(code_of(ask({0x2F, 0x00, 0x16, 0x00, 3, 0, 0, 0})), kAbortPdoLength);
  objects.refuse(0x6085, 0, kAbortGeneral);
  EXPECT_EQ(code_of(ask({0x23, 0x85, 0x60, 0x00, 0, 0, 0, 0})), kAbortGeneral);
}

// Both sides, with every length there is.
TEST_F(SdoServerTest, UnderstandsTheClient) {
  SdoClient client;
  client.init(5, kTimeout_ns);
  CanRecorder bus;
  const auto transfer = [&] {
    for (int i = 0; i < 40 && client.state() == SdoState::kBusy; ++i) {
      client.process(0, FrameSink(bus));
      CanFrame answer;
      if (server.receive(bus.take(), objects, answer, written)) client.receive(answer, 0);
    }
  };
  std::vector<std::uint8_t> value;
  for (std::size_t size = 1; size <= DriveObjects::kMaxBytes; ++size) {
    value.push_back(static_cast<std::uint8_t>(3 * size));
    ASSERT_TRUE(client.write(0x2000, 0, value, 0));
    transfer();
    ASSERT_EQ(client.state(), SdoState::kDone);
    ASSERT_TRUE(client.read(0x2000, 0, 0));
    transfer();
    ASSERT_EQ(client.state(), SdoState::kDone);
    EXPECT_EQ(std::vector<std::uint8_t>(client.bytes().begin(), client.bytes().end()), value);
  }
}

TEST(SdoAbort, EveryCodeOfTheStandardHasWordsOfItsOwn) {
  const std::uint32_t codes[] = {
      0x05030000, 0x05040000, 0x05040001, 0x05040002, 0x05040003, 0x05040004, 0x05040005, 0x06010000,
      0x06010001, 0x06010002, 0x06020000, 0x06040041, 0x06040042, 0x06040043, 0x06040047, 0x06060000,
      0x06070010, 0x06070012, 0x06070013, 0x06090011, 0x06090030, 0x06090031, 0x06090032, 0x06090036,
      0x060A0023, 0x08000000, 0x08000020, 0x08000021, 0x08000022, 0x08000023, 0x08000024};
  std::vector<std::string> seen;
  for (const std::uint32_t code : codes) {
    const std::string words = describe_abort(code);
    EXPECT_STRNE(words.c_str(), describe_abort(0x12345678)) << code;
    EXPECT_EQ(std::count(seen.begin(), seen.end(), words), 0) << words;
    seen.push_back(words);
  }
}

}  // namespace
}  // namespace vergence::canopen
