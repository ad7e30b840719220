#include "tools/cli/calibrate_report.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <numbers>
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

void print_skipped(std::ostream& out, const std::vector<std::string>& skipped) {
  for (const std::string& picture : skipped) out << "skipped " << picture << '\n';
}

// Standard deviations along three axes together.
double sigma_mm(const Matrix6& covariance) {
  return std::sqrt(covariance.diagonal().head<3>().sum());
}
double sigma_deg(const Matrix6& covariance) {
  return std::sqrt(covariance.diagonal().tail<3>().sum()) * 180 / std::numbers::pi;
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
  print_skipped(out, skipped);

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

void print_hand_eye(std::ostream& out, const calibrate::HandEye& result,
                    const std::vector<std::string>& skipped) {
  out << "  view  left px  right px  board off mm  deg\n";
  for (const calibrate::HandEyeView& view : result.views) {
    out << format("%6d %8.3f  %8.3f  %12.3f  %.3f\n", view.number, view.rms_px[0], view.rms_px[1],
                  view.off_mm, view.off_deg);
  }
  print_skipped(out, skipped);

  out << "\nclosed form, RMS px:";
  for (const calibrate::HandEyeMethod& method : result.methods)
    out << (std::isfinite(method.rms_px) ? format("  %s %.3f", method.name.c_str(), method.rms_px)
                                         : "  " + method.name + " fails");
  out << "; the best one was refined\n\n                x mm      y mm      z mm    +- mm   +- deg\n";
  for (std::size_t side = 0; side < 2; ++side) {
    const Vector3& t = camera_of(result.rig, side).T_H_C.t_mm;
    out << format("%-10s %9.3f %9.3f %9.3f %8.3f %8.4f\n", kSides[side], t[0], t[1], t[2],
                  sigma_mm(result.covariance[side]), sigma_deg(result.covariance[side]));
  }
  out << format("\nreprojection RMS  left %.3f px, right %.3f px\n", result.rms_px[0], result.rms_px[1])
      << format("board       RMS %.3f mm, %.4f deg off, as single views have it\n", result.rms_mm,
                result.rms_deg)
      << format("hand        errs by %.3f mm and %.4f deg an axis\n", result.hand_mm, result.hand_deg)
      << format("turns       %.1f deg RMS about the second axis\n", result.turn_deg)
      << format("stereo      the pose between the cameras moved by %.3f mm, %.4f deg\n", result.moved_mm,
                result.moved_deg);
  print_warnings(out, result.warnings);
}

std::string to_json(const calibrate::HandEye& result, const std::vector<std::string>& skipped) {
  Json json;
  for (std::size_t side = 0; side < 2; ++side) {
    Json covariance = Json::array();
    for (int row = 0; row < 6; ++row) {
      for (int column = 0; column < 6; ++column) covariance.push_back(result.covariance[side](row, column));
    }
    json[kSides[side]] = {{"T_H_C", matrix_json(camera_of(result.rig, side).T_H_C)},
                          {"covariance", covariance},
                          {"sigma_mm", sigma_mm(result.covariance[side])},
                          {"sigma_deg", sigma_deg(result.covariance[side])},
                          {"rms_px", result.rms_px[side]}};
  }
  json["T_W_B"] = matrix_json(result.T_W_B);
  json["board_rms_mm"] = result.rms_mm;
  json["board_rms_deg"] = result.rms_deg;
  json["hand_mm"] = result.hand_mm;
  json["hand_deg"] = result.hand_deg;
  json["turn_deg"] = result.turn_deg;
  json["stereo_moved_mm"] = result.moved_mm;
  json["stereo_moved_deg"] = result.moved_deg;
  json["methods"] = Json::object();
  for (const calibrate::HandEyeMethod& method : result.methods)
    json["methods"][method.name] = std::isfinite(method.rms_px) ? Json(method.rms_px) : Json(nullptr);
  json["views"] = Json::array();
  for (const calibrate::HandEyeView& view : result.views) {
    json["views"].push_back({{"view", view.number},
                             {"left_px", view.rms_px[0]},
                             {"right_px", view.rms_px[1]},
                             {"off_mm", view.off_mm},
                             {"off_deg", view.off_deg}});
  }
  json["skipped"] = skipped;
  json["warnings"] = result.warnings;
  return json.dump(2) + "\n";
}

void print_time_offset(std::ostream& out, const calibrate::TimeOffset& result) {
  out << format("frames      %zu used, %zu left out\n", result.frames, result.left_out)
      << format("motion      the target passes through the hand at %.1f mm/s, %.2f deg/s RMS\n",
                result.speed_mm_per_s, result.speed_deg_per_s)
      << format("offset      %+.3f +- %.3f ms (95 %%)\n", result.offset_ms, result.half_width_ms)
      << format(
             "target      wanders in the world by %.3f mm, %.3f deg; without the offset %.3f mm, %.3f deg\n",
             result.after_mm, result.after_deg, result.before_mm, result.before_deg)
      << "\nFor the controller's configuration (add what stood there while the stamps were taken):\n"
      << format("[cameras]\nstamp_to_mid_exposure_ms = %.3f\n", result.offset_ms);
}

std::string to_json(const calibrate::TimeOffset& result) {
  const Json json{{"stamp_to_mid_exposure_ms", result.offset_ms},
                  {"half_width_ms", result.half_width_ms},
                  {"frames", result.frames},
                  {"left_out", result.left_out},
                  {"speed_mm_per_s", result.speed_mm_per_s},
                  {"speed_deg_per_s", result.speed_deg_per_s},
                  {"before_mm", result.before_mm},
                  {"before_deg", result.before_deg},
                  {"after_mm", result.after_mm},
                  {"after_deg", result.after_deg}};
  return json.dump(2) + "\n";
}

}  // namespace vergence::tools
