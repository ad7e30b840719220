#include "firmware_like/daemon/command_socket.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <utility>

namespace vergence {
namespace {

constexpr std::size_t kMaxGroups = 64;

constexpr std::array<std::pair<std::string_view, OperatorCommand>, 6> kWords = {{
    {"arm", OperatorCommand::kArm},
    {"disarm", OperatorCommand::kDisarm},
    {"servo", OperatorCommand::kServo},
    {"hold", OperatorCommand::kHold},
    {"stop", OperatorCommand::kStop},
    {"reset", OperatorCommand::kReset},
}};

sockaddr_un address_of(const char* path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strncpy(address.sun_path, path, sizeof address.sun_path - 1);
  return address;
}

bool somebody_answers(const sockaddr_un& address) {
  const int probe = ::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (probe < 0) return false;
  const bool answers = ::connect(probe, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  (void)::close(probe);
  return answers;
}

}  // namespace

ParsedCommand parse_command(std::string_view message) {
  if (!message.empty() && message.back() == '\n') message.remove_suffix(1);
  if (message == "status") return {CommandVerb::kStatus, OperatorCommand::kStop};
  for (const auto& [word, command] : kWords) {
    if (message == word) return {CommandVerb::kOperate, command};
  }
  return {};
}

const char* describe(SocketStatus status) {
  switch (status) {
    case SocketStatus::kOk: return "no error";
    case SocketStatus::kBadPath: return "the path of a socket has 1 to 107 bytes";
    case SocketStatus::kInUse: return "another controller answers there: stop it first";
    case SocketStatus::kCannotBind:
      return "it cannot be made: is there such a folder, and may we write to it?";
    case SocketStatus::kCannotListen: return "it cannot be listened to";
  }
  return "unknown error";
}

bool may_command(uid_t peer_user, std::span<const gid_t> peer_groups, uid_t own_user, gid_t socket_group) {
  if (peer_user == 0 || peer_user == own_user) return true;
  return std::find(peer_groups.begin(), peer_groups.end(), socket_group) != peer_groups.end();
}

SocketStatus CommandSocket::open(const char* path) {
  close();
  const std::size_t length = std::strlen(path);
  if (length == 0 || length >= path_.size()) return SocketStatus::kBadPath;
  const sockaddr_un address = address_of(path);
  if (somebody_answers(address)) return SocketStatus::kInUse;
  struct stat about {};
  // What a killed controller left; but nothing that is no socket.
  if (::lstat(path, &about) == 0 && S_ISSOCK(about.st_mode)) (void)::unlink(path);
  listening_ = ::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  // Not for a moment is it open to more than its owner.
  const mode_t before = ::umask(0177);
  const bool bound =
      listening_ >= 0 && ::bind(listening_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  errno_ = errno;
  (void)::umask(before);
  if (!bound) {
    close();
    return SocketStatus::kCannotBind;
  }
  std::copy_n(path, length + 1, path_.begin());
  const bool listens = ::chmod(path, 0660) == 0 && ::stat(path, &about) == 0 && ::listen(listening_, 4) == 0;
  errno_ = errno;
  if (!listens) {
    close();
    return SocketStatus::kCannotListen;
  }
  group_ = about.st_gid;
  return SocketStatus::kOk;
}

void CommandSocket::close() {
  for (int& handle : operators_) {
    if (handle >= 0) (void)::close(handle);
    handle = -1;
  }
  if (listening_ >= 0) (void)::close(listening_);
  listening_ = -1;
  if (path_[0] != '\0') (void)::unlink(path_.data());
  path_ = {};
}

bool CommandSocket::is_allowed(int handle) const {
  ucred peer{};
  socklen_t size = sizeof peer;
  if (::getsockopt(handle, SOL_SOCKET, SO_PEERCRED, &peer, &size) != 0) return false;
  // The first of them, then as many others as there is room for: more are not looked at.
  std::array<gid_t, kMaxGroups + 1> groups{};
  socklen_t others = kMaxGroups * sizeof(gid_t);
  if (::getsockopt(handle, SOL_SOCKET, SO_PEERGROUPS, groups.data() + 1, &others) != 0) others = 0;
  groups[0] = peer.gid;
  return may_command(peer.uid, std::span(groups).first(1 + others / sizeof(gid_t)), ::geteuid(), group_);
}

void CommandSocket::accept_one() {
  const int handle = ::accept4(listening_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
  if (handle < 0) return;
  if (!is_allowed(handle)) {
    ++counts_.not_allowed;
    (void)::close(handle);
    return;
  }
  const auto free = std::find(operators_.begin(), operators_.end(), -1);
  if (free == operators_.end()) {
    ++counts_.too_many;
    (void)::close(handle);
    return;
  }
  *free = handle;
}

// False where the operator has gone.
bool CommandSocket::answer(int handle, const char* mode, const char* arm_state) {
  std::array<char, kMaxCommandBytes + 1> message{};
  const ssize_t got = ::recv(handle, message.data(), message.size(), MSG_DONTWAIT);
  if (got < 0) return errno == EAGAIN || errno == EINTR;
  if (got == 0) return false;
  std::array<char, 128> text{};
  const ParsedCommand parsed = parse_command({message.data(), static_cast<std::size_t>(got)});
  switch (parsed.verb) {
    case CommandVerb::kOperate:
      ++counts_.accepted;
      channel_->put(parsed.command);
      (void)std::snprintf(text.data(), text.size(), "ok\n");
      break;
    case CommandVerb::kStatus:
      ++counts_.accepted;
      (void)std::snprintf(text.data(), text.size(), "ok %s %s\n", mode, arm_state);
      break;
    case CommandVerb::kMalformed:
      ++counts_.malformed;
      (void)std::snprintf(text.data(), text.size(),
                          "error expected one of: arm disarm servo hold stop reset status\n");
  }
  return ::send(handle, text.data(), std::strlen(text.data()), MSG_DONTWAIT | MSG_NOSIGNAL) > 0;
}

void CommandSocket::serve(int timeout_ms, const char* mode, const char* arm_state) {
  std::array<pollfd, kMaxOperators + 1> waiting{};
  waiting[0] = {listening_, POLLIN, 0};
  for (std::size_t i = 0; i < operators_.size(); ++i) waiting[i + 1] = {operators_[i], POLLIN, 0};
  if (::poll(waiting.data(), waiting.size(), timeout_ms) <= 0) return;
  for (std::size_t i = 0; i < operators_.size(); ++i) {
    if (operators_[i] < 0 || waiting[i + 1].revents == 0) continue;
    if (answer(operators_[i], mode, arm_state)) continue;
    (void)::close(operators_[i]);
    operators_[i] = -1;
  }
  if ((waiting[0].revents & POLLIN) != 0) accept_one();
}

}  // namespace vergence
