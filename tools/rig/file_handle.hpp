// A file descriptor that closes itself.
#pragma once

#include <unistd.h>

#include <utility>

namespace vergence::rig {

class FileHandle {
 public:
  FileHandle() = default;
  explicit FileHandle(int handle) : handle_(handle) {}
  ~FileHandle() { reset(); }
  FileHandle(FileHandle&& other) noexcept : handle_(std::exchange(other.handle_, -1)) {}
  FileHandle& operator=(FileHandle&& other) noexcept {
    if (this != &other) {
      reset();
      handle_ = std::exchange(other.handle_, -1);
    }
    return *this;
  }

  void reset() {
    if (handle_ >= 0) ::close(handle_);
    handle_ = -1;
  }
  [[nodiscard]] int get() const { return handle_; }
  [[nodiscard]] bool is_open() const { return handle_ >= 0; }

 private:
  int handle_ = -1;
};

}  // namespace vergence::rig
