// Error against generations, a line for each data set and method.
#pragma once

#include <filesystem>
#include <vector>

#include "tools/run/accuracy_study.hpp"

namespace vergence::tools {

// Two panels: RMS position error in mm and RMS |e|, logarithmic. Throws as write_heat_map does.
void write_accuracy_plot(const std::filesystem::path& png, const std::vector<StudyRow>& rows);

}  // namespace vergence::tools
