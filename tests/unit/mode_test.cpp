// The table of modes, and the supervisor that runs it: every transition is visited, nothing bad is ignored,
// and a stop is left by a reset alone.
#include "firmware_like/mode.hpp"

#include <gtest/gtest.h>

#include <set>
#include <string>

#include "firmware_like/supervisor.hpp"
#include "tests/support/random.hpp"

namespace vergence {
namespace {

constexpr std::array kAllModes = {Mode::kInit,  Mode::kSelfTest, Mode::kIdle,     Mode::kSearch, Mode::kTrack,
                                  Mode::kServo, Mode::kHold,     Mode::kSafeStop, Mode::kFault};
static_assert(kAllModes.size() == kModes);

// Drives a supervisor the way the arm's task does.
class Operated {
 public:
  Operated() { supervisor.configure(3); }

  Mode step() { return supervisor.step(++t_ns, conditions); }
  Mode step(OperatorCommand command) {
    supervisor.command(command);
    return step();
  }

  // By the shortest way a user would take.
  void go_to(Mode mode) {
    conditions.devices_ready = mode != Mode::kInit;
    if (mode == Mode::kInit) return;
    if (mode == Mode::kSelfTest) {
      step();
      return;
    }
    conditions.self_test = SelfTest::kPassed;
    step();
    if (mode == Mode::kIdle) return;
    if (mode == Mode::kSafeStop) {
      step(OperatorCommand::kStop);
      return;
    }
    if (mode == Mode::kFault) {
      conditions.device_fault = true;
      step();
      conditions.device_fault = false;
      return;
    }
    step(OperatorCommand::kArm);
    if (mode == Mode::kHold) step(OperatorCommand::kHold);
    conditions.target_believed = mode == Mode::kTrack || mode == Mode::kServo;
    if (mode == Mode::kTrack) step();
    if (mode == Mode::kServo) step(OperatorCommand::kServo);
  }

  // Makes the world such that the supervisor raises the event.
  Mode raise(Event event) {
    Conditions& c = conditions;
    switch (event) {
      case Event::kDevicesReady: c.devices_ready = true; return step();
      case Event::kSelfTestPassed: c.self_test = SelfTest::kPassed; return step();
      case Event::kSelfTestFailed: c.self_test = SelfTest::kFailed; return step();
      case Event::kArm: return step(OperatorCommand::kArm);
      case Event::kDisarm: return step(OperatorCommand::kDisarm);
      case Event::kTargetFound: c.target_believed = true; return step();
      case Event::kTargetLost: c.target_believed = false; return step();
      case Event::kServo: return step(OperatorCommand::kServo);
      case Event::kHold: return step(OperatorCommand::kHold);
      case Event::kStop: return step(OperatorCommand::kStop);
      case Event::kDeadlineMissed: c.missed_deadlines = 3; return step();
      case Event::kFollowingError: c.following_error = true; return step();
      case Event::kDeviceFault: c.device_fault = true; return step();
      case Event::kReset: return step(OperatorCommand::kReset);
    }
    return step();
  }

  Supervisor supervisor;
  Conditions conditions;
  std::int64_t t_ns = 0;
};

TEST(Modes, HaveNamesOfTheirOwn) {
  std::set<std::string> modes{"unknown mode"};
  std::set<std::string> events{"unknown event"};
  for (const Mode mode : kAllModes) modes.insert(to_string(mode));
  for (std::size_t i = 0; i < kEvents; ++i) events.insert(to_string(static_cast<Event>(i)));
  EXPECT_EQ(modes.size(), kModes + 1);
  EXPECT_EQ(events.size(), kEvents + 1);
}

TEST(Modes, TableHoldsEachPairOnceAndNoRowThatDoesNothing) {
  std::set<std::pair<Mode, Event>> pairs;
  for (const Transition& row : kTransitions) {
    EXPECT_TRUE(pairs.emplace(row.from, row.event).second)
        << to_string(row.from) << ", " << to_string(row.event);
    EXPECT_NE(row.from, row.to);
  }
}

TEST(Modes, EachIsReachedFromTheStart) {
  std::set<Mode> reached{Mode::kInit};
  for (std::size_t i = 0; i < kModes; ++i) {
    for (const Transition& row : kTransitions) {
      if (reached.count(row.from) != 0) reached.insert(row.to);
    }
  }
  EXPECT_EQ(reached.size(), kModes);
}

// The least a user relies on, said again without the table.
TEST(Modes, StopAndFaultsAlwaysEndWhatMoves) {
  for (const Mode mode : kAllModes) {
    if (is_armed(mode)) {
      for (const Event event :
           {Event::kStop, Event::kDeadlineMissed, Event::kFollowingError, Event::kDeviceFault}) {
        EXPECT_EQ(next_mode(mode, event), Mode::kSafeStop) << to_string(mode) << ", " << to_string(event);
      }
    } else {
      EXPECT_FALSE(is_armed(next_mode(mode, Event::kStop)));
      EXPECT_FALSE(is_armed(next_mode(mode, Event::kDeviceFault)));
    }
  }
}

TEST(Modes, SafeStopAndFaultAreLeftByAResetAlone) {
  for (std::size_t i = 0; i < kEvents; ++i) {
    const auto event = static_cast<Event>(i);
    if (event == Event::kReset) continue;
    const Mode after_stop = next_mode(Mode::kSafeStop, event);
    EXPECT_TRUE(after_stop == Mode::kSafeStop || after_stop == Mode::kFault) << to_string(event);
    EXPECT_EQ(next_mode(Mode::kFault, event), Mode::kFault) << to_string(event);
  }
}

TEST(Modes, DrivesGoOnByTheOperatorsWordAlone) {
  for (const Mode mode : kAllModes) {
    for (std::size_t i = 0; i < kEvents; ++i) {
      const auto event = static_cast<Event>(i);
      if (!is_armed(mode) && is_armed(next_mode(mode, event))) {
        EXPECT_EQ(event, Event::kArm);
      }
    }
  }
}

TEST(Supervisor, VisitsEveryTransition) {
  for (const Transition& row : kTransitions) {
    SCOPED_TRACE(std::string(to_string(row.from)) + ", " + to_string(row.event));
    Operated it;
    it.go_to(row.from);
    ASSERT_EQ(it.supervisor.mode(), row.from);
    const std::uint64_t before = it.supervisor.changes();
    it.raise(row.event);
    ASSERT_GT(it.supervisor.changes(), before);
    const ModeChange& change = it.supervisor.change(before);
    EXPECT_EQ(change.from, row.from);
    EXPECT_EQ(change.event, row.event);
    EXPECT_EQ(change.to, row.to);
    EXPECT_EQ(change.t_ns, it.t_ns);
  }
}

TEST(Supervisor, GoesOnServoingWhenTheTargetIsBack) {
  Operated it;
  it.go_to(Mode::kServo);
  ASSERT_EQ(it.raise(Event::kTargetLost), Mode::kSearch);
  EXPECT_EQ(it.raise(Event::kTargetFound), Mode::kServo);
}

TEST(Supervisor, ForgetsTheWishToServoInAStop) {
  Operated it;
  it.go_to(Mode::kServo);
  it.raise(Event::kStop);
  ASSERT_EQ(it.raise(Event::kReset), Mode::kIdle);
  it.raise(Event::kArm);
  EXPECT_EQ(it.step(), Mode::kTrack);
}

TEST(Supervisor, AStopOutlastsCommandsOfTheSamePeriod) {
  Operated it;
  it.go_to(Mode::kServo);
  it.supervisor.command(OperatorCommand::kStop);
  it.supervisor.command(OperatorCommand::kServo);
  EXPECT_EQ(it.step(), Mode::kSafeStop);
}

TEST(Supervisor, IsNotResetWhileSomethingMovesOrIsBroken) {
  Operated it;
  it.go_to(Mode::kServo);
  it.raise(Event::kStop);
  it.conditions.at_rest = false;
  EXPECT_EQ(it.raise(Event::kReset), Mode::kSafeStop);
  it.conditions.at_rest = true;
  it.conditions.device_fault = true;
  EXPECT_EQ(it.raise(Event::kReset), Mode::kFault);
  EXPECT_EQ(it.raise(Event::kReset), Mode::kFault);
  it.conditions.device_fault = false;
  EXPECT_NE(it.raise(Event::kReset), Mode::kFault);
}

TEST(Supervisor, CountsMissedDeadlinesInARow) {
  Operated it;
  it.go_to(Mode::kServo);
  it.conditions.missed_deadlines = 2;
  EXPECT_EQ(it.step(), Mode::kServo);
  it.conditions.missed_deadlines = 3;
  EXPECT_EQ(it.step(), Mode::kSafeStop);
}

TEST(Supervisor, IsNeverArmedWithABrokenDeviceWhateverHappens) {
  testing::Random random(11);
  Operated it;
  it.go_to(Mode::kIdle);
  int armed = 0;
  for (int i = 0; i < 200000; ++i) {
    const auto chance = [&](double p) { return random.between(0, 1) < p; };
    Conditions& c = it.conditions;
    c.device_fault = chance(0.05);
    c.following_error = chance(0.02);
    c.target_believed = chance(0.7);
    c.at_rest = chance(0.5);
    c.missed_deadlines = static_cast<int>(random.between(0, 3.2));
    c.self_test = chance(0.9) ? SelfTest::kPassed : SelfTest::kFailed;
    if (chance(0.5)) {
      it.supervisor.command(static_cast<OperatorCommand>(random.below(6)));
    }
    const Mode mode = it.step();
    armed += is_armed(mode) ? 1 : 0;
    if (c.device_fault || c.missed_deadlines >= 3) {
      ASSERT_FALSE(is_armed(mode)) << to_string(mode);
    }
    if (mode == Mode::kServo || mode == Mode::kTrack) {
      ASSERT_TRUE(c.target_believed);
    }
  }
  EXPECT_GT(armed, 1000);
}

}  // namespace
}  // namespace vergence
