// The state machine of CiA 402: every statusword, every controlword, every transition.
#include "hal/canopen/drive_state.hpp"

#include <gtest/gtest.h>

#include <set>
#include <vector>

namespace vergence::canopen {
namespace {

constexpr DriveState kStates[] = {DriveState::kNotReady,         DriveState::kSwitchOnDisabled,
                                  DriveState::kReadyToSwitchOn,  DriveState::kSwitchedOn,
                                  DriveState::kOperationEnabled, DriveState::kQuickStopActive,
                                  DriveState::kFaultReaction,    DriveState::kFault};

// Masks and values of CiA 402-2, table 30.
struct Row {
  unsigned mask;
  unsigned value;
  DriveState state;
};
constexpr Row kRows[] = {
    {0x4F, 0x00, DriveState::kNotReady},         {0x4F, 0x40, DriveState::kSwitchOnDisabled},
    {0x6F, 0x21, DriveState::kReadyToSwitchOn},  {0x6F, 0x23, DriveState::kSwitchedOn},
    {0x6F, 0x27, DriveState::kOperationEnabled}, {0x6F, 0x07, DriveState::kQuickStopActive},
    {0x4F, 0x0F, DriveState::kFaultReaction},    {0x4F, 0x08, DriveState::kFault},
};

TEST(DriveStateTest, EveryStatuswordIsDecodedByTheStandardsMasks) {
  int known = 0;
  for (unsigned word = 0; word <= 0xFFFF; ++word) {
    DriveState expected = DriveState::kUnknown;
    int matches = 0;
    for (const Row& row : kRows) {
      if ((word & row.mask) != row.value) continue;
      expected = row.state;
      ++matches;
    }
    ASSERT_LE(matches, 1) << word;
    ASSERT_EQ(decode_state(static_cast<std::uint16_t>(word)), expected) << std::hex << word;
    known += matches;
  }
  EXPECT_EQ(known, 12 * 1024);  // of 64 patterns of the six bits
  EXPECT_TRUE(is_fault(DriveState::kUnknown));
  for (const DriveState state : kStates) {
    EXPECT_EQ(decode_state(state_bits(state)), state);
    EXPECT_EQ(is_fault(state), state == DriveState::kFault || state == DriveState::kFaultReaction);
  }
}

// Masks and values of the commands of CiA 402-2, table 28.
TEST(DriveStateTest, EveryControlwordIsDecodedByTheStandardsMasks) {
  for (unsigned word = 0; word <= 0xFFFF; ++word) {
    DriveCommand expected = DriveCommand::kNone;
    if ((word & 0x80) != 0) {
      expected = DriveCommand::kFaultReset;
    } else if ((word & 0x02) == 0) {
      expected = DriveCommand::kDisableVoltage;
    } else if ((word & 0x06) == 0x02) {
      expected = DriveCommand::kQuickStop;
    } else if ((word & 0x07) == 0x06) {
      expected = DriveCommand::kShutdown;
    } else if ((word & 0x0F) == 0x07) {
      expected = DriveCommand::kSwitchOn;
    } else if ((word & 0x0F) == 0x0F) {
      expected = DriveCommand::kEnableOperation;
    }
    ASSERT_EQ(decode_command(static_cast<std::uint16_t>(word), 0), expected) << std::hex << word;
    const DriveCommand held = (word & 0x80) != 0 ? DriveCommand::kNone : expected;
    ASSERT_EQ(decode_command(static_cast<std::uint16_t>(word), 0x80), held) << std::hex << word;
  }
  EXPECT_EQ(controlword(DriveCommand::kShutdown), 0x06);
  EXPECT_EQ(controlword(DriveCommand::kSwitchOn), 0x07);
  EXPECT_EQ(controlword(DriveCommand::kEnableOperation), 0x0F);
  EXPECT_EQ(controlword(DriveCommand::kDisableVoltage), 0x00);
  EXPECT_EQ(controlword(DriveCommand::kQuickStop), 0x02);
  EXPECT_EQ(controlword(DriveCommand::kFaultReset), 0x80);
}

// By controlword, as the figure of CiA 402-2 has them.
TEST(DriveStateTest, EveryTransitionIsTheStandards) {
  using S = DriveState;
  const struct {
    int number;
    S from;
    int word;
    S to;
  } rows[] = {
      {2, S::kSwitchOnDisabled, 0x06, S::kReadyToSwitchOn},
      {3, S::kReadyToSwitchOn, 0x07, S::kSwitchedOn},
      {4, S::kSwitchedOn, 0x0F, S::kOperationEnabled},
      {5, S::kOperationEnabled, 0x07, S::kSwitchedOn},
      {6, S::kSwitchedOn, 0x06, S::kReadyToSwitchOn},
      {7, S::kReadyToSwitchOn, 0x00, S::kSwitchOnDisabled},
      {7, S::kReadyToSwitchOn, 0x02, S::kSwitchOnDisabled},
      {8, S::kOperationEnabled, 0x06, S::kReadyToSwitchOn},
      {9, S::kOperationEnabled, 0x00, S::kSwitchOnDisabled},
      {10, S::kSwitchedOn, 0x00, S::kSwitchOnDisabled},
      {10, S::kSwitchedOn, 0x02, S::kSwitchOnDisabled},
      {11, S::kOperationEnabled, 0x02, S::kQuickStopActive},
      {12, S::kQuickStopActive, 0x00, S::kSwitchOnDisabled},
      {15, S::kFault, 0x80, S::kSwitchOnDisabled},
      {16, S::kQuickStopActive, 0x0F, S::kOperationEnabled},
  };
  std::set<int> numbers;
  std::set<std::pair<S, DriveCommand>> moving;
  for (const auto& row : rows) {
    const DriveCommand command = decode_command(static_cast<std::uint16_t>(row.word), 0);
    EXPECT_EQ(next_state(row.from, command), row.to) << row.number;
    numbers.insert(row.number);
    moving.insert({row.from, command});
  }
  EXPECT_EQ(numbers, (std::set<int>{2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 15, 16}));
  // And there is no other.
  for (const S from : kStates) {
    for (int command = 0; command <= static_cast<int>(DriveCommand::kFaultReset); ++command) {
      const auto c = static_cast<DriveCommand>(command);
      if (moving.count({from, c}) == 0) {
        EXPECT_EQ(next_state(from, c), from) << command;
      }
    }
  }
  EXPECT_EQ(kDriveTransitions.size(), std::size(rows));
  for (std::size_t i = 0; i < std::size(rows); ++i) EXPECT_EQ(kDriveTransitions[i].number, rows[i].number);
}

// A drive that obeys, and passes its automatic transitions, gets where it is wanted from every state.
TEST(DriveStateTest, EveryGoalIsReachedFromEveryState) {
  const auto arrive = [](DriveGoal goal, DriveState state, std::vector<DriveState>* way = nullptr) {
    DriveCommand before = DriveCommand::kNone;
    for (int i = 0; i < 8; ++i) {
      const DriveCommand command = command_towards(goal, state, before);
      state = next_state(state, decode_command(controlword(command), controlword(before)));
      before = command;
      if (way != nullptr) way->push_back(state);
    }
    return state;
  };
  for (const DriveState from : kStates) {
    const bool obeys = from != DriveState::kNotReady && from != DriveState::kFaultReaction;
    if (!obeys) continue;
    EXPECT_EQ(arrive(DriveGoal::kReset, from), DriveState::kSwitchOnDisabled) << describe(from);
    if (from == DriveState::kFault) {
      EXPECT_EQ(arrive(DriveGoal::kOn, from), from);  // no fault is reset unasked
      EXPECT_EQ(arrive(DriveGoal::kOff, from), from);
      continue;
    }
    EXPECT_EQ(arrive(DriveGoal::kOn, from), DriveState::kOperationEnabled) << describe(from);
    EXPECT_EQ(arrive(DriveGoal::kOff, from), DriveState::kSwitchOnDisabled) << describe(from);
    const DriveState stopped = arrive(DriveGoal::kQuickStop, from);
    EXPECT_TRUE(stopped == DriveState::kQuickStopActive || stopped == DriveState::kSwitchOnDisabled);
  }
  std::vector<DriveState> way;
  (void)arrive(DriveGoal::kOn, DriveState::kQuickStopActive, &way);
  EXPECT_EQ(way[0], DriveState::kSwitchOnDisabled);  // transition 16 is not relied on
}

TEST(DriveStateTest, ResetsByAnEdge) {
  const DriveCommand first = command_towards(DriveGoal::kReset, DriveState::kFault, DriveCommand::kNone);
  const DriveCommand second = command_towards(DriveGoal::kReset, DriveState::kFault, first);
  EXPECT_EQ(first, DriveCommand::kFaultReset);
  EXPECT_EQ(controlword(second) & 0x80, 0);
  EXPECT_EQ(command_towards(DriveGoal::kReset, DriveState::kFault, second), DriveCommand::kFaultReset);
}

TEST(DriveStateTest, HomingIsReadFromItsThreeBits) {
  const HomingState by_bits[8] = {HomingState::kInProgress, HomingState::kNotDone,     HomingState::kAttained,
                                  HomingState::kDone,       HomingState::kErrorMoving, HomingState::kError,
                                  HomingState::kUnknown,    HomingState::kUnknown};
  for (unsigned word = 0; word <= 0xFFFF; ++word) {
    const unsigned bits = ((word >> 13) & 1) << 2 | ((word >> 12) & 1) << 1 | ((word >> 10) & 1);
    ASSERT_EQ(decode_homing(static_cast<std::uint16_t>(word)), by_bits[bits]) << std::hex << word;
  }
  EXPECT_STREQ(describe(HomingState::kDone), "done");
}

TEST(DriveStateTest, StatesHaveWords) {
  std::set<std::string> words;
  for (const DriveState state : kStates) words.insert(describe(state));
  words.insert(describe(DriveState::kUnknown));
  EXPECT_EQ(words.size(), 9U);
}

}  // namespace
}  // namespace vergence::canopen
