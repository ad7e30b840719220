#include "tools/rig/controller_process.hpp"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <thread>
#include <utility>

#include "tools/rig/rig_error.hpp"

namespace vergence::rig {
namespace {

int status_of(int waited) {
  return WIFSIGNALED(waited) ? -WTERMSIG(waited) : WEXITSTATUS(waited);
}

}  // namespace

ControllerProcess::ControllerProcess(std::vector<std::string> command, std::filesystem::path log)
    : command_(std::move(command)), log_(std::move(log)) {}

ControllerProcess::~ControllerProcess() {
  (void)finish();
}

void ControllerProcess::start() {
  if (command_.empty() || process_ > 0) return;
  std::vector<char*> arguments;
  for (std::string& argument : command_) arguments.push_back(argument.data());
  arguments.push_back(nullptr);
  // Not by fork(): afterwards each page of the plant would be copied when it is written to.
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, log_.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0644);
  posix_spawn_file_actions_adddup2(&files, STDOUT_FILENO, STDERR_FILENO);
  errno = posix_spawnp(&process_, arguments[0], &files, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  if (errno != 0) {
    process_ = -1;
    fail_with_errno(command_[0]);
  }
}

void ControllerProcess::send_signal(int signal) const {
  if (process_ > 0) kill(process_, signal);
}

bool ControllerProcess::is_running() {
  if (process_ <= 0) return false;
  int waited = 0;
  if (waitpid(process_, &waited, WNOHANG) == 0) return true;
  status_ = status_of(waited);
  process_ = -1;
  return false;
}

int ControllerProcess::finish() {
  constexpr std::chrono::milliseconds kOften(20);
  constexpr int kPatience = 300;  // six seconds
  if (is_running()) {
    send_signal(SIGCONT);
    send_signal(SIGTERM);
    for (int i = 0; i < kPatience && is_running(); ++i) std::this_thread::sleep_for(kOften);
    send_signal(SIGKILL);
    while (is_running()) std::this_thread::sleep_for(kOften);
  }
  return status_;
}

}  // namespace vergence::rig
