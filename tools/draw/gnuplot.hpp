// Figures through gnuplot as a child process.
#pragma once

#include <string>

namespace vergence::tools {

// Runs a script. Throws std::runtime_error where gnuplot is not installed or does not like the script.
void run_gnuplot(const std::string& script);

// A text as a gnuplot string literal.
[[nodiscard]] std::string gnuplot_quoted(const std::string& text);

}  // namespace vergence::tools
