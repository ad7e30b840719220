// What figures and metrics are made of: parts of a log.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tools/report/figure.hpp"
#include "tools/report/html_report.hpp"
#include "tools/report/log_table.hpp"
#include "tools/report/metric.hpp"

namespace vergence::demo {

// A stretch of a log. Rows without a value are passed over.
struct Window {
  double from_s = 0;
  double to_s = 1e9;
};

[[nodiscard]] double rms(const std::vector<double>& values);
[[nodiscard]] double largest(const std::vector<double>& values);  // of the absolute values; NaN of none

// a - b in the window, where both have a value.
[[nodiscard]] std::vector<double> difference(const tools::LogTable& log, const std::string& a,
                                             const std::string& b, const Window& window);

// Length of the difference of the positions "<a>_x_mm" ... and of the vector part of the quaternion between
// the orientations "<a>_e1" ...
[[nodiscard]] std::vector<double> distances_mm(const tools::LogTable& log, const std::string& a,
                                               const std::string& b, const Window& window);
[[nodiscard]] std::vector<double> turns_e(const tools::LogTable& log, const std::string& a,
                                          const std::string& b, const Window& window);

// The six errors of the frames vision looked at: "seen" against "true".
struct SeenErrors {
  std::array<double, 3> rms_mm{};
  double rms_e = 0;
  double largest_mm = 0;
  double largest_e = 0;
  int frames = 0;
  int tracked = 0;  // of them; the errors are of these
};
[[nodiscard]] SeenErrors seen_errors(const tools::LogTable& log, const Window& window);

// Time of the first frame that was tracked, and how many came before it; NaN and all where none was.
struct FirstLock {
  double t_s = 0;
  int frames_before = 0;
};
[[nodiscard]] FirstLock first_lock(const tools::LogTable& log);

// A column over time as a curve.
[[nodiscard]] tools::Curve curve(const tools::LogTable& log, const std::string& column,
                                 const std::string& label);
// Points of rows that have a value: what comes frame by frame.
[[nodiscard]] tools::Curve points(const tools::LogTable& log, const std::string& column,
                                  const std::string& label);
// a - b over time.
[[nodiscard]] tools::Curve error_curve(const tools::LogTable& log, const std::string& a, const std::string& b,
                                       const std::string& label);

// Six panels, x y z over e1 e2 e3: hand, where it is wanted, and target.
[[nodiscard]] tools::Figure pose_figure(const tools::LogTable& log, const std::string& title);
// What was seen frame by frame against the truth, in the hand: six panels, and six of the errors.
[[nodiscard]] tools::Figure seen_figure(const tools::LogTable& log, const std::string& title);
[[nodiscard]] tools::Figure seen_error_figure(const tools::LogTable& log, const std::string& title);

// Writes it and makes a picture of a report of it.
[[nodiscard]] tools::Picture drawn(const std::filesystem::path& png, const tools::Figure& figure,
                                   const std::string& caption);

// Short for the report's table.
[[nodiscard]] tools::Metric at_most(const std::string& name, double value, const std::string& unit,
                                    std::optional<double> target, std::optional<std::string> thesis,
                                    const std::string& explanation);
[[nodiscard]] tools::Metric at_least(const std::string& name, double value, const std::string& unit,
                                     std::optional<double> target, std::optional<std::string> thesis,
                                     const std::string& explanation);

}  // namespace vergence::demo
