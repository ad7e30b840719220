// The controller tells systemd that it is ready, how it is, and that it is alive [sd_notify(3)]: datagrams to
// the socket that $NOTIFY_SOCKET names, by hand. Never waits; where nobody supervises, nothing is sent.
#pragma once

#include <sys/socket.h>
#include <sys/un.h>

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace vergence::rt {

// As systemd sets them; null where it does not.
struct ServiceEnvironment {
  const char* notify_socket = nullptr;  // a path, or '@' and an abstract name
  const char* watchdog_usec = nullptr;
  const char* watchdog_pid = nullptr;
  [[nodiscard]] static ServiceEnvironment of_process();
};

enum class ServiceError : std::uint8_t {
  kNone,         // also where nobody supervises
  kBadAddress,   // neither a path nor an abstract name, or too long
  kSocket,       // none to be had: last_errno()
  kBadWatchdog,  // WATCHDOG_USEC or WATCHDOG_PID is no number
};
[[nodiscard]] const char* describe(ServiceError error);

class ServiceManager {
 public:
  ServiceManager() = default;
  ~ServiceManager() { close(); }
  ServiceManager(const ServiceManager&) = delete;
  ServiceManager& operator=(const ServiceManager&) = delete;

  // The environment is read here and never again.
  [[nodiscard]] ServiceError open(const ServiceEnvironment& environment = ServiceEnvironment::of_process());
  void close();

  // False where a message was not taken, and counted; true, and nothing sent, where nobody supervises.
  bool ready();
  bool status(std::string_view text);  // one line of at most 200 letters
  bool stopping();
  bool ping();  // the watchdog
  // Pings where half the watchdog's time has passed since the last ping that was taken.
  bool keep_alive(std::int64_t now_ns);

  [[nodiscard]] bool is_supervised() const { return socket_ >= 0; }
  // Within which a ping must come; 0: no watchdog.
  [[nodiscard]] std::int64_t watchdog_ns() const { return watchdog_ns_; }
  [[nodiscard]] std::uint64_t not_taken() const { return not_taken_; }
  [[nodiscard]] int last_errno() const { return errno_; }

 private:
  [[nodiscard]] bool send(std::string_view message);

  int socket_ = -1;
  sockaddr_un address_{};
  socklen_t address_bytes_ = 0;
  std::int64_t watchdog_ns_ = 0;
  std::int64_t pinged_ns_ = 0;
  bool has_pinged_ = false;
  std::uint64_t not_taken_ = 0;
  int errno_ = 0;
};

}  // namespace vergence::rt
