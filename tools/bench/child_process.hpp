// Another program, run beside this one. Started without copying this process's memory, so that pages which
// are locked and touched stay so.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

namespace vergence::tools {

class ChildProcess {
 public:
  // By its name in PATH; what it prints is dropped. Ask has_started().
  explicit ChildProcess(const std::vector<std::string>& command);
  ~ChildProcess();  // ends it
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  [[nodiscard]] bool has_started() const { return pid_ > 0 || reaped_; }
  // Its exit status once it has ended; -1 where it did not start or was killed.
  int wait();
  void terminate();  // and waits

 private:
  pid_t pid_ = -1;
  bool reaped_ = false;
};

[[nodiscard]] bool is_in_path(const std::string& program);

}  // namespace vergence::tools
