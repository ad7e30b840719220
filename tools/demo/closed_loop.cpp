#include "tools/demo/closed_loop.hpp"

#include <cmath>
#include <stdexcept>
#include <thread>

#include "hal/clock.hpp"
#include "tools/draw/overlay.hpp"
#include "tools/io/image_file.hpp"
#include "tools/io/writable.hpp"
#include "tools/render/dataset_writer.hpp"

namespace vergence::demo {
namespace {

constexpr std::int64_t kTick_ns = plant::kStep_ns;
constexpr std::int64_t kRow_ns = 10'000'000;
constexpr std::size_t kHandWas = 512;
constexpr std::int64_t kArmAt_ns = 100'000'000;

bool is_due(std::int64_t t_ns, TaskId id) {
  return t_ns % task(id).period_ns == 0;
}

void must(Status status) {
  if (status != Status::kOk)
    throw std::runtime_error(std::string("the controller refuses: ") + describe(status));
}

tools::RgbImage copy_of(const ImageView& view) {
  tools::RgbImage image(view.width_px, view.height_px);
  const std::size_t row = static_cast<std::size_t>(view.width_px) * 3;
  for (int y = 0; y < view.height_px; ++y) {
    const std::uint8_t* from = view.data + static_cast<std::size_t>(y) * view.stride_bytes;
    std::copy(from, from + row, image.at(0, y));
  }
  return image;
}

}  // namespace

// The simulated camera, which also remembers what it gave.
struct ClosedLoop::Camera {
  sim::SimStereoCamera device;
  StereoFrame last;
  bool taken = false;

  [[nodiscard]] bool take(StereoFrame& frame) {
    taken = device.take(frame);
    if (taken) last = frame;
    return taken;
  }
  [[nodiscard]] CameraState state() const { return device.state(); }
};

Transform lateral_start() {
  Transform T;
  T.R << 0, 0, -1,  //
      1, 0, 0,      //
      0, -1, 0;
  T.t_mm = {-690, 0, 485};
  return T;
}

ClosedLoop::ClosedLoop(const LoopSetup& setup, const RunOptions& options)
    : setup_(setup),
      marker_(std::make_unique<MarkerModel>()),
      photo_(std::make_unique<PhotoModel>()),
      pipeline_(std::make_unique<Pipeline>()),
      camera_(std::make_unique<Camera>()),
      wall_clock_(options.wall_clock),
      hand_was_(kHandWas) {
  render::SceneOverrides overrides;
  overrides.seed = options.seed;
  overrides.patch = setup.patch;
  render::Scene scene = render::load_scene_text(setup.name, setup.scene, overrides);

  const bool has_eyes = scene.eyes_on_target;
  robot_.rig = scene.rig;
  robot_.has_eyes = has_eyes;
  robot_.has_arm = setup.has_arm;
  robot_.T_W_H_fixed = setup.T_W_S;
  robot_.tracker = default_settings(Method::kVergence, scene.target.kind);
  robot_.tracker.seed = options.seed;
  robot_.tracker.box = scene.search;

  plant::WorldOptions world = plant::options_of(scene);
  if (setup.has_arm) {
    const Pa10Inverse inverse = inverse_pa10(robot_.arm, setup.T_W_S, JointVector::Zero());
    const auto start = nearest_solution(robot_.arm, inverse, JointVector::Zero());
    if (!start) throw std::runtime_error("the arm cannot reach its start");
    world = plant::options_of(scene, robot_.arm, *start);
  }
  world.T_W_H = setup.T_W_S;
  world.T_W_S = setup.T_W_S;
  world.render = !setup.pose_given;
  world.seed = options.seed;
  for (std::size_t i = 0; i < kEyeMotors; ++i) {
    robot_.eye_control.steps_per_rad[i] = world.eyes.motor[i].steps_per_rad;
  }
  if (setup.adjust_robot) setup.adjust_robot(robot_);
  if (setup.adjust_world) setup.adjust_world(world);

  if (setup.pose_given) {
    must(pipeline_->configure_given(robot_));
  } else {
    build_models(options, scene);
  }
  world_ =
      std::make_unique<plant::World>(std::move(scene), world, plant::Devices{camera_->device, arm_, eyes_});
}

ClosedLoop::~ClosedLoop() = default;

void ClosedLoop::build_models(const RunOptions& options, const render::Scene& scene) {
  // Through the files a user would have, so that the controller knows no more than one would.
  const std::filesystem::path directory = options.out / "model";
  tools::make_directory(directory);
  render::write_model(scene, directory);
  tools::Dataset dataset;
  dataset.directory = options.out;
  dataset.rig = scene.rig;
  dataset.box = scene.search;
  dataset.target = tools::read_target(directory);
  target_ = dataset.target;
  if (target_.kind == TargetKind::kMarker) {
    tools::build_model(dataset, MarkerOptions{}, *marker_);
    must(pipeline_->configure(robot_, *marker_));
  } else {
    tools::build_model(dataset, PhotoOptions{}, robot_.tracker.hue_limits, *photo_);
    must(pipeline_->configure(robot_, *photo_));
  }
}

double ClosedLoop::now_s() const {
  return seconds(t_ns_);
}

Transform ClosedLoop::true_T_H_M(std::int64_t stamp_ns) const {
  // Linear within a millisecond: the hand moves by less than a thousandth of that off the line.
  const std::int64_t before = stamp_ns / kTick_ns;
  const auto at = [&](std::int64_t tick) { return hand_was_[static_cast<std::size_t>(tick) % kHandWas]; };
  const Transform a = at(before);
  const double share = static_cast<double>(stamp_ns - before * kTick_ns) / static_cast<double>(kTick_ns);
  Transform T_W_H = a;
  if (share > 0) {
    const Transform b = at(before + 1);
    const Pose step = to_pose(a.inverse() * b);
    T_W_H = a * to_transform({share * step.position_mm, share * step.e});
  }
  return T_W_H.inverse() * world_->T_W_M(seconds(stamp_ns));
}

void ClosedLoop::operate() {
  if (t_ns_ < kArmAt_ns || t_ns_ % kArmAt_ns != 0) return;
  // As an operator would, patiently: switch on what is ready, and ask the hand to follow.
  if (pipeline_->supervisor().mode() == Mode::kIdle && t_ns_ < 10 * kArmAt_ns) {
    pipeline_->command(OperatorCommand::kArm);
  } else if (setup_.servo && is_armed(pipeline_->supervisor().mode()) && t_ns_ < 10 * kArmAt_ns) {
    pipeline_->command(OperatorCommand::kServo);
  }
}

void ClosedLoop::give_pose() {
  StereoFrame frame;
  if (!camera_->take(frame)) return;
  Sighting sighting;
  sighting.sequence = frame.sequence;
  sighting.stamp_ns = frame.stamp_ns;
  sighting.valid_from_ns = frame.stamp_ns + robot_.release_offset_ns;
  const Transform T_W_M = world_->T_W_M(seconds(frame.stamp_ns));
  sighting.T_H_M = true_T_H_M(frame.stamp_ns);
  sighting.T_W_H = T_W_M * sighting.T_H_M.inverse();
  sighting.estimate.pose = to_pose(sighting.T_H_M);
  sighting.estimate.confidence = 1;
  sighting.estimate.state = TrackState::kTracking;
  pipeline_->put_sighting(t_ns_, sighting);
  fresh_ = SeenFrame{sighting, sighting.T_H_M};
}

void ClosedLoop::look() {
  const std::uint64_t left_out = pipeline_->vision().frames_left_out();
  pipeline_->step_vision(t_ns_, *camera_);
  if (camera_->taken && pipeline_->vision().frames_left_out() == left_out) {
    const Sighting& sighting = pipeline_->sighting();
    fresh_ = SeenFrame{sighting, true_T_H_M(sighting.stamp_ns)};
    last_seen_ = fresh_;
  }
}

void ClosedLoop::keep_pace() {
  const auto now = std::chrono::steady_clock::now();
  if (!began_) began_ = now - std::chrono::nanoseconds(t_ns_);
  std::this_thread::sleep_until(*began_ + std::chrono::nanoseconds(t_ns_));
}

void ClosedLoop::tick() {
  if (wall_clock_) keep_pace();
  world_->advance_to(t_ns_);
  hand_was_[static_cast<std::size_t>(t_ns_ / kTick_ns) % kHandWas] = world_->T_W_H();
  operate();
  if (is_due(t_ns_, TaskId::kArm)) pipeline_->step_arm(t_ns_, arm_);
  if (robot_.has_eyes && is_due(t_ns_, TaskId::kEyes)) pipeline_->step_eyes(t_ns_, eyes_);
  if (setup_.pose_given) {
    give_pose();
  } else if (is_due(t_ns_, TaskId::kVision)) {
    look();
  }
  if (on_tick) on_tick(seconds(t_ns_));
  if (t_ns_ % kRow_ns == 0) {
    log_.add(*world_, *pipeline_, setup_.T_W_S, robot_.relation, fresh_);
    fresh_.reset();
  }
  t_ns_ += kTick_ns;
}

void ClosedLoop::run_until(double t_s) {
  const std::int64_t end_ns = std::llround(t_s * static_cast<double>(kNsPerSecond));
  while (t_ns_ < end_ns) tick();
}

void ClosedLoop::run(const std::function<void(double)>& progress) {
  constexpr double kSlice_s = 0.2;
  while (now_s() < setup_.duration_s) {
    run_until(std::min(now_s() + kSlice_s, setup_.duration_s));
    if (progress) progress(now_s() / setup_.duration_s);
  }
}

tools::Picture ClosedLoop::draw_last_frame(const std::filesystem::path& png, const std::string& caption) {
  if (!last_seen_ || camera_->last.left.data == nullptr) throw std::logic_error("no frame was looked at");
  const Sighting& sighting = last_seen_->sighting;
  const bool is_photo = target_.kind == TargetKind::kPhoto;
  tools::Overlay overlay{target_,
                         is_photo ? &pipeline_->vision().tracker().photo_model() : nullptr,
                         {robot_.rig.left, robot_.rig.right},
                         sighting.estimate.pose,
                         to_pose(last_seen_->true_T_H_M),
                         tools::overlay_text(sighting.sequence, sighting.estimate)};
  if (robot_.has_eyes) {
    overlay.cameras[0].T_H_C = left_eye_in_hand(robot_.rig.left.T_H_C, sighting.eyes);
    overlay.cameras[1].T_H_C = right_eye_in_hand(robot_.rig.right.T_H_C, sighting.eyes);
  }
  tools::write_png(png,
                   tools::draw_overlay(overlay, copy_of(camera_->last.left), copy_of(camera_->last.right)));
  return {png, caption};
}

}  // namespace vergence::demo
