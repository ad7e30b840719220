// Runs the vergence executable and catches what it says.
#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <string>
#include <vector>

namespace vergence::test {

struct CommandResult {
  int status = -1;     // exit status; -1 where it was killed
  std::string output;  // stdout and stderr
};

// A line of the shell.
inline CommandResult run_command(const std::string& line) {
  const std::string command = line + " 2>&1";
  CommandResult result;
  FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return result;
  std::array<char, 4096> buffer;
  for (std::size_t n = 0; (n = fread(buffer.data(), 1, buffer.size(), pipe)) > 0;) {
    result.output.append(buffer.data(), n);
  }
  const int status = pclose(pipe);
  if (WIFEXITED(status)) result.status = WEXITSTATUS(status);
  return result;
}

// Arguments and environment as a shell reads them.
inline CommandResult run_vergence(const std::string& arguments, const std::string& environment = "") {
  return run_command(environment + " " + VERGENCE_EXECUTABLE + " " + arguments);
}

// Exit status 2, and a message that holds every one of `words`.
template <class... Words>
void expect_refusal(const std::string& arguments, const Words&... words) {
  const CommandResult result = run_vergence(arguments);
  EXPECT_EQ(result.status, 2) << arguments << '\n' << result.output;
  EXPECT_NE(result.output.find("vergence: error: "), std::string::npos) << result.output;
  for (const std::string& word : std::vector<std::string>{words...}) {
    EXPECT_NE(result.output.find(word), std::string::npos) << "'" << word << "' is not in: " << result.output;
  }
}

}  // namespace vergence::test
