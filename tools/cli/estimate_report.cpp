#include "tools/cli/estimate_report.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>
#include <ostream>

namespace vergence::tools {
namespace {

template <class... Values>
std::string format(const char* pattern, Values... values) {
  char text[256];
  std::snprintf(text, sizeof text, pattern, values...);
  return text;
}

// Standard deviation along three axes together; nothing where the pose has no covariance.
std::optional<double> sigma(const Estimate& estimate, int first) {
  const double variance = estimate.covariance.diagonal().segment<3>(first).sum();
  if (!(variance > 0)) return {};
  return std::sqrt(variance);
}

bool is_locked(const FrameResult& result) {
  return result.estimate.state == TrackState::kTracking;
}

struct Rms {
  double sum = 0;
  std::size_t count = 0;

  void add(double value) {
    sum += value * value;
    ++count;
  }
  [[nodiscard]] double value() const { return std::sqrt(sum / static_cast<double>(count)); }
};

void print_errors(std::ostream& out, const std::vector<FrameResult>& results) {
  Rms axis[3];
  Rms position;
  Rms e;
  double largest_mm = 0;
  for (const FrameResult& result : results) {
    if (!result.error || !is_locked(result)) continue;
    for (int i = 0; i < 3; ++i) axis[i].add(result.error->position_mm[i]);
    position.add(result.error->position_mm.norm());
    e.add(result.error->e);
    largest_mm = std::max(largest_mm, result.error->position_mm.norm());
  }
  if (position.count == 0) return;
  out << format("RMS error   position %.2f mm (x %.2f, y %.2f, z %.2f; largest %.2f), orientation |e| %.4f",
                position.value(), axis[0].value(), axis[1].value(), axis[2].value(), largest_mm, e.value())
      << "\n            over the " << position.count << " tracked frames with a truth\n";
}

}  // namespace

void EstimateTable::print(const FrameResult& result) {
  if (!started_) {
    started_ = true;
    out_ << " frame     x_mm     y_mm     z_mm  +- mm       e1       e2       e3    +- e  fitness   conf  "
            "state      "
            "    ms"
         << (with_error_ ? "   err_mm    err_e" : "") << '\n';
  }
  const Estimate& estimate = result.estimate;
  const Vector3& p = estimate.pose.position_mm;
  const Vector3& e = estimate.pose.e;
  const auto plus_minus = [&](int first, const char* pattern, const char* none) {
    const auto value = sigma(estimate, first);
    return value ? format(pattern, *value) : std::string(none);
  };
  out_ << format("%6d %8.1f %8.1f %8.1f", result.frame, p.x(), p.y(), p.z())
       << plus_minus(0, " %6.2f", "      -") << format(" %8.3f %8.3f %8.3f", e.x(), e.y(), e.z())
       << plus_minus(3, " %7.4f", "       -")
       << format(" %8.3f %6.2f  %-9s %7.2f", estimate.fitness, estimate.confidence, to_string(estimate.state),
                 result.compute_ms);
  if (result.error) out_ << format(" %8.2f %8.4f", result.error->position_mm.norm(), result.error->e);
  out_ << std::endl;
}

std::string to_json(const FrameResult& result, std::uint64_t seed) {
  const Estimate& estimate = result.estimate;
  const Vector3& p = estimate.pose.position_mm;
  const Vector3& e = estimate.pose.e;
  std::vector<double> covariance;
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column < 6; ++column) covariance.push_back(estimate.covariance(row, column));
  }
  nlohmann::ordered_json json = {
      {"frame", result.frame},
      {"t_s", result.t_s},
      {"pose",
       {{"x_mm", p.x()}, {"y_mm", p.y()}, {"z_mm", p.z()}, {"e1", e.x()}, {"e2", e.y()}, {"e3", e.z()}}},
      {"covariance", covariance},
      {"stage", to_string(result.stage)},
      {"fitness", estimate.fitness},
      {"confidence", estimate.confidence},
      {"state", to_string(estimate.state)},
      {"generations", estimate.generations},
      {"evaluations", estimate.evaluations},
      {"compute_ms", result.compute_ms},
      {"seed", seed},
  };
  if (result.error) {
    const Vector3& d = result.error->position_mm;
    json["error"] = {
        {"x_mm", d.x()}, {"y_mm", d.y()}, {"z_mm", d.z()}, {"position_mm", d.norm()}, {"e", result.error->e}};
  }
  return json.dump();
}

void print_summary(std::ostream& out, const std::vector<FrameResult>& results) {
  if (results.empty()) return;
  const auto locked = static_cast<std::size_t>(std::count_if(results.begin(), results.end(), is_locked));
  out << "\nframes      " << results.size() << ", tracked " << locked
      << format(" (%.1f %%)\n", 100.0 * static_cast<double>(locked) / static_cast<double>(results.size()));
  print_errors(out, results);
  std::vector<double> ms;
  for (const FrameResult& result : results) ms.push_back(result.compute_ms);
  std::sort(ms.begin(), ms.end());
  out << format("compute     median %.2f ms, largest %.2f ms a frame\n", ms[ms.size() / 2], ms.back());
}

}  // namespace vergence::tools
