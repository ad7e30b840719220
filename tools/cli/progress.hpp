// A progress bar on stderr, for people who wait; silent where stderr is no terminal.
#pragma once

#include <cstddef>
#include <string>

namespace vergence::tools {

class Progress {
 public:
  // For `total` steps. `wanted` false: never shown.
  Progress(std::string what, std::size_t total, bool wanted = true);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void step();
  // Wipes the bar, so that a line may be printed; the next step draws it again.
  void hide();

 private:
  void draw();

  std::string what_;
  std::size_t total_;
  std::size_t done_ = 0;
  bool shown_;
};

}  // namespace vergence::tools
