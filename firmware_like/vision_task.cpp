#include "firmware_like/vision_task.hpp"

namespace vergence {
namespace {

// A frame may be so much younger than the last word of the hand.
constexpr std::int64_t kAhead_ns = 5'000'000;

}  // namespace

void VisionTask::keep(const RobotConfig& config) {
  config_ = config;
  left_out_ = 0;
}

Status VisionTask::configure(const RobotConfig& config, const MarkerModel& model) {
  keep(config);
  return tracker_.configure(config.rig, model, config.tracker);
}

Status VisionTask::configure(const RobotConfig& config, const PhotoModel& model) {
  keep(config);
  return tracker_.configure(config.rig, model, config.tracker);
}

bool VisionTask::step(const StereoFrame& frame, const HandHistory& hand, const EyeHistory& eyes,
                      Sighting& sighting) {
  sighting = {};
  sighting.sequence = frame.sequence;
  sighting.stamp_ns = frame.stamp_ns;
  sighting.valid_from_ns = frame.stamp_ns + config_.release_offset_ns;
  sighting.T_W_H = config_.T_W_H_fixed;
  bool known = true;
  if (config_.has_arm) {
    HandHistory::Values q{};
    known = hand.at(frame.stamp_ns, kAhead_ns, q);
    sighting.T_W_H = forward_kinematics(config_.arm, JointVector(q.data())).T_W_H;
  }
  FrameMotion motion;
  motion.t_s = static_cast<double>(frame.stamp_ns) * 1e-9;
  motion.T_W_H = sighting.T_W_H;
  motion.T_H_CL = config_.rig.left.T_H_C;
  motion.T_H_CR = config_.rig.right.T_H_C;
  if (config_.has_eyes) {
    EyeHistory::Values angles{};
    known = eyes.at(frame.stamp_ns, kAhead_ns, angles) && known;
    sighting.eyes = {angles[0], angles[1], angles[2]};
    motion.T_H_CL = left_eye_in_hand(config_.rig.left.T_H_C, sighting.eyes);
    motion.T_H_CR = right_eye_in_hand(config_.rig.right.T_H_C, sighting.eyes);
  }
  if (!known || tracker_.begin_frame(frame.sequence, frame.left, frame.right, motion) != Status::kOk) {
    ++left_out_;
    return false;
  }
  // Asked anew after each generation: a target that turns out to be gone is worth a search.
  for (int generation = 0; generation < tracker_.usual_generations(); ++generation) {
    tracker_.evolve(static_cast<double>(generation) / tracker_.usual_generations());
  }
  sighting.estimate = tracker_.end_frame();
  if (config_.R_W_M_given) {
    Transform T_H_M = to_transform(sighting.estimate.pose);
    T_H_M.R = sighting.T_W_H.R.transpose() * *config_.R_W_M_given;
    sighting.estimate.pose = to_pose(T_H_M);
  }
  sighting.T_H_M = to_transform(sighting.estimate.pose);
  return true;
}

}  // namespace vergence
