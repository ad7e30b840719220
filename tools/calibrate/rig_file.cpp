#include "tools/calibrate/rig_file.hpp"

#include <cstdio>
#include <fstream>

#include "tools/io/input_error.hpp"

namespace vergence::calibrate {
namespace {

// With a decimal point, as TOML's floats are written, and without "-0".
std::string number(double value, int digits) {
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", digits, value);
  const std::string result = text;
  return result.find_first_not_of("-0.") == std::string::npos && result[0] == '-' ? result.substr(1) : result;
}

std::string camera_text(const char* side, const CameraModel& camera) {
  std::string text = "\n[" + std::string(side) + "]\nfx = " + number(camera.fx_px, 6) +
                     "  # px\nfy = " + number(camera.fy_px, 6) + "\ncx = " + number(camera.cx_px, 6) +
                     "\ncy = " + number(camera.cy_px, 6) + "\ndistortion = [";
  for (std::size_t i = 0; i < camera.distortion.size(); ++i)
    text += (i > 0 ? ", " : "") + number(camera.distortion[i], 9);
  text += "]  # k1 k2 p1 p2 k3\nT_H_C = [\n";
  for (int row = 0; row < 3; ++row) {
    text += "  ";
    for (int column = 0; column < 3; ++column) text += number(camera.T_H_C.R(row, column), 12) + ", ";
    text += number(camera.T_H_C.t_mm[row], 6) + ",\n";
  }
  return text + "  0.0, 0.0, 0.0, 1.0,\n]\n";
}

}  // namespace

void write_rig(const std::filesystem::path& file, const StereoRig& rig,
               const std::vector<std::string>& notes) {
  std::string text;
  for (const std::string& note : notes) text += "# " + note + "\n";
  text += "[image]\nwidth = " + std::to_string(rig.left.width_px) +
          "\nheight = " + std::to_string(rig.left.height_px) + "\n" + camera_text("left", rig.left) +
          camera_text("right", rig.right);
  const std::filesystem::path beside = file.string() + ".new";
  std::ofstream out(beside, std::ios::binary);
  out << text;
  out.close();
  std::error_code error;
  if (out) std::filesystem::rename(beside, file, error);
  if (!out || error)
    throw tools::InputError(file, "", "cannot be written", "is there such a folder, and room?");
}

}  // namespace vergence::calibrate
