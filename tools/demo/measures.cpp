#include "tools/demo/measures.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "algo/pose.hpp"

namespace vergence::demo {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr const char* kPositions[] = {"_x_mm", "_y_mm", "_z_mm"};
constexpr const char* kTurns[] = {"_e1", "_e2", "_e3"};

using Columns = std::array<const std::vector<double>*, 6>;

Columns pose_columns(const tools::LogTable& log, const std::string& of) {
  Columns columns{};
  for (std::size_t i = 0; i < 3; ++i) {
    columns[i] = &log.column(of + kPositions[i]);
    columns[i + 3] = &log.column(of + kTurns[i]);
  }
  return columns;
}

Vector3 three(const Columns& columns, std::size_t first, std::size_t row) {
  return {(*columns[first])[row], (*columns[first + 1])[row], (*columns[first + 2])[row]};
}

template <typename Do>
void for_rows(const tools::LogTable& log, const Window& window, const Do& what) {
  const std::vector<double>& t_s = log.column("t_s");
  for (std::size_t row = 0; row < log.rows(); ++row) {
    if (t_s[row] >= window.from_s && t_s[row] <= window.to_s) what(row);
  }
}

Vector3 turn_between(const Vector3& a, const Vector3& b) {
  return multiply_quaternion_vectors(a, -b);
}

}  // namespace

double rms(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value * value;
  return values.empty() ? kNaN : std::sqrt(sum / static_cast<double>(values.size()));
}

double largest(const std::vector<double>& values) {
  double most = values.empty() ? kNaN : 0;
  for (const double value : values) most = std::max(most, std::abs(value));
  return most;
}

std::vector<double> difference(const tools::LogTable& log, const std::string& a, const std::string& b,
                               const Window& window) {
  const auto& column_a = log.column(a);
  const auto& column_b = log.column(b);
  std::vector<double> result;
  for_rows(log, window, [&](std::size_t row) {
    const double d = column_a[row] - column_b[row];
    if (std::isfinite(d)) result.push_back(d);
  });
  return result;
}

std::vector<double> distances_mm(const tools::LogTable& log, const std::string& a, const std::string& b,
                                 const Window& window) {
  std::vector<double> result;
  for_rows(log, window, [&](std::size_t row) {
    double squared = 0;
    for (const char* part : kPositions) {
      const double d = log.column(a + part)[row] - log.column(b + part)[row];
      squared += d * d;
    }
    if (std::isfinite(squared)) result.push_back(std::sqrt(squared));
  });
  return result;
}

std::vector<double> turns_e(const tools::LogTable& log, const std::string& a, const std::string& b,
                            const Window& window) {
  const Columns of_a = pose_columns(log, a);
  const Columns of_b = pose_columns(log, b);
  std::vector<double> result;
  for_rows(log, window, [&](std::size_t row) {
    const double e = turn_between(three(of_a, 3, row), three(of_b, 3, row)).norm();
    if (std::isfinite(e)) result.push_back(e);
  });
  return result;
}

SeenErrors seen_errors(const tools::LogTable& log, const Window& window) {
  const Columns seen = pose_columns(log, "seen");
  const Columns truth = pose_columns(log, "true");
  const auto& state = log.column("state");
  SeenErrors errors;
  Vector3 squares = Vector3::Zero();
  double squares_e = 0;
  for_rows(log, window, [&](std::size_t row) {
    if (std::isnan(state[row])) return;
    ++errors.frames;
    if (state[row] != 1) return;  // TrackState::kTracking
    ++errors.tracked;
    const Vector3 d = three(seen, 0, row) - three(truth, 0, row);
    const double e = turn_between(three(seen, 3, row), three(truth, 3, row)).norm();
    squares += d.cwiseAbs2();
    squares_e += e * e;
    errors.largest_mm = std::max(errors.largest_mm, d.norm());
    errors.largest_e = std::max(errors.largest_e, e);
  });
  for (std::size_t i = 0; i < 3; ++i) {
    errors.rms_mm[i] =
        errors.tracked > 0 ? std::sqrt(squares[static_cast<Eigen::Index>(i)] / errors.tracked) : kNaN;
  }
  errors.rms_e = errors.tracked > 0 ? std::sqrt(squares_e / errors.tracked) : kNaN;
  return errors;
}

FirstLock first_lock(const tools::LogTable& log) {
  const auto& state = log.column("state");
  const auto& stamp = log.column("frame_stamp_s");
  FirstLock lock{kNaN, 0};
  for (std::size_t row = 0; row < log.rows(); ++row) {
    if (std::isnan(state[row])) continue;
    if (state[row] == 1) {
      lock.t_s = stamp[row];
      return lock;
    }
    ++lock.frames_before;
  }
  return lock;
}

tools::Curve curve(const tools::LogTable& log, const std::string& column, const std::string& label) {
  tools::Curve result;
  result.label = label;
  result.x = log.column("t_s");
  result.y = log.column(column);
  return result;
}

tools::Curve points(const tools::LogTable& log, const std::string& column, const std::string& label) {
  const auto& t_s = log.column("frame_stamp_s");
  const auto& y = log.column(column);
  tools::Curve result;
  result.label = label;
  for (std::size_t row = 0; row < log.rows(); ++row) {
    if (!std::isfinite(t_s[row]) || !std::isfinite(y[row])) continue;
    result.x.push_back(t_s[row]);
    result.y.push_back(y[row]);
  }
  return result;
}

tools::Curve error_curve(const tools::LogTable& log, const std::string& a, const std::string& b,
                         const std::string& label) {
  tools::Curve result = curve(log, a, label);
  const auto& other = log.column(b);
  for (std::size_t row = 0; row < log.rows(); ++row) result.y[row] -= other[row];
  return result;
}

namespace {

constexpr const char* kComponents[] = {"_x_mm", "_y_mm", "_z_mm", "_e1", "_e2", "_e3"};
constexpr const char* kLabels[] = {"x [mm]", "y [mm]", "z [mm]", "e1", "e2", "e3"};

// Left column positions, right column orientations.
template <typename Curves>
tools::Figure six_panels(const std::string& title, const Curves& curves) {
  tools::Figure figure;
  figure.title = title;
  figure.columns = 2;
  for (std::size_t row = 0; row < 3; ++row) {
    for (const std::size_t i : {row, row + 3}) {
      tools::Panel panel;
      panel.x_label = "t [s]";
      panel.y_label = kLabels[i];
      panel.curves = curves(i);
      figure.panels.push_back(std::move(panel));
    }
  }
  return figure;
}

}  // namespace

tools::Figure pose_figure(const tools::LogTable& log, const std::string& title) {
  return six_panels(title, [&](std::size_t i) {
    tools::Curve wanted = curve(log, std::string("wanted") + kComponents[i], "hand, wanted");
    wanted.style = tools::CurveStyle::kDashed;
    return std::vector<tools::Curve>{wanted, curve(log, std::string("hand") + kComponents[i], "hand"),
                                     curve(log, std::string("target") + kComponents[i], "target")};
  });
}

tools::Figure seen_figure(const tools::LogTable& log, const std::string& title) {
  return six_panels(title, [&](std::size_t i) {
    tools::Curve truth = points(log, std::string("true") + kComponents[i], "truth");
    truth.style = tools::CurveStyle::kDashed;
    return std::vector<tools::Curve>{truth, points(log, std::string("seen") + kComponents[i], "seen")};
  });
}

tools::Figure seen_error_figure(const tools::LogTable& log, const std::string& title) {
  return six_panels(title, [&](std::size_t i) {
    tools::Curve error = points(log, std::string("seen") + kComponents[i], "seen - truth");
    const tools::Curve truth = points(log, std::string("true") + kComponents[i], "");
    for (std::size_t k = 0; k < error.y.size(); ++k) error.y[k] -= truth.y[k];
    return std::vector<tools::Curve>{error};
  });
}

tools::Picture drawn(const std::filesystem::path& png, const tools::Figure& figure,
                     const std::string& caption) {
  tools::write_figure(png, figure);
  return {png, caption};
}

namespace {

tools::Metric metric(const std::string& name, double value, const std::string& unit,
                     std::optional<double> target, tools::Bound bound, std::optional<std::string> thesis,
                     const std::string& explanation) {
  tools::Metric result;
  result.name = name;
  result.value = value;
  result.unit = unit;
  result.target = target;
  result.bound = bound;
  result.thesis = std::move(thesis);
  result.explanation = explanation;
  return result;
}

}  // namespace

tools::Metric at_most(const std::string& name, double value, const std::string& unit,
                      std::optional<double> target, std::optional<std::string> thesis,
                      const std::string& explanation) {
  return metric(name, value, unit, target, tools::Bound::kAtMost, std::move(thesis), explanation);
}

tools::Metric at_least(const std::string& name, double value, const std::string& unit,
                       std::optional<double> target, std::optional<std::string> thesis,
                       const std::string& explanation) {
  return metric(name, value, unit, target, tools::Bound::kAtLeast, std::move(thesis), explanation);
}

}  // namespace vergence::demo
