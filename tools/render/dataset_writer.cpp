#include "tools/render/dataset_writer.hpp"

#include <atomic>
#include <cstdio>
#include <exception>
#include <fstream>
#include <mutex>
#include <string>
#include <thread>

#include "tools/io/input_error.hpp"
#include "tools/io/writable.hpp"
#include "tools/render/random.hpp"

namespace vergence::render {
namespace {

// Shortest text of fixed digits without "-0".
std::string number(double value, int digits = 9) {
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", digits, value + 0.0);
  std::string result(text);
  if (result.find('.') != std::string::npos) {
    while (result.back() == '0') result.pop_back();
    if (result.back() == '.') result.pop_back();
  }
  if (result == "-0") result.erase(0, 1);
  return result;
}

void write_text(const std::filesystem::path& file, const std::string& text) {
  std::ofstream out(file, std::ios::binary);
  out << text;
  out.close();
  if (!out) throw tools::InputError(file, "", "cannot be written");
}

template <typename List>
std::string listed(const List& values) {
  std::string text = "[";
  for (const double value : values) text.append(text.size() > 1 ? ", " : "").append(number(value));
  return text.append("]");
}

std::string intrinsics(const CameraModel& camera) {
  return "fx = " + number(camera.fx_px) + "\nfy = " + number(camera.fy_px) +
         "\ncx = " + number(camera.cx_px) + "\ncy = " + number(camera.cy_px) + "\n";
}

std::string rig_text(const StereoRig& rig) {
  const auto side = [](const char* name, const CameraModel& camera) {
    std::string text = std::string("\n[") + name + "]\n" + intrinsics(camera) + "T_H_C = [\n";
    for (int row = 0; row < 3; ++row) {
      text += "  ";
      for (int column = 0; column < 3; ++column) text += number(camera.T_H_C.R(row, column), 15) + ", ";
      text += number(camera.T_H_C.t_mm[row]) + ",\n";
    }
    text += "  0, 0, 0, 1,\n]\n";
    if (camera.has_distortion()) text += "distortion = " + listed(camera.distortion) + "  # k1 k2 p1 p2 k3\n";
    return text;
  };
  return "[image]\nwidth = " + std::to_string(rig.left.width_px) +
         "\nheight = " + std::to_string(rig.left.height_px) + "\n" + side("left", rig.left) +
         side("right", rig.right);
}

std::string pose_fields(const Pose& pose) {
  std::string text;
  for (int i = 0; i < 3; ++i) text.append(",").append(number(pose.position_mm[i]));
  for (int i = 0; i < 3; ++i) text.append(",").append(number(pose.e[i], 12));
  return text;
}

void write_tables(const Scene& scene, const std::filesystem::path& directory, int frames) {
  std::string truth = "frame,t_s,x_mm,y_mm,z_mm,e1,e2,e3\n";
  std::string motion = "frame,x_mm,y_mm,z_mm,e1,e2,e3,tilt_rad,pan_right_rad,pan_left_rad\n";
  for (int frame = 0; frame < frames; ++frame) {
    const SceneState state = state_at(scene, frame / scene.fps);
    const SceneMoment& middle = state.moments[state.moments.size() / 2];
    if (state.target_there) {
      truth += std::to_string(frame) + "," + number(frame / scene.fps) +
               pose_fields(to_pose(middle.T_W_H.inverse() * middle.T_W_M)) + "\n";
    }
    motion += std::to_string(frame) + pose_fields(to_pose(middle.T_W_H)) + "," +
              number(middle.eyes.tilt_rad) + "," + number(middle.eyes.pan_right_rad) + "," +
              number(middle.eyes.pan_left_rad) + "\n";
  }
  write_text(directory / "truth.csv", truth);
  const EyeAngles& eyes = scene.eyes;
  const bool turned = eyes.tilt_rad != 0 || eyes.pan_right_rad != 0 || eyes.pan_left_rad != 0;
  if (scene.hand_motion || scene.eyes_on_target || turned) write_text(directory / "motion.csv", motion);
}

}  // namespace

void write_model(const Scene& scene, const std::filesystem::path& directory) {
  std::string text = "# " + scene.target.name + "\n";
  if (scene.target.kind == TargetKind::kMarker) {
    text += "kind = \"marker\"\n";
    for (const Ball& ball : scene.target.balls) {
      text += "\n[[ball]]\ncentre_mm = " + listed(ball.centre_mm) +
              "\nradius_mm = " + number(ball.radius_mm) + "\nhue_deg = " + number(ball.hue_deg) +
              "\ntolerance_deg = " + number(ball.tolerance_deg) + "\n";
    }
  } else {
    const ModelPhoto photo = take_model_photo(scene);
    tools::write_png(directory / "photo.png", photo.photo);
    tools::write_png(directory / "background.png", photo.background);
    const Rectangle& roi = scene.target.roi;
    text += "kind = \"photo\"\n\n[photo]\nimage = \"photo.png\"\nbackground = \"background.png\"\nroi = [" +
            std::to_string(roi.x) + ", " + std::to_string(roi.y) + ", " + std::to_string(roi.width) + ", " +
            std::to_string(roi.height) + "]\ndistance_mm = " + number(scene.photo.distance_mm) + "\n";
    if (scene.photo.mask) {
      tools::write_png(directory / "mask.png", photo.mask);
      text += "mask = \"mask.png\"\n";
    }
    text += "\n[camera]\n" + intrinsics(scene.photo.camera);
  }
  write_text(directory / "model.toml", text);
}

void write_dataset(const Scene& scene, const std::filesystem::path& directory, int frames, int threads,
                   const std::function<void()>& written) {
  for (const char* part : {"left", "right", "model"}) tools::make_directory(directory / part);
  write_text(directory / "rig.toml", rig_text(scene.rig));
  write_text(directory / "search.toml", "centre = " + listed(scene.search.centre) +
                                            "\nhalf_range = " + listed(scene.search.half_range) + "\n");
  write_model(scene, directory / "model");
  write_tables(scene, directory, frames);

  std::atomic<int> next = 0;
  std::mutex mutex;
  std::exception_ptr error;
  const auto work = [&] {
    tools::RgbImage left;
    tools::RgbImage right;
    for (int frame = next++; frame < frames; frame = next++) {
      try {
        const SceneState state = state_at(scene, frame / scene.fps);
        const std::uint64_t seed = hash(scene.seed, static_cast<std::uint64_t>(frame));
        render_eye(scene, state, Eye::kLeft, seed, left);
        render_eye(scene, state, Eye::kRight, seed, right);
        std::string name = std::to_string(frame);
        name.insert(0, 6 - name.size(), '0');
        name += ".png";
        tools::write_png(directory / "left" / name, left);
        tools::write_png(directory / "right" / name, right);
      } catch (...) {
        const std::scoped_lock lock(mutex);
        error = std::current_exception();
        next = frames;
        return;
      }
      const std::scoped_lock lock(mutex);
      written();
    }
  };
  {
    std::vector<std::jthread> team;
    for (int i = 1; i < threads; ++i) team.emplace_back(work);
    work();
  }
  if (error) std::rethrow_exception(error);
}

}  // namespace vergence::render
