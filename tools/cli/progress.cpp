#include "tools/cli/progress.hpp"

#include <unistd.h>

#include <cstdio>
#include <utility>

namespace vergence::tools {

Progress::Progress(std::string what, std::size_t total, bool wanted)
    : what_(std::move(what)), total_(total), shown_(wanted && total > 1 && isatty(STDERR_FILENO) == 1) {
  draw();
}

Progress::~Progress() {
  hide();
}

void Progress::step() {
  ++done_;
  draw();
}

void Progress::hide() {
  if (shown_) std::fputs("\r\033[K", stderr);
}

void Progress::draw() {
  if (!shown_) return;
  constexpr std::size_t kWidth = 30;
  const std::size_t filled = kWidth * done_ / total_;
  const std::string bar = std::string(filled, '#') + std::string(kWidth - filled, '.');
  std::fprintf(stderr, "\r\033[K%s [%s] %zu/%zu", what_.c_str(), bar.c_str(), done_, total_);
}

}  // namespace vergence::tools
