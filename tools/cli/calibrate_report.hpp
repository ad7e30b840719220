// What `vergence calibrate` says: tables for people, one JSON object for machines.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <string>
#include <vector>

#include "tools/calibrate/hand_eye.hpp"
#include "tools/calibrate/stereo.hpp"
#include "tools/calibrate/time_offset.hpp"

namespace vergence::tools {

void print_stereo(std::ostream& out, const calibrate::StereoCalibration& result,
                  const std::vector<std::string>& skipped);
[[nodiscard]] std::string to_json(const calibrate::StereoCalibration& result,
                                  const std::vector<std::string>& skipped);

void print_hand_eye(std::ostream& out, const calibrate::HandEye& result,
                    const std::vector<std::string>& skipped);
[[nodiscard]] std::string to_json(const calibrate::HandEye& result, const std::vector<std::string>& skipped);

void print_time_offset(std::ostream& out, const calibrate::TimeOffset& result);
[[nodiscard]] std::string to_json(const calibrate::TimeOffset& result);

}  // namespace vergence::tools
