#include "tools/cli/calibrate_report.hpp"

#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <ostream>

namespace vergence::tools {
namespace {

using Json = nlohmann::ordered_json;
using calibrate::kSides;

template <class... Values>
std::string format(const char* pattern, Values... values) {
  char text[256];
  std::snprintf(text, sizeof text, pattern, values...);
  return text;
}

const CameraModel& camera_of(const StereoRig& rig, std::size_t side) {
  return side == 0 ? rig.left : rig.right;
}

std::array<double, calibrate::kIntrinsics> intrinsics(const CameraModel& camera) {
  const auto& [k1, k2, p1, p2, k3] = camera.distortion;
  return {camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px, k1, k2, p1, p2, k3};
}

constexpr std::array<const char*, calibrate::kIntrinsics> kNames{"fx", "fy", "cx", "cy", "k1",
                                                                 "k2", "p1", "p2", "k3"};

void print_warnings(std::ostream& out, const std::vector<std::string>& warnings) {
  for (const std::string& warning : warnings) out << "warning: " << warning << '\n';
}

Json matrix_json(const Transform& T) {
  Json numbers = Json::array();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) numbers.push_back(T.R(row, column));
    numbers.push_back(T.t_mm[row]);
  }
  for (const double value : {0.0, 0.0, 0.0, 1.0}) numbers.push_back(value);
  return numbers;
}

Json intrinsics_json(const CameraModel& camera) {
  Json json;
  const auto values = intrinsics(camera);
  for (std::size_t i = 0; i < values.size(); ++i) json[kNames[i]] = values[i];
  return json;
}

}  // namespace

void print_stereo(std::ostream& out, const calibrate::StereoCalibration& result,
                  const std::vector<std::string>& skipped) {
  out << "  view  left px  right px  epipolar px  tilt deg  distance mm\n";
  std::size_t used = 0;
  for (const calibrate::StereoView& view : result.views) {
    out << format("%6d %8.3f  %8.3f  %11.3f  %8.1f  %11.1f", view.number, view.rms_px[0], view.rms_px[1],
                  view.epipolar_rms_px, view.tilt_deg, view.distance_mm)
        << (view.used ? "\n" : "  left out\n");
    used += view.used ? 1 : 0;
  }
  for (const std::string& picture : skipped) out << "skipped " << picture << '\n';

  out << "\n            left    +-           right   +-\n";
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    const auto index = static_cast<Eigen::Index>(i);
    out << format(i < 4 ? "%-6s %9.3f %9.3f   %9.3f %9.3f\n" : "%-6s %9.5f %9.5f   %9.5f %9.5f\n", kNames[i],
                  intrinsics(result.rig.left)[i], result.sigma[0][index], intrinsics(result.rig.right)[i],
                  result.sigma[1][index]);
  }
  out << format("\nviews       %zu used, %zu left out\n", used, result.views.size() - used)
      << format("reprojection RMS  left %.3f px, right %.3f px\n", result.rms_px[0], result.rms_px[1])
      << format("epipolar    RMS %.3f px, largest %.3f px\n", result.epipolar.rms_px,
                result.epipolar.largest_px)
      << format("baseline    %.3f +- %.3f mm, orientations differ by %.3f deg\n", result.baseline_mm,
                result.baseline_sigma_mm, result.turn_deg)
      << format("coverage    left %.0f %%, right %.0f %% of the image's cells\n", 100 * result.coverage[0],
                100 * result.coverage[1]);
  print_warnings(out, result.warnings);
}

std::string to_json(const calibrate::StereoCalibration& result, const std::vector<std::string>& skipped) {
  Json json;
  for (std::size_t side = 0; side < 2; ++side) {
    const CameraModel& camera = camera_of(result.rig, side);
    Json sigma;
    for (std::size_t i = 0; i < kNames.size(); ++i)
      sigma[kNames[i]] = result.sigma[side][static_cast<Eigen::Index>(i)];
    json[kSides[side]] = {{"intrinsics", intrinsics_json(camera)},
                          {"sigma", sigma},
                          {"T_H_C", matrix_json(camera.T_H_C)},
                          {"rms_px", result.rms_px[side]},
                          {"coverage", result.coverage[side]}};
  }
  json["baseline_mm"] = result.baseline_mm;
  json["baseline_sigma_mm"] = result.baseline_sigma_mm;
  json["turn_deg"] = result.turn_deg;
  json["epipolar_rms_px"] = result.epipolar.rms_px;
  json["epipolar_largest_px"] = result.epipolar.largest_px;
  json["views"] = Json::array();
  for (const calibrate::StereoView& view : result.views) {
    json["views"].push_back({{"view", view.number},
                             {"used", view.used},
                             {"left_px", view.rms_px[0]},
                             {"right_px", view.rms_px[1]},
                             {"epipolar_px", view.epipolar_rms_px},
                             {"tilt_deg", view.tilt_deg},
                             {"distance_mm", view.distance_mm}});
  }
  json["skipped"] = skipped;
  json["warnings"] = result.warnings;
  return json.dump(2) + "\n";
}

}  // namespace vergence::tools
