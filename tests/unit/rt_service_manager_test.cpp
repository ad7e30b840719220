// What systemd gets to hear, at a real socket.
#include "hal/rt/service_manager.hpp"

#include <gtest/gtest.h>
#include <poll.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>

namespace vergence::rt {
namespace {

// The manager's end. A name that begins with '@' is abstract.
class Manager {
 public:
  explicit Manager(const std::string& name) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::memcpy(address.sun_path, name.data(), name.size());
    const bool abstract = name[0] == '@';
    if (abstract) address.sun_path[0] = '\0';
    const std::size_t bytes = offsetof(sockaddr_un, sun_path) + name.size() + (abstract ? 0 : 1);
    socket_ = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    bound_ = bind(socket_, reinterpret_cast<const sockaddr*>(&address), static_cast<socklen_t>(bytes)) == 0;
  }
  ~Manager() { close(socket_); }
  Manager(const Manager&) = delete;
  Manager& operator=(const Manager&) = delete;

  [[nodiscard]] bool is_bound() const { return bound_; }
  [[nodiscard]] std::string hear() const {
    std::array<char, 512> message{};
    const ssize_t size = recv(socket_, message.data(), message.size(), MSG_DONTWAIT);
    return size < 0 ? "nothing" : std::string(message.data(), static_cast<std::size_t>(size));
  }

 private:
  int socket_ = -1;
  bool bound_ = false;
};

class ServiceManagerTest : public ::testing::Test {
 protected:
  void SetUp() override { std::filesystem::create_directories(folder_); }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  [[nodiscard]] ServiceEnvironment environment(const char* watchdog_usec = nullptr) const {
    return {path_.c_str(), watchdog_usec, nullptr};
  }

  std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("vergence-notify-" + std::to_string(getpid()));
  std::string path_ = folder_ / "notify";
};

TEST_F(ServiceManagerTest, TellsEachState) {
  const Manager manager(path_);
  ASSERT_TRUE(manager.is_bound());
  ServiceManager service;
  ASSERT_EQ(service.open(environment()), ServiceError::kNone);
  EXPECT_TRUE(service.is_supervised());
  EXPECT_TRUE(service.ready());
  EXPECT_EQ(manager.hear(), "READY=1");
  EXPECT_TRUE(service.status("tracking"));
  EXPECT_EQ(manager.hear(), "STATUS=tracking");
  EXPECT_TRUE(service.ping());
  EXPECT_EQ(manager.hear(), "WATCHDOG=1");
  EXPECT_TRUE(service.stopping());
  EXPECT_EQ(manager.hear(), "STOPPING=1");
  EXPECT_EQ(manager.hear(), "nothing");
  EXPECT_EQ(service.not_taken(), 0U);
}

TEST_F(ServiceManagerTest, ReachesAnAbstractSocket) {
  const std::string name = "@vergence-test-" + std::to_string(getpid());
  const Manager manager(name);
  ASSERT_TRUE(manager.is_bound());
  ServiceManager service;
  ASSERT_EQ(service.open({name.c_str(), nullptr, nullptr}), ServiceError::kNone);
  EXPECT_TRUE(service.ready());
  EXPECT_EQ(manager.hear(), "READY=1");
}

TEST_F(ServiceManagerTest, AStatusIsOneLineOfBoundedLength) {
  const Manager manager(path_);
  ServiceManager service;
  ASSERT_EQ(service.open(environment()), ServiceError::kNone);
  EXPECT_TRUE(service.status("fault\nREADY=1"));
  EXPECT_EQ(manager.hear(), "STATUS=fault READY=1");
  EXPECT_TRUE(service.status(std::string(1'000, 'x')));
  EXPECT_EQ(manager.hear(), "STATUS=" + std::string(200, 'x'));
  EXPECT_TRUE(service.status(""));
  EXPECT_EQ(manager.hear(), "STATUS=");
}

TEST_F(ServiceManagerTest, SaysNothingWhereNobodySupervises) {
  ServiceManager service;
  for (const char* none : {static_cast<const char*>(nullptr), ""}) {
    ASSERT_EQ(service.open({none, "1000", nullptr}), ServiceError::kNone);
    EXPECT_FALSE(service.is_supervised());
    EXPECT_EQ(service.watchdog_ns(), 0);
    EXPECT_TRUE(service.ready());
    EXPECT_TRUE(service.keep_alive(0));
    EXPECT_EQ(service.not_taken(), 0U);
  }
}

TEST_F(ServiceManagerTest, NeverWaitsForAManagerThatDoesNotRead) {
  const Manager manager(path_);
  ServiceManager service;
  ASSERT_EQ(service.open(environment()), ServiceError::kNone);
  constexpr int kMore = 1'000'000;
  int taken = 0;
  while (taken < kMore && service.ping()) ++taken;
  ASSERT_LT(taken, kMore);
  EXPECT_EQ(service.last_errno(), EAGAIN);
  EXPECT_EQ(service.not_taken(), 1U);
  EXPECT_EQ(manager.hear(), "WATCHDOG=1");
  EXPECT_TRUE(service.ping());
}

TEST_F(ServiceManagerTest, FindsAManagerThatStartsAnew) {
  ServiceManager service;
  ASSERT_EQ(service.open(environment()), ServiceError::kNone);
  EXPECT_FALSE(service.ready());
  EXPECT_EQ(service.last_errno(), ENOENT);
  for (int round = 0; round < 2; ++round) {
    const Manager manager(path_);
    ASSERT_TRUE(manager.is_bound());
    EXPECT_TRUE(service.ready());
    EXPECT_EQ(manager.hear(), "READY=1");
    std::filesystem::remove(path_);
  }
  EXPECT_FALSE(service.ready());
  EXPECT_EQ(service.not_taken(), 2U);
}

TEST_F(ServiceManagerTest, PingsTwiceWithinTheWatchdogsTime) {
  const Manager manager(path_);
  ServiceManager service;
  ASSERT_EQ(service.open(environment("30000")), ServiceError::kNone);
  EXPECT_EQ(service.watchdog_ns(), 30'000'000);
  const auto pings_at = [&](std::int64_t now_ms) {
    EXPECT_TRUE(service.keep_alive(now_ms * 1'000'000));
    return manager.hear() == "WATCHDOG=1";
  };
  EXPECT_TRUE(pings_at(0));
  EXPECT_FALSE(pings_at(14));
  EXPECT_TRUE(pings_at(15));
  EXPECT_FALSE(pings_at(16));
  EXPECT_TRUE(pings_at(100));
  // What was not taken is tried again at once.
  std::filesystem::remove(path_);
  EXPECT_FALSE(service.keep_alive(120'000'000));
  const Manager again(path_);
  EXPECT_TRUE(service.keep_alive(121'000'000));
  EXPECT_EQ(again.hear(), "WATCHDOG=1");
}

TEST_F(ServiceManagerTest, AWatchdogOfAnotherProcessIsNotOurs) {
  ServiceManager service;
  const std::string own = std::to_string(getpid());
  ASSERT_EQ(service.open({path_.c_str(), "30000", own.c_str()}), ServiceError::kNone);
  EXPECT_EQ(service.watchdog_ns(), 30'000'000);
  ASSERT_EQ(service.open({path_.c_str(), "30000", "1"}), ServiceError::kNone);
  EXPECT_EQ(service.watchdog_ns(), 0);
}

TEST_F(ServiceManagerTest, RefusesAnEnvironmentThatMakesNoSense) {
  ServiceManager service;
  for (const std::string& address : {std::string("notify"), std::string("/"), std::string("@"),
                                     std::string("vsock:2:1234"), "/" + std::string(200, 'x')}) {
    EXPECT_EQ(service.open({address.c_str(), nullptr, nullptr}), ServiceError::kBadAddress) << address;
    EXPECT_FALSE(service.is_supervised());
  }
  for (const char* number : {"", "0", "-5", "3s", "99999999999999999999", "9223372036854775807"}) {
    EXPECT_EQ(service.open(environment(number)), ServiceError::kBadWatchdog) << number;
  }
  EXPECT_EQ(service.open({path_.c_str(), "1000", "x"}), ServiceError::kBadWatchdog);
  EXPECT_FALSE(service.is_supervised());
}

TEST_F(ServiceManagerTest, ReadsTheProcesssEnvironment) {
  setenv("NOTIFY_SOCKET", path_.c_str(), 1);
  setenv("WATCHDOG_USEC", "2000", 1);
  unsetenv("WATCHDOG_PID");
  const ServiceEnvironment environment = ServiceEnvironment::of_process();
  EXPECT_STREQ(environment.notify_socket, path_.c_str());
  EXPECT_STREQ(environment.watchdog_usec, "2000");
  EXPECT_EQ(environment.watchdog_pid, nullptr);
  unsetenv("NOTIFY_SOCKET");
  unsetenv("WATCHDOG_USEC");
}

}  // namespace
}  // namespace vergence::rt
