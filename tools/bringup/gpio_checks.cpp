#include "tools/bringup/gpio_checks.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdlib>

namespace vergence::tools {
namespace {

constexpr std::array<const char*, kPanTiltMotors> kMotors = {"tilt", "pan_right", "pan_left"};
constexpr double kMostTimingError_us = 500;  // of a period, at the low rate of the test

std::string motor_name(std::size_t motor, const char* what) {
  return std::string(kMotors[motor]) + " " + what;
}

std::string labels_of(const std::vector<GpioChip>& chips) {
  std::string list;
  for (const GpioChip& chip : chips)
    list += (list.empty() ? "" : ", ") + chip.device + " [" + chip.label + "]";
  return list.empty() ? "there are none" : "there are " + list;
}

struct Found {
  const GpioLine* line = nullptr;
  bool has_chip = false;
  std::size_t namesakes = 0;
};

Found find(const std::vector<GpioChip>& chips, const WantedLine& wanted) {
  Found found;
  for (const GpioChip& chip : chips) {
    if (chip.label != wanted.chip) continue;
    found.has_chip = true;
    for (const GpioLine& line : chip.lines) {
      if (line.name != wanted.name) continue;
      if (found.line == nullptr) found.line = &line;
      ++found.namesakes;
    }
  }
  return found;
}

void judge_line(const GpioObservation& seen, const WantedLine& wanted, Findings& findings) {
  const Found found = find(seen.chips, wanted);
  const std::string where = "'" + wanted.name + "' of chip '" + wanted.chip + "'";
  if (wanted.name.empty()) {
    return findings.fail(wanted.role, "has no name", "name it in [eyes]: `gpioinfo` lists chips and lines");
  }
  if (!found.has_chip) {
    return findings.fail(
        wanted.role, where + ": no such chip",
        labels_of(seen.chips) + ": set its label in [eyes]; is the driver's overlay loaded?");
  }
  if (found.line == nullptr) {
    return findings.fail(wanted.role, where + ": no such line",
                         "`gpioinfo` lists the names; gpio-line-names of the device tree gives them");
  }
  const GpioLine& line = *found.line;
  if (line.is_used) {
    return findings.fail(wanted.role,
                         where + " is used by " + (line.consumer.empty() ? "the kernel" : line.consumer),
                         "stop the program that has it, or take another line");
  }
  if (!wanted.is_output && line.is_output) {
    return findings.fail(wanted.role, where + " is an output",
                         "a switch against an output may destroy both: unplug it, make the line an input");
  }
  const std::string measured = where + (line.is_output ? ", free, an output" : ", free, an input");
  findings.judge(found.namesakes > 1 ? Outcome::kWarn : Outcome::kPass, wanted.role, measured,
                 "several lines have this name, and the first is taken: rename the others");
}

void judge_levels(const GpioObservation& seen, const step::LinesConfig& config, Findings& findings) {
  for (std::size_t motor = 0; motor < kMotors.size(); ++motor) {
    std::string measured;
    int pressed = 0;
    for (std::size_t end = 0; end < 2; ++end) {
      const std::size_t bit = 2 * motor + end;
      if (config.inputs[bit].name[0] == '\0' || !seen.levels[bit]) continue;
      const bool is_pressed = *seen.levels[bit] != config.inputs[bit].inverted;
      pressed += is_pressed ? 1 : 0;
      measured += std::string(measured.empty() ? "" : ", ") + (end == 0 ? "low end " : "high end ") +
                  (is_pressed ? "pressed" : "open");
    }
    const std::string check = motor_name(motor, "switches");
    if (measured.empty()) {
      findings.skip(check, "none is configured, or none can be read");
    } else {
      findings.judge(pressed == 2 ? Outcome::kWarn : Outcome::kPass, check, measured,
                     "both at once cannot be: low_switch_inverted, high_switch_inverted, or a broken wire");
    }
  }
}

// Of neighbouring pulses, how far the time between them differs from that of those issued.
double largest_timing_error_us(const PulseObservation& seen) {
  double largest = 0;
  const std::size_t count = std::min(seen.issued_ns.size(), seen.looped_ns.size());
  for (std::size_t i = 1; i < count; ++i) {
    const std::int64_t issued = seen.issued_ns[i] - seen.issued_ns[i - 1];
    const std::int64_t looped = seen.looped_ns[i] - seen.looped_ns[i - 1];
    largest = std::max(largest, static_cast<double>(std::abs(issued - looped)) * 1e-3);
  }
  return largest;
}

void judge_loopback(std::size_t motor, const PulseObservation& seen, Findings& findings) {
  const std::string check = motor_name(motor, "loop-back");
  const double error_us = largest_timing_error_us(seen);
  const std::string measured = format("%zu of %zu pulses came back, their times within %.0f us",
                                      seen.looped_ns.size(), seen.issued_ns.size(), error_us);
  if (seen.looped_ns.size() != seen.issued_ns.size()) {
    return findings.fail(
        check, measured,
        "fewer: wiring, level shifter, or steplen_us too short; more: it rings, terminate it");
  }
  findings.judge(error_us > kMostTimingError_us ? Outcome::kWarn : Outcome::kPass, check, measured,
                 "pulses come late: see the findings of rt, and measure the jitter with `vergence bench rt`");
}

void judge_run(std::size_t motor, const PulseObservation& seen, std::int64_t wanted_steps,
               Findings& findings) {
  const std::string check = motor_name(motor, "moved");
  if (!seen.problem.empty()) {
    return findings.fail(check, seen.problem,
                         "see the findings of its lines; docs/bringup.md says what to try");
  }
  const std::string measured =
      format("%zu pulses, %lld steps there, back at %lld, %llu late", seen.issued_ns.size(),
             static_cast<long long>(seen.farthest_steps), static_cast<long long>(seen.final_steps),
             static_cast<unsigned long long>(seen.late_events));
  if (seen.farthest_steps < wanted_steps) {
    return findings.fail(check, measured, "a switch at an end of the range, or a fault, ended it early");
  }
  if (seen.final_steps != 0) {
    return findings.warn(check, measured, "it did not come back to where it was: raise ramp_steps_per_s2");
  }
  findings.pass(check, measured);
}

}  // namespace

std::vector<WantedLine> wanted_lines(const step::LinesConfig& config) {
  std::vector<WantedLine> lines;
  for (std::size_t motor = 0; motor < kMotors.size(); ++motor) {
    for (std::size_t i = 0; i < 2; ++i) {
      lines.push_back({motor_name(motor, i == 0 ? "step" : "direction"), config.outputs_chip.data(),
                       config.outputs[2 * motor + i].name.data(), true});
    }
  }
  lines.push_back({"enable", config.enable_chip.data(), config.enable.name.data(), true});
  for (std::size_t motor = 0; motor < kMotors.size(); ++motor) {
    for (std::size_t end = 0; end < 2; ++end) {
      const step::LineSpec& spec = config.inputs[2 * motor + end];
      if (spec.name[0] == '\0') continue;
      lines.push_back({motor_name(motor, end == 0 ? "low switch" : "high switch"), config.inputs_chip.data(),
                       spec.name.data(), false});
    }
  }
  return lines;
}

std::vector<Finding> judge(const GpioObservation& seen, const step::LinesConfig& config) {
  Findings findings("gpio");
  if (seen.problem.empty()) {
    findings.judge(seen.chips.empty() ? Outcome::kFail : Outcome::kPass, "chips", labels_of(seen.chips),
                   "`gpiodetect` lists them: load the driver of the board");
  } else {
    findings.fail("chips", seen.problem,
                  "join the group of /dev/gpiochip*: `ls -l /dev/gpiochip*` says which");
  }
  for (const WantedLine& wanted : wanted_lines(config)) {
    if (seen.chips.empty()) {
      findings.skip(wanted.role, "there are no chips to be seen");
    } else {
      judge_line(seen, wanted, findings);
    }
  }
  judge_levels(seen, config, findings);
  return findings.take();
}

GpioObservation look_at_lines(GpioView& view, const step::LinesConfig& config) {
  GpioObservation seen;
  seen.chips = view.chips(seen.problem);
  for (std::size_t bit = 0; bit < seen.levels.size(); ++bit) {
    const WantedLine wanted{"", config.inputs_chip.data(), config.inputs[bit].name.data(), false};
    if (wanted.name.empty()) continue;
    const GpioLine* const line = find(seen.chips, wanted).line;
    if (line != nullptr && !line->is_used && !line->is_output)
      seen.levels[bit] = view.level(wanted.chip, wanted.name);
  }
  return seen;
}

std::vector<Finding> judge(const std::array<PulseObservation, kPanTiltMotors>& seen, bool has_loopback,
                           std::int64_t wanted_steps) {
  Findings findings("gpio");
  bool came_back = false;
  for (std::size_t motor = 0; motor < seen.size(); ++motor) {
    judge_run(motor, seen[motor], wanted_steps, findings);
    if (!has_loopback || seen[motor].looped_ns.empty()) continue;
    came_back = true;
    judge_loopback(motor, seen[motor], findings);
  }
  if (!has_loopback) {
    findings.skip("loop-back", "--loopback LINE names an input that a step line is wired to");
  } else if (!came_back) {
    findings.fail("loop-back", "no pulse came back",
                  "wire the step line of one motor to it, through its level shifter");
  }
  return findings.take();
}

std::vector<Finding> not_moved(const std::string& why) {
  Findings findings("gpio");
  for (std::size_t motor = 0; motor < kMotors.size(); ++motor) findings.skip(motor_name(motor, "moved"), why);
  findings.skip("loop-back", why);
  return findings.take();
}

}  // namespace vergence::tools
