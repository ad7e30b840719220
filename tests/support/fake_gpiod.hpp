// A stand-in for libgpiod, 1.x (fake_gpiod_1.cpp) or 2 (fake_gpiod_2.cpp), whichever is built for: chips and
// lines in memory, and every errno on request. Tests that link it do not link the library.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace vergence::testing {

struct FakeGpioLine {
  std::string name;
  bool is_others = false;  // somebody else has it
  bool is_ours = false;
  bool is_output = false;
  int level = 0;  // on the wire
};

struct FakeGpioChip {
  std::string name;
  std::string label;
  std::vector<FakeGpioLine> lines;
};

// One write to one line, in order.
struct FakeGpioWrite {
  std::string line;
  int level = 0;
  bool operator==(const FakeGpioWrite&) const = default;
};

struct FakeGpio {
  std::vector<FakeGpioChip> chips;
  std::vector<FakeGpioWrite> writes;  // requests' first levels among them
  int open_handles = 0;               // of chips; of 2 also of all else that is to be given back
  int set_calls = 0;
  // errno of calls that are to fail; 0: they do not.
  int list_error = 0;  // where all chips are looked through
  int open_error = 0;
  int find_error = 0;
  int output_request_error = 0;  // of several lines
  int enable_request_error = 0;  // of one line
  int input_request_error = 0;
  int set_error = 0;
  int get_error = 0;

  [[nodiscard]] FakeGpioLine& line(const std::string& name);
};

// What the functions of <gpiod.h> work on.
[[nodiscard]] FakeGpio& fake_gpio();

}  // namespace vergence::testing
