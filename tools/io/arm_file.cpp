#include "tools/io/arm_file.hpp"

#include <numbers>

#include "tools/io/input_error.hpp"
#include "tools/io/toml_reader.hpp"

namespace vergence::tools {
namespace {

constexpr double kDegree_rad = std::numbers::pi / 180;

// Sixteen numbers, row by row; identity where there are none.
Transform read_transform(const TomlReader& table, std::string_view key) {
  Transform T;
  if (!table.has(key)) return T;
  const std::vector<double> m = table.numbers(key, 16);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column)
      T.R(row, column) = m[static_cast<std::size_t>(4 * row + column)];
    T.t_mm[row] = m[static_cast<std::size_t>(4 * row + 3)];
  }
  const bool bottom = m[12] == 0 && m[13] == 0 && m[14] == 0 && m[15] == 1;
  if (!bottom || !is_rigid(T, 1e-9)) {
    table.fail(key, "is no rigid transform", "a rotation matrix to 1e-9, and 0, 0, 0, 1 as its last row");
  }
  return T;
}

}  // namespace

SerialArm read_arm(const std::filesystem::path& file) {
  const TomlReader root = TomlReader::from_file(file);
  root.allow_only({"name", "T_W_base", "T_flange_hand", "joint"});
  SerialArm arm;
  arm.T_W_base = read_transform(root, "T_W_base");
  arm.T_flange_hand = read_transform(root, "T_flange_hand");
  for (const TomlReader& joint : root.tables("joint")) {
    if (arm.joints == kMaxJoints) {
      root.fail("joint", "there are more than " + std::to_string(kMaxJoints), "at most that many [[joint]]");
    }
    joint.allow_only({"a_mm", "alpha_deg", "d_mm", "theta_offset_deg", "min_deg", "max_deg",
                      "velocity_rad_per_s", "acceleration_rad_per_s2", "jerk_rad_per_s3", "held"});
    const auto i = static_cast<std::size_t>(arm.joints);
    arm.dh[i] = {joint.number_or("a_mm", 0, {-1e5, 1e5}),
                 joint.number_or("alpha_deg", 0, {-360, 360}) * kDegree_rad,
                 joint.number_or("d_mm", 0, {-1e5, 1e5}),
                 joint.number_or("theta_offset_deg", 0, {-360, 360}) * kDegree_rad};
    JointLimits& limits = arm.limits[i];
    limits.min_rad = joint.number("min_deg", {-2800, 2800}) * kDegree_rad;
    limits.max_rad = joint.number("max_deg", {-2800, 2800}) * kDegree_rad;
    if (!(limits.min_rad < limits.max_rad)) joint.fail("max_deg", "is not above min_deg");
    limits.velocity_rad_per_s = joint.number("velocity_rad_per_s", kPositive);
    limits.acceleration_rad_per_s2 = joint.number("acceleration_rad_per_s2", kPositive);
    limits.jerk_rad_per_s3 = joint.number("jerk_rad_per_s3", kPositive);
    if (joint.boolean_or("held", false)) arm.held |= 1U << i;
    ++arm.joints;
  }
  if (const Status status = validate(arm); status != Status::kOk)
    throw InputError(file, "joint", describe(status));
  return arm;
}

}  // namespace vergence::tools
