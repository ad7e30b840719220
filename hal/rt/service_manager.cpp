#include "hal/rt/service_manager.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <limits>

namespace vergence::rt {
namespace {

constexpr std::size_t kLongestStatus = 200;
constexpr std::string_view kStatus = "STATUS=";

// False where it is no positive whole number.
bool read_number(const char* text, std::int64_t& number) {
  const char* end = text + std::strlen(text);
  const auto [stopped, error] = std::from_chars(text, end, number);
  return error == std::errc{} && stopped == end && number > 0;
}

}  // namespace

ServiceEnvironment ServiceEnvironment::of_process() {
  return {std::getenv("NOTIFY_SOCKET"), std::getenv("WATCHDOG_USEC"), std::getenv("WATCHDOG_PID")};
}

const char* describe(ServiceError error) {
  switch (error) {
    case ServiceError::kNone: return "no error";
    case ServiceError::kBadAddress:
      return "NOTIFY_SOCKET is neither an absolute path nor '@' and a name, or too long: start the "
             "controller "
             "as a unit with Type=notify";
    case ServiceError::kSocket: return "no socket to the service manager: see errno";
    case ServiceError::kBadWatchdog:
      return "WATCHDOG_USEC or WATCHDOG_PID is no positive number: set WatchdogSec= in the unit";
  }
  return "unknown error";
}

ServiceError ServiceManager::open(const ServiceEnvironment& environment) {
  close();
  watchdog_ns_ = 0;
  has_pinged_ = false;
  not_taken_ = 0;
  errno_ = 0;
  const char* path = environment.notify_socket;
  if (path == nullptr || *path == '\0') return ServiceError::kNone;

  const std::size_t length = std::strlen(path);
  const bool abstract = *path == '@';
  if ((!abstract && *path != '/') || length < 2 || length >= sizeof address_.sun_path) {
    return ServiceError::kBadAddress;
  }
  address_ = {};
  address_.sun_family = AF_UNIX;
  std::memcpy(address_.sun_path, path, length);
  if (abstract) address_.sun_path[0] = '\0';
  // An abstract name has no zero at its end.
  address_bytes_ =
      static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + length + (abstract ? std::size_t{0} : 1));

  // Another process's watchdog is none of ours.
  if (environment.watchdog_usec != nullptr) {
    std::int64_t watchdog_us = 0;
    std::int64_t pid = getpid();
    if (!read_number(environment.watchdog_usec, watchdog_us) ||
        watchdog_us > std::numeric_limits<std::int64_t>::max() / 1000 ||
        (environment.watchdog_pid != nullptr && !read_number(environment.watchdog_pid, pid))) {
      return ServiceError::kBadWatchdog;
    }
    if (pid == getpid()) watchdog_ns_ = watchdog_us * 1000;
  }

  socket_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (socket_ < 0) {
    errno_ = errno;
    return ServiceError::kSocket;
  }
  return ServiceError::kNone;
}

void ServiceManager::close() {
  if (socket_ >= 0) ::close(socket_);
  socket_ = -1;
}

// Not connected, so that a manager that starts anew is found again.
bool ServiceManager::send(std::string_view message) {
  if (socket_ < 0) return true;
  // The socket interface of C takes every address by this cast.
  const ssize_t sent = sendto(socket_, message.data(), message.size(), MSG_DONTWAIT | MSG_NOSIGNAL,
                              reinterpret_cast<const sockaddr*>(&address_), address_bytes_);
  if (sent == static_cast<ssize_t>(message.size())) return true;
  errno_ = errno;
  ++not_taken_;
  return false;
}

bool ServiceManager::ready() {
  return send("READY=1");
}

bool ServiceManager::stopping() {
  return send("STOPPING=1");
}

bool ServiceManager::ping() {
  return send("WATCHDOG=1");
}

bool ServiceManager::status(std::string_view text) {
  std::array<char, kStatus.size() + kLongestStatus> message;
  char* end = std::copy(kStatus.begin(), kStatus.end(), message.data());
  // A line's end would begin another message.
  for (const char letter : text.substr(0, kLongestStatus)) *end++ = letter == '\n' ? ' ' : letter;
  return send({message.data(), static_cast<std::size_t>(end - message.data())});
}

bool ServiceManager::keep_alive(std::int64_t now_ns) {
  if (watchdog_ns_ == 0 || (has_pinged_ && now_ns - pinged_ns_ < watchdog_ns_ / 2)) return true;
  if (!ping()) return false;
  pinged_ns_ = now_ns;
  has_pinged_ = true;
  return true;
}

}  // namespace vergence::rt
