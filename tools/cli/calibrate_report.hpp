// What `vergence calibrate` says: tables for people, one JSON object for machines.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <string>
#include <vector>

#include "tools/calibrate/stereo.hpp"

namespace vergence::tools {

void print_stereo(std::ostream& out, const calibrate::StereoCalibration& result,
                  const std::vector<std::string>& skipped);
[[nodiscard]] std::string to_json(const calibrate::StereoCalibration& result,
                                  const std::vector<std::string>& skipped);

}  // namespace vergence::tools
