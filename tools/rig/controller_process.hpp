// The controller under test, as a process: started, and stopped in every way a process can be.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

namespace vergence::rig {

class ControllerProcess {
 public:
  // What it writes is appended to `log`. Nothing is started yet.
  ControllerProcess(std::vector<std::string> command, std::filesystem::path log);
  ~ControllerProcess();
  ControllerProcess(const ControllerProcess&) = delete;
  ControllerProcess& operator=(const ControllerProcess&) = delete;

  // Throws RigError where it cannot be started.
  void start();
  void send_signal(int signal) const;
  // Whether it runs; notes how it ended otherwise.
  [[nodiscard]] bool is_running();
  // SIGTERM, time to stop the arm, SIGKILL. Answers the exit status, or minus the signal that ended it.
  int finish();
  [[nodiscard]] int status() const { return status_; }

 private:
  std::vector<std::string> command_;
  std::filesystem::path log_;
  pid_t process_ = -1;
  int status_ = 0;
};

}  // namespace vergence::rig
