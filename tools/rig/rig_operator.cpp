#include "tools/rig/rig_operator.hpp"

#include <sys/socket.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

#include "hal/clock.hpp"
#include "tools/rig/file_handle.hpp"

namespace vergence::rig {
namespace {

constexpr std::int64_t kRound_ns = 100'000'000;

// The controller's line; empty where none came.
std::string ask(const std::string& path, const std::string& word) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof address.sun_path) return {};
  std::copy(path.begin(), path.end(), address.sun_path);
  const FileHandle handle(socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0));
  const timeval patience{0, 200'000};
  std::array<char, 256> answer{};
  if (!handle.is_open() ||
      setsockopt(handle.get(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience) != 0 ||
      connect(handle.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
      send(handle.get(), word.data(), word.size(), MSG_NOSIGNAL) <= 0) {
    return {};
  }
  const ssize_t got = recv(handle.get(), answer.data(), answer.size(), 0);
  if (got <= 0) return {};
  std::string text(answer.data(), static_cast<std::size_t>(got));
  text.erase(text.find_last_not_of('\n') + 1);
  return text;
}

void sleep_until(std::int64_t t_ns) {
  const timespec until{t_ns / kNsPerSecond, t_ns % kNsPerSecond};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
  }
}

}  // namespace

RigOperator::RigOperator(std::string socket, const RigScenario& scenario, std::int64_t start_ns)
    : socket_(std::move(socket)), scenario_(scenario), start_ns_(start_ns) {
  thread_ = std::jthread([this](const std::stop_token& stop) { work(stop); });
}

std::string RigOperator::say(double t_s, const std::string& word) {
  std::string answer = ask(socket_, word);
  std::array<char, 320> line{};
  std::snprintf(line.data(), line.size(), "%8.3f  %s: %s", t_s, word.c_str(),
                answer.empty() ? "(no answer)" : answer.c_str());
  // Of a status that is asked for again and again, only what is new.
  if (word != "status" || answer != last_) conversation_.emplace_back(line.data());
  if (word == "status") last_ = answer;
  return answer;
}

void RigOperator::be_patient(double t_s) {
  const std::string status = say(t_s, "status");
  const auto is = [&](const char* mode) { return status.starts_with(std::string("ok ") + mode); };
  if (is("servo")) servoed_ = true;
  if (!servoed_ && is("idle")) (void)say(t_s, "arm");
  if (!servoed_ && (is("search") || is("track"))) (void)say(t_s, "servo");
}

void RigOperator::work(const std::stop_token& stop) {
  std::size_t next = 0;
  for (std::int64_t round = 1; !stop.stop_requested(); ++round) {
    const std::int64_t since_ns = round * kRound_ns;
    const double t_s = seconds(since_ns);
    if (t_s > scenario_.duration_s) return;
    sleep_until(start_ns_ + since_ns);
    for (; next < scenario_.operators.size() && scenario_.operators[next].at_s <= t_s; ++next) {
      (void)say(t_s, scenario_.operators[next].say);
    }
    if (scenario_.patient_operator) be_patient(t_s);
  }
}

const std::vector<std::string>& RigOperator::finish() {
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
  return conversation_;
}

}  // namespace vergence::rig
