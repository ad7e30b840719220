#include "tools/bringup/camera_checks.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <numeric>
#include <string>

#include "hal/v4l2/pixel_formats.hpp"
#include "hal/v4l2/video_error.hpp"

namespace vergence::tools {
namespace {

constexpr double kRateTolerance = 0.01;
constexpr double kRateFails = 0.1;
constexpr double kMostJitter_ms = 2;
constexpr double kMostLost = 0.01;   // share of the frames; fewer is a warning
constexpr double kMostDrift = 0.03;  // of the brightness, over the run
constexpr double kMostFlicker = 0.03;
constexpr double kDark = 40;
constexpr double kLight = 215;
constexpr double kMostClipped = 0.05;
constexpr double kLeastColoured = 0.002;
// Votes of hue tolerate 20 degrees.
constexpr double kMostHueNoise_deg = 10;
constexpr double kMostHueDrift_deg = 3;
constexpr double kLookAhead_s = 60;
constexpr std::size_t kLeastFrames = 10;

constexpr std::array<const char*, 2> kSides = {"left", "right"};
constexpr std::array<const char*, v4l2::kControlRoles> kControls = {
    "exposure", "gain", "white_balance", "red_balance", "blue_balance", "focus"};

double to_ms(std::int64_t ns) {
  return static_cast<double>(ns) * 1e-6;
}

double share(double part, double whole) {
  return whole > 0 ? part / whole : 0;
}

// In words, and of what came of it that the driver itself says.
std::string words_of(const v4l2::VideoError& error) {
  if (v4l2::is_ok(error)) return "";
  if (error.error_number != 0) {
    return format("%s: %s", v4l2::field(error.fault), std::strerror(error.error_number));
  }
  std::array<char, 256> text{};
  return {text.data(), v4l2::write_message(error, text)};
}

std::string name_of(std::size_t side, const char* check) {
  return std::string(kSides[side]) + " " + check;
}

// ---- pictures and their rate
// --------------------------------------------------------------------------------

void judge_format(const std::string& check, const v4l2::StreamFormat& format, const v4l2::VideoConfig& config,
                  Findings& found) {
  const std::string measured = format.fourcc == 0
                                   ? "unknown"
                                   : tools::format("%s %d x %d px", v4l2::spell(format.fourcc).data(),
                                                   format.width_px, format.height_px);
  const auto asked = v4l2::known_format(config.fourcc);
  const bool is_as_asked = asked && asked->format == format.format && format.width_px == config.width_px &&
                           format.height_px == config.height_px;
  if (is_as_asked) return found.pass(check, measured);
  found.fail(
      check,
      measured + tools::format(", asked for %s %d x %d", v4l2::spell(config.fourcc).data(), config.width_px,
                               config.height_px),
      "ask for what `v4l2-ctl --list-formats-ext` lists: cameras.format, and the size in the rig file");
}

double asked_rate(const v4l2::VideoConfig& config, const v4l2::StreamFormat& format) {
  const v4l2::FrameInterval& interval = config.interval;
  if (interval.numerator != 0) return static_cast<double>(interval.denominator) / interval.numerator;
  return format.interval_ns > 0 ? 1e9 / static_cast<double>(format.interval_ns) : 0;
}

struct Rate {
  double per_s = 0;
  double jitter_ms = 0;  // standard deviation of the time between frames
};

Rate rate_of(const std::vector<SeenFrame>& frames) {
  const double span_s = to_ms(frames.back().stamp_ns - frames.front().stamp_ns) * 1e-3;
  const auto steps = static_cast<double>(frames.back().number - frames.front().number);
  if (!(span_s > 0) || !(steps > 0)) return {};
  const double interval_ms = span_s * 1e3 / steps;
  double squares = 0;
  for (std::size_t i = 1; i < frames.size(); ++i) {
    const auto passed = static_cast<double>(frames[i].number - frames[i - 1].number);
    squares += std::pow(to_ms(frames[i].stamp_ns - frames[i - 1].stamp_ns) - passed * interval_ms, 2);
  }
  return {steps / span_s, std::sqrt(squares / static_cast<double>(frames.size() - 1))};
}

void judge_rate(const std::string& check, const EyeObservation& eye, double asked, Findings& found) {
  const Rate rate = rate_of(eye.frames);
  std::string measured = format("%.2f /s", rate.per_s);
  if (asked > 0) measured += format(" of %.2f", asked);
  measured += format(", jitter %.2f ms", rate.jitter_ms);
  const double error = asked > 0 ? std::abs(rate.per_s / asked - 1) : 0;
  if (rate.per_s <= 0 || error > kRateTolerance) {
    return found.judge(
        rate.per_s <= 0 || error > kRateFails ? Outcome::kFail : Outcome::kWarn, check, measured,
        "a shorter exposure or more light (a long exposure slows the camera), a USB port of its own, "
        "or ask for the rate it keeps: cameras.frames_per_s");
  }
  found.judge(rate.jitter_ms > kMostJitter_ms ? Outcome::kWarn : Outcome::kPass, check, measured,
              "stamps are uneven: give each camera a USB controller of its own, without hubs");
}

void judge_losses(const std::string& check, const EyeObservation& eye, Findings& found) {
  const v4l2::CaptureCounts& counts = eye.counts;
  const std::uint64_t lost = counts.lost + counts.flagged + counts.incomplete + counts.bad_stamps;
  const std::string measured =
      format("%llu frames, %llu lost, %llu damaged, %llu restarts",
             static_cast<unsigned long long>(counts.frames), static_cast<unsigned long long>(counts.lost),
             static_cast<unsigned long long>(counts.flagged + counts.incomplete + counts.bad_stamps),
             static_cast<unsigned long long>(counts.restarts));
  const double part = share(static_cast<double>(lost), static_cast<double>(lost + counts.frames));
  Outcome outcome = lost > 0 ? Outcome::kWarn : Outcome::kPass;
  if (part > kMostLost || counts.restarts > 0) outcome = Outcome::kFail;
  found.judge(outcome, check, measured,
              (v4l2::is_ok(eye.error) ? "" : words_of(eye.error) + "; ") +
                  "another cable or port, one USB controller a camera, and look into `dmesg`");
}

// ---- controls
// -----------------------------------------------------------------------------------------------

void judge_left_alone(const std::string& check, const char* key, const v4l2::ControlReading& first,
                      const v4l2::ControlReading& last, Findings& found) {
  if (!last.exists && !last.has_automatic) return found.skip(check, "the camera has no such control");
  const std::string lock = format("cameras.%s = \"auto_then_lock\"", key);
  if (last.is_automatic) return found.warn(check, format("automatic, now %d", last.value), lock);
  if (first.value != last.value) {
    return found.warn(check, format("left alone: was %d, became %d", first.value, last.value), lock);
  }
  found.pass(check, format("left alone, manual, %d", last.value));
}

void judge_held(const std::string& check, const v4l2::ControlSetting& setting,
                const v4l2::ControlReading& first, const v4l2::ControlReading& last, Findings& found) {
  constexpr const char* kLeave =
      "another program or the camera itself changes it: close the program, or choose "
      "another value";
  if (!last.exists) {
    return found.fail(check, "the camera does not answer about it", "leave it alone in the configuration");
  }
  if (last.is_automatic) return found.fail(check, format("automatic again, now %d", last.value), kLeave);
  const std::int32_t wanted = setting.mode == v4l2::ControlMode::kSet ? setting.value : first.value;
  if (last.value != wanted)
    return found.fail(check, format("held at %d, now %d", wanted, last.value), kLeave);
  found.pass(check, format("held at %d", last.value));
}

void judge_controls(std::size_t side, const EyeObservation& eye, const v4l2::VideoConfig& config,
                    Findings& found) {
  for (std::size_t role = 0; role < kControls.size(); ++role) {
    const v4l2::ControlSetting& setting = config.controls[role];
    const std::string check = name_of(side, kControls[role]);
    if (setting.mode != v4l2::ControlMode::kLeave) {
      judge_held(check, setting, eye.first[role], eye.last[role], found);
      continue;
    }
    // Balances are another way to say white balance, and few cameras have a focus.
    const auto as_role = static_cast<v4l2::ControlRole>(role);
    const bool is_other_way =
        as_role == v4l2::ControlRole::kRedBalance || as_role == v4l2::ControlRole::kBlueBalance;
    const bool is_rare = as_role == v4l2::ControlRole::kFocus && !eye.last[role].exists;
    if (!is_other_way && !is_rare)
      judge_left_alone(check, kControls[role], eye.first[role], eye.last[role], found);
  }
}

// ---- light
// --------------------------------------------------------------------------------------------------

void judge_brightness(const std::string& check, const LightSummary& light, Findings& found) {
  const std::string measured =
      format("luma %.0f of 255, drift %+.1f %%, flicker %.1f %%, clipped %.1f %%", light.mean_luma,
             100 * light.luma_drift, 100 * light.luma_flicker, 100 * light.clipped_share);
  std::string remedy;
  if (light.mean_luma < kDark) remedy = "too dark: more light, a longer exposure or an open aperture";
  if (light.mean_luma > kLight) remedy = "too bright: a shorter exposure";
  if (light.clipped_share > kMostClipped)
    remedy = "too bright in parts: a shorter exposure, or no lamp in view";
  if (light.luma_flicker > kMostFlicker) {
    remedy =
        "lamps flicker: expose for whole periods of the mains (10 ms at 50 Hz), or use lamps without flicker";
  }
  if (std::abs(light.luma_drift) > kMostDrift) {
    remedy =
        "the automatic exposure seems on, or the light changes: lock cameras.exposure and cameras.gain, shut "
        "the daylight out";
  }
  found.judge(remedy.empty() ? Outcome::kPass : Outcome::kWarn, check, measured, remedy);
}

void judge_hue(const std::string& check, const LightSummary& light, Findings& found) {
  if (light.coloured_share < kLeastColoured) {
    return found.warn(check, format("%.2f %% of the picture is coloured", 100 * light.coloured_share),
                      "put the target, or anything of strong colours, before the cameras and run this again");
  }
  const std::string measured = format("noise %.1f deg, drift %+.1f deg, over %.1f %% of the picture",
                                      light.hue_noise_deg, light.hue_drift_deg, 100 * light.coloured_share);
  std::string remedy;
  if (light.hue_noise_deg > kMostHueNoise_deg) remedy = "more light and less gain; nothing may move in view";
  if (std::abs(light.hue_drift_deg) > kMostHueDrift_deg) {
    remedy = "the automatic white balance seems on: lock cameras.white_balance; nothing may move in view";
  }
  found.judge(remedy.empty() ? Outcome::kPass : Outcome::kWarn, check, measured, remedy);
}

// ---- one eye, and both
// --------------------------------------------------------------------------------------

void judge_eye(std::size_t side, const EyeObservation& eye, const v4l2::VideoConfig& config,
               Findings& found) {
  constexpr std::array kOthers = {"format", "rate",          "frames",     "exposure",
                                  "gain",   "white_balance", "brightness", "hue"};
  const std::string check = name_of(side, "opens");
  if (!eye.streamed) {
    const std::string why = v4l2::is_ok(eye.error) ? "no picture came" : words_of(eye.error);
    found.fail(check, std::string(config.path.data()) + ": " + why,
               std::string(v4l2::remedy(eye.error.fault)) +
                   "; `v4l2-ctl --list-devices` and /dev/v4l/by-path list what is there; be in the group "
                   "`video`; no "
                   "other program may have the camera open");
    for (const char* const other : kOthers) found.skip(name_of(side, other), "no picture came");
    return;
  }
  found.pass(check, config.path.data());
  judge_format(name_of(side, "format"), eye.format, config, found);
  if (eye.frames.size() < kLeastFrames) {
    found.fail(name_of(side, "rate"), format("%zu frames in all", eye.frames.size()),
               (v4l2::is_ok(eye.error) ? "" : words_of(eye.error) + "; ") +
                   "run longer (--seconds); check cable and port");
  } else {
    judge_rate(name_of(side, "rate"), eye, asked_rate(config, eye.format), found);
  }
  judge_losses(name_of(side, "frames"), eye, found);
  judge_controls(side, eye, config, found);
  judge_brightness(name_of(side, "brightness"), eye.light, found);
  judge_hue(name_of(side, "hue"), eye.light, found);
}

void judge_skew(const CameraObservation& seen, const v4l2::StereoVideoConfig& config, Findings& found) {
  constexpr const char* kCheck = "skew of the pair";
  const Skew skew = skew_of(seen.eyes[0].frames, seen.eyes[1].frames);
  if (skew.pairs < kLeastFrames) return found.skip(kCheck, "it takes pictures of both cameras");
  const double most_ms = to_ms(config.max_skew_ns);
  const std::string measured = format("median %.2f ms, largest %.2f ms of %.2f, drift %+.0f us/s",
                                      skew.median_ms, skew.largest_ms, most_ms, skew.drift_us_per_s);
  if (skew.median_ms > most_ms) {
    return found.fail(
        kCheck, measured,
        "trigger both cameras together; or accept more with cameras.max_skew_ms, at the cost of depth "
        "while things move");
  }
  if (skew.largest_ms > most_ms) {
    return found.warn(kCheck, measured,
                      "some pairs are lost: trigger both cameras together, or raise max_skew_ms");
  }
  const double later_ms = skew.median_ms + std::abs(skew.drift_us_per_s) * 1e-3 * kLookAhead_s;
  found.judge(later_ms > most_ms ? Outcome::kWarn : Outcome::kPass, kCheck, measured,
              "the cameras run freely and drift apart within a minute: trigger both together");
}

double median_of(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

Skew skew_of(const std::vector<SeenFrame>& left, const std::vector<SeenFrame>& right) {
  Skew skew;
  if (left.empty() || right.empty()) return skew;
  std::vector<double> signed_ms;
  std::vector<double> sizes_ms;
  std::size_t r = 0;
  for (const SeenFrame& frame : left) {
    const auto distance = [&](std::size_t i) { return std::abs(frame.stamp_ns - right[i].stamp_ns); };
    while (r + 1 < right.size() && distance(r + 1) <= distance(r)) ++r;
    // At the ends a partner may never have been waited for.
    if (frame.stamp_ns < right.front().stamp_ns || frame.stamp_ns > right.back().stamp_ns) continue;
    signed_ms.push_back(to_ms(frame.stamp_ns - right[r].stamp_ns));
    sizes_ms.push_back(std::abs(signed_ms.back()));
  }
  skew.pairs = sizes_ms.size();
  if (sizes_ms.empty()) return skew;
  skew.median_ms = median_of(sizes_ms);
  skew.largest_ms = *std::max_element(sizes_ms.begin(), sizes_ms.end());
  const std::size_t quarter = signed_ms.size() / 4;
  const double span_s = to_ms(left.back().stamp_ns - left.front().stamp_ns) * 1e-3 * 0.75;
  if (quarter == 0 || !(span_s > 0)) return skew;
  const auto at = [&](std::size_t i) { return signed_ms.begin() + static_cast<std::ptrdiff_t>(i); };
  const double begin = median_of({at(0), at(quarter)});
  const double end = median_of({at(signed_ms.size() - quarter), signed_ms.end()});
  skew.drift_us_per_s = (end - begin) * 1e3 / span_s;
  return skew;
}

std::vector<Finding> judge(const CameraObservation& seen, const v4l2::StereoVideoConfig& config) {
  Findings found("cameras");
  for (std::size_t side = 0; side < 2; ++side) judge_eye(side, seen.eyes[side], config.eyes[side], found);
  judge_skew(seen, config, found);
  return found.take();
}

}  // namespace vergence::tools
