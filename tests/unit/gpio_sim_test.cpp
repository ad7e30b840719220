// Step lines through the library that is installed, on the kernel's own gpio-sim: the wires get what was set,
// and setting them asks for no memory. In the rig (tools/rig/run self-check), which names chip and lines;
// skipped elsewhere.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "hal/gpio_step/libgpiod_lines.hpp"
#include "tests/noheap/heap_counter.hpp"

namespace vergence::step {
namespace {

constexpr std::size_t kEnable = kOutputLines;  // offsets of the rig's chip: outputs, enable, switches
constexpr std::size_t kInputs = kEnable + 1;
constexpr std::uint32_t kAllOutputs = (1U << kOutputLines) - 1;

GpioName named(const std::string& text) {
  GpioName name{};
  std::copy_n(text.begin(), std::min(text.size(), name.size() - 1), name.begin());
  return name;
}

std::string word_of(const std::filesystem::path& file) {
  std::string word;
  std::ifstream(file) >> word;
  return word;
}

class GpioSimTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* const chip = std::getenv("RIG_GPIO_CHIP");
    const char* const names = std::getenv("RIG_GPIO_LINES");
    if (chip == nullptr || names == nullptr) GTEST_SKIP() << "not in the rig: RIG_GPIO_CHIP is not set";
    const std::filesystem::path sim = std::filesystem::path("/sys/kernel/config/gpio-sim") / chip;
    wires = std::filesystem::path("/sys/devices/platform") / word_of(sim / "dev_name") /
            word_of(sim / "bank0" / "chip_name");
    ASSERT_TRUE(std::filesystem::is_directory(wires)) << wires;
    std::istringstream words(names);
    std::vector<std::string> lines;
    for (std::string name; words >> name;) lines.push_back(name);
    ASSERT_EQ(lines.size(), kInputs + kInputLines);
    config.outputs_chip = config.enable_chip = config.inputs_chip = named(chip);
    for (std::size_t i = 0; i < config.outputs.size(); ++i) config.outputs[i].name = named(lines[i]);
    config.enable.name = named(lines[kEnable]);
    for (std::size_t i = 0; i < config.inputs.size(); ++i) config.inputs[i].name = named(lines[kInputs + i]);
  }

  [[nodiscard]] std::filesystem::path wire(std::size_t offset) const {
    return wires / ("sim_gpio" + std::to_string(offset));
  }
  [[nodiscard]] std::uint32_t outputs() const {
    std::uint32_t levels = 0;
    for (std::size_t i = 0; i < kOutputLines; ++i) {
      if (word_of(wire(i) / "value") == "1") levels |= 1U << i;
    }
    return levels;
  }
  void press(std::uint32_t switches) const {
    for (std::size_t i = 0; i < kInputLines; ++i) {
      std::ofstream(wire(kInputs + i) / "pull") << (((switches >> i) & 1U) != 0 ? "pull-up" : "pull-down");
    }
  }

  LinesConfig config;
  std::filesystem::path wires;
};

TEST_F(GpioSimTest, WiresGetWhatWasSetAndSwitchesAreRead) {
  config.outputs[3].inverted = config.inputs[1].inverted = true;
  LibgpiodLines lines;
  const LinesError error = lines.open(config);
  ASSERT_EQ(error.kind, LinesErrorKind::kNone) << describe(error.kind) << " " << error.what.data();
  EXPECT_EQ(outputs(), (forward_bit(0) | forward_bit(1) | forward_bit(2)) ^ 8U);
  EXPECT_EQ(word_of(wire(kEnable) / "value"), "0");
  for (std::uint32_t levels = 0; levels <= kAllOutputs; ++levels) {
    ASSERT_TRUE(lines.set_outputs(levels));
    ASSERT_EQ(outputs(), levels ^ 8U);
  }
  for (const bool on : {true, false, true}) {
    ASSERT_TRUE(lines.set_enable(on));
    EXPECT_EQ(word_of(wire(kEnable) / "value"), on ? "1" : "0");
  }
  EXPECT_EQ(outputs(), kAllOutputs ^ 8U);
  for (const std::uint32_t pressed : {0U, 1U, 2U, 0x2aU, 0x3fU, 0U}) {
    press(pressed);
    std::uint32_t levels = 0;
    ASSERT_TRUE(lines.read_inputs(levels));
    EXPECT_EQ(levels, pressed ^ 2U);
  }
  lines.close();
  EXPECT_EQ(word_of(wire(kEnable) / "value"), "0");
}

TEST_F(GpioSimTest, SaysWhichLineIsTakenAndWhatIsNotThere) {
  LibgpiodLines lines;
  ASSERT_EQ(lines.open(config).kind, LinesErrorKind::kNone);
  LibgpiodLines second;
  LinesError error = second.open(config);
  EXPECT_EQ(error.kind, LinesErrorKind::kLineBusy);
  EXPECT_EQ(error.what, config.enable.name);
  EXPECT_TRUE(lines.set_outputs(0));
  lines.close();
  ASSERT_EQ(second.open(config).kind, LinesErrorKind::kNone);
  second.close();
  LinesConfig wrong = config;
  wrong.outputs[2].name = named("nothing");
  error = second.open(wrong);
  EXPECT_EQ(error.kind, LinesErrorKind::kLineNotFound);
  EXPECT_EQ(error.what, wrong.outputs[2].name);
  wrong = config;
  wrong.outputs_chip = named("nowhere");
  EXPECT_EQ(second.open(wrong).kind, LinesErrorKind::kChipNotFound);
  // By the chip's name instead of its label.
  wrong.outputs_chip = named(wires.filename().string());
  EXPECT_EQ(second.open(wrong).kind, LinesErrorKind::kNone);
}

TEST_F(GpioSimTest, SettingAndReadingAskForNoMemory) {
  LibgpiodLines lines;
  ASSERT_EQ(lines.open(config).kind, LinesErrorKind::kNone);
  bool all_work = true;
  std::uint32_t levels = 0;
  const testing::HeapCounter counter;
  for (std::uint32_t i = 0; i < 1000; ++i) {
    all_work = lines.set_outputs(i & kAllOutputs) && all_work;
    all_work = lines.set_enable(i % 3 == 0) && all_work;
    all_work = lines.read_inputs(levels) && all_work;
  }
  EXPECT_EQ(counter.calls(), 0);
  EXPECT_TRUE(all_work);
}

// The eyes' task drops the enable line while the step task makes pulses and raises it.
TEST_F(GpioSimTest, TheEnableLineIsSetFromTwoThreads) {
  LibgpiodLines lines;
  ASSERT_EQ(lines.open(config).kind, LinesErrorKind::kNone);
  std::atomic<bool> all_work{true};
  const auto set_often = [&](bool makes_pulses) {
    for (std::uint32_t i = 0; i < 2000; ++i) {
      if (!lines.set_enable((i & 1U) != 0)) all_work = false;
      if (makes_pulses && !lines.set_outputs(i & kAllOutputs)) all_work = false;
    }
  };
  std::thread eyes(set_often, false);
  set_often(true);
  eyes.join();
  EXPECT_TRUE(all_work);
  ASSERT_TRUE(lines.set_enable(false));
  EXPECT_EQ(word_of(wire(kEnable) / "value"), "0");
}

}  // namespace
}  // namespace vergence::step
