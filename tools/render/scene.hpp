// A scene: everything a TOML file says about a world in front of two cameras, its state at a time, and the
// pictures the cameras take of that state. The closed-loop plant fills the state itself.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "algo/camera_model.hpp"
#include "algo/eye_mount.hpp"
#include "algo/rm_ga.hpp"
#include "algo/target_model.hpp"
#include "algo/tracker.hpp"
#include "tools/io/image_file.hpp"
#include "tools/render/backdrop.hpp"
#include "tools/render/light.hpp"
#include "tools/render/mesh.hpp"
#include "tools/render/motion.hpp"
#include "tools/render/rasteriser.hpp"
#include "tools/render/sensor.hpp"

namespace vergence::render {

enum class Eye {
  kLeft,
  kRight,
};

// A stick or bar across the view.
struct Occluder {
  Mesh mesh;  // about its own middle
  Motion motion;
};

// How the model photo is taken.
struct PhotoOptionsOfScene {
  double distance_mm = 400;
  Light light;
  bool mask = false;  // write mask.png and name it in model.toml
  CameraModel camera;
};

// What the target looks like and what its model is made of.
struct SceneTarget {
  TargetKind kind = TargetKind::kPhoto;
  std::string name;         // for people
  std::vector<Ball> balls;  // marker
  Mesh mesh;                // in the model frame
  Rectangle roi;            // photo-model: the target in the photo
  // Spans [from, to) in which it is not there at all: no picture of it, no truth.
  std::vector<std::array<double, 2>> hidden_s;
};

struct Scene {
  std::filesystem::path file;
  StereoRig rig;
  bool eyes_on_target = false;  // the gaze follows the target; otherwise `eyes` is fixed
  EyeAngles eyes;
  SceneTarget target;
  Motion target_motion;               // T_W_M
  std::optional<Motion> hand_motion;  // T_W_H; identity without
  std::vector<LightStep> lights;      // at least one, by rising time
  BackdropOptions backdrop_options;
  std::shared_ptr<const Backdrop> backdrop;
  BackdropOptions photo_backdrop_options;
  Water water;
  std::vector<Occluder> occluders;
  SensorOptions sensor;
  Sampling sampling = Sampling::k4;
  double shutter_s = 0;     // motion blur: exposure time
  int shutter_samples = 1;  // instants averaged
  PhotoOptionsOfScene photo;
  SearchBox search;
  double fps = 30;
  int frames = 1;
  std::uint64_t seed = 1;
  // Per eye, for each pixel the direction (x/z, y/z) it sees, lens distortion undone.
  std::vector<Vector2> left_rays;
  std::vector<Vector2> right_rays;
};

// Overrides from the command line.
struct SceneOverrides {
  std::optional<std::string> target;  // a creature
  std::optional<std::uint64_t> seed;
  double scale = 1;   // of the images
  std::string patch;  // TOML that stands in place of what the scene says, key by key
};

// One instant of the world.
struct SceneMoment {
  double t_s = 0;
  Transform T_W_H;
  Transform T_W_M;
  EyeAngles eyes;
  std::vector<Transform> T_W_occluder;
};

struct SceneState {
  Light light;
  bool target_there = true;
  std::vector<SceneMoment> moments;  // averaged over the exposure; the last is the frame's
};

// Throws InputError naming file, line and key.
[[nodiscard]] Scene load_scene(const std::filesystem::path& file, const SceneOverrides& overrides = {});
// The same of a text; `name` stands for the file in complaints.
[[nodiscard]] Scene load_scene_text(const std::filesystem::path& name, const std::string& text,
                                    const SceneOverrides& overrides = {});

[[nodiscard]] SceneState state_at(const Scene& scene, double t_s);

// Angles that turn both eyes to a point of the hand frame [3.32-3.34], taken in the tilted plane.
[[nodiscard]] EyeAngles gaze_at(const StereoRig& rig, const Vector3& p_H_mm);

// One camera's picture. `frame_seed` decides the noise and nothing else.
void render_eye(const Scene& scene, const SceneState& state, Eye eye, std::uint64_t frame_seed,
                tools::RgbImage& out);

// Both pictures, on two threads.
void render_pair(const Scene& scene, const SceneState& state, std::uint64_t frame_seed, tools::RgbImage& left,
                 tools::RgbImage& right);

// Directions (x/z, y/z) of all pixels of a camera.
[[nodiscard]] std::vector<Vector2> pixel_rays(const CameraModel& camera);

// The model photo: the target straight ahead, and the bare background.
struct ModelPhoto {
  tools::RgbImage photo;
  tools::RgbImage background;
  tools::GreyImage mask;  // 255 where at least half the pixel is target
};
[[nodiscard]] ModelPhoto take_model_photo(const Scene& scene);

// Moves the mesh, given straight ahead of the photo camera in any frame, to the model frame: the origin on
// the ray through the middle of the rectangle the target fills in the photo, at the mean depth of its visible
// surface.
void settle_model_frame(SceneTarget& target, const PhotoOptionsOfScene& photo);

}  // namespace vergence::render
