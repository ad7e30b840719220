// The figures of the accuracy page.
#pragma once

#include <filesystem>
#include <vector>

#include "tools/accuracy/generation_study.hpp"
#include "tools/accuracy/reliability.hpp"

namespace vergence::accuracy {

// RMS position error and RMS |e| against generations: a row of panels for each of the two, a panel for each
// data set, a line for each way. Throws std::runtime_error without gnuplot.
void write_generation_plot(const std::filesystem::path& png, const std::vector<StudyRow>& rows);

// Share of right poses over stated confidence, and how many frames there are.
void write_reliability_plot(const std::filesystem::path& png, const Reliability& r);

}  // namespace vergence::accuracy
