#include "tools/draw/gnuplot.hpp"

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>

extern char** environ;

namespace vergence::tools {
namespace {

// A script in a file of its own, gone with this object.
class ScriptFile {
 public:
  explicit ScriptFile(const std::string& script) {
    std::string name = (std::filesystem::temp_directory_path() / "vergence-XXXXXX").string();
    const int file = mkstemp(name.data());
    if (file < 0) throw std::runtime_error("no temporary file " + name + ": " + std::strerror(errno));
    close(file);
    path_ = name;
    std::ofstream out(path_);
    out << script;
    if (!out.flush()) throw std::runtime_error("cannot write " + name);
  }
  ~ScriptFile() {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }
  ScriptFile(const ScriptFile&) = delete;
  ScriptFile& operator=(const ScriptFile&) = delete;

  [[nodiscard]] std::string path() const { return path_.string(); }

 private:
  std::filesystem::path path_;
};

}  // namespace

void run_gnuplot(const std::string& script) {
  const ScriptFile file(script);
  std::string name = "gnuplot";
  std::string path = file.path();
  const std::array<char*, 3> arguments{name.data(), path.data(), nullptr};
  pid_t child = 0;
  if (const int error = posix_spawnp(&child, name.c_str(), nullptr, nullptr, arguments.data(), environ);
      error != 0) {
    throw std::runtime_error(std::string("gnuplot cannot be run: ") + std::strerror(error) +
                             " (figures need it: apt install gnuplot-nox)");
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) throw std::runtime_error(std::string("waiting for gnuplot: ") + std::strerror(errno));
  }
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    throw std::runtime_error("gnuplot could not draw the figure (its message is above)");
  }
}

std::string gnuplot_quoted(const std::string& text) {
  std::string quoted = "'";
  for (const char c : text) {
    // The end of a line would end the command too.
    if (static_cast<unsigned char>(c) < ' ') {
      quoted += ' ';
    } else {
      quoted += c == '\'' ? std::string("''") : std::string(1, c);
    }
  }
  return quoted + "'";
}

}  // namespace vergence::tools
