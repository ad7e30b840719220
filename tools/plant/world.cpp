#include "tools/plant/world.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "hal/clock.hpp"
#include "tools/render/random.hpp"

namespace vergence::plant {
namespace {

// A pair's exposure begins at most that long before it is delivered.
std::size_t history_samples(const CameraTimingOptions& camera) {
  const std::int64_t span_ns = camera.latency_ns + camera.exposure_ns;
  return static_cast<std::size_t>(span_ns / kStep_ns) + 4;
}

render::Scene with_exposure(render::Scene scene, const CameraTimingOptions& camera) {
  scene.shutter_s = seconds(camera.exposure_ns);
  return scene;
}

JointVector joint_vector(const JointArray& q_rad) {
  return Eigen::Map<const JointVector>(q_rad.data());
}

}  // namespace

WorldOptions options_of(const render::Scene& scene) {
  WorldOptions options;
  options.camera.fps = scene.fps;
  options.camera.exposure_ns = std::llround(scene.shutter_s * 1e9);
  options.camera.seed = render::hash(scene.seed, 1);
  options.seed = scene.seed;
  options.eyes.start = render::state_at(scene, 0).moments.back().eyes;
  return options;
}

WorldOptions options_of(const render::Scene& scene, const SerialArm& arm, const JointVector& start_rad) {
  WorldOptions options = options_of(scene);
  options.arm = arm;
  options.servo = servo_of(arm);
  Eigen::Map<JointVector>(options.servo.start_rad.data()) = start_rad;
  return options;
}

World::World(render::Scene scene, WorldOptions options, const Devices& devices)
    : scene_(with_exposure(std::move(scene), options.camera)),
      options_(std::move(options)),
      devices_(devices),
      eyes_(options_.eyes),
      timing_(options_.camera),
      history_(kStep_ns, history_samples(options_.camera)) {
  // The history is to reach past the end of an exposure when its pair is due.
  if (options_.camera.latency_ns < (options_.camera.exposure_ns + 1) / 2 + kStep_ns) {
    throw std::invalid_argument("World: pictures need a step of time from exposure to delivery");
  }
  if (options_.arm) {
    if (validate(*options_.arm) != Status::kOk || options_.servo.joints != options_.arm->joints) {
      throw std::invalid_argument("World: arm not valid, or its drives are of another");
    }
    servo_.emplace(options_.servo);
  }
  arm_commands_ = devices_.arm.commands();
  arm_requests_ = devices_.arm.requests();
  history_.push({T_W_H(), eyes_.true_angles()});
  deliver_feedback();
}

void World::advance_to(std::int64_t t_ns) {
  if (t_ns < now_ns_) throw std::invalid_argument("World: time does not run backwards");
  take_commands();
  while (stepped_to_ns_ + kStep_ns <= t_ns) step();
  now_ns_ = t_ns;
  take_due(t_ns);
  if (shot_) deliver_shot();
}

void World::take_commands() {
  if (servo_) {
    // A request is an event, not a state: the drives may have left the state on their own.
    if (devices_.arm.requests() != arm_requests_) servo_->request(devices_.arm.requested());
    if (devices_.arm.commands() != arm_commands_) servo_->command(devices_.arm.commanded_rad_per_s());
    arm_requests_ = devices_.arm.requests();
    arm_commands_ = devices_.arm.commands();
  }
  eyes_.enable(devices_.eyes.is_enabled());
  eyes_.command(devices_.eyes.commanded_steps_per_s());
}

void World::step() {
  if (servo_) servo_->advance(kStep_ns);
  eyes_.advance(kStep_ns);
  stepped_to_ns_ += kStep_ns;
  history_.push({T_W_H(), eyes_.true_angles()});
  deliver_feedback();
  take_due(stepped_to_ns_);
}

void World::deliver_feedback() {
  if (servo_) devices_.arm.deliver(servo_->feedback(stepped_to_ns_));
  devices_.eyes.deliver(eyes_.feedback(stepped_to_ns_));
}

void World::take_due(std::int64_t t_ns) {
  for (PairTiming timing = timing_.pair(next_pair_); timing.delivery_ns <= t_ns;
       timing = timing_.pair(++next_pair_)) {
    if (timing.is_lost) {
      ++pairs_lost_;
      continue;
    }
    ++pairs_delivered_;
    // One that nobody could take before the next came need not be developed.
    shot_ = Shot{timing, options_.render ? state_during(timing) : render::SceneState{}};
  }
}

render::SceneState World::state_during(const PairTiming& timing) const {
  const Transform T_S_W = options_.T_W_S.inverse();
  render::SceneState state = render::state_at(scene_, seconds(timing.stamp_ns));
  for (render::SceneMoment& moment : state.moments) {
    const HeadState head = history_.at(std::llround(moment.t_s * 1e9));
    moment.T_W_H = T_S_W * head.T_W_H;
    moment.eyes = head.eyes;
    if (options_.target) moment.T_W_M = T_S_W * options_.target(moment.t_s);
  }
  return state;
}

void World::deliver_shot() {
  StereoFrame frame;
  frame.sequence = shot_->timing.sequence;
  frame.stamp_ns = shot_->timing.stamp_ns;
  if (options_.render) {
    if (devices_.camera.is_taken()) place_ = 1 - place_;
    Pair& pair = pairs_[place_];
    const std::uint64_t frame_seed = render::hash(options_.seed, frame.sequence);
    render::render_pair(scene_, shot_->state, frame_seed, pair.left, pair.right);
    frame.left = pair.left.view();
    frame.right = pair.right.view();
  }
  shot_.reset();
  devices_.camera.deliver(frame);
}

Transform World::T_W_H() const {
  if (!servo_) return options_.T_W_H;
  return forward_kinematics(*options_.arm, joint_vector(servo_->true_position_rad())).T_W_H;
}

Transform World::T_W_M(double t_s) const {
  if (options_.target) return options_.target(t_s);
  return options_.T_W_S * to_transform(scene_.target_motion.at(t_s));
}

Transform World::T_H_M() const {
  return T_W_H().inverse() * T_W_M(seconds(stepped_to_ns_));
}

std::optional<Vector3> World::gaze_point_W_mm() const {
  const EyeAngles angles = eye_angles();
  const Transform left = left_eye_in_hand(scene_.rig.left.T_H_C, angles);
  const Transform right = right_eye_in_hand(scene_.rig.right.T_H_C, angles);
  const Vector3 a = left.R.col(2);
  const Vector3 b = right.R.col(2);
  const Vector3 apart = right.t_mm - left.t_mm;
  const double ab = a.dot(b);
  const double sine2 = 1 - ab * ab;
  if (sine2 < 1e-18) return std::nullopt;
  const double along_left_mm = (apart.dot(a) - apart.dot(b) * ab) / sine2;
  const double along_right_mm = (apart.dot(a) * ab - apart.dot(b)) / sine2;
  if (along_left_mm <= 0 || along_right_mm <= 0) return std::nullopt;
  const Vector3 p_H_mm = (left.t_mm + along_left_mm * a + right.t_mm + along_right_mm * b) / 2;
  return T_W_H() * p_H_mm;
}

ArmServo& World::arm() {
  if (!servo_) throw std::logic_error("World: the hand is fixed, there is no arm");
  return *servo_;
}

}  // namespace vergence::plant
