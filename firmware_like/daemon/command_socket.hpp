// Where operators say what the controller is to do: a Unix-domain socket of mode 0660, one word a message,
// one line of answer. Who else than the socket's owner, its group and root may not speak is refused by their
// credentials, whatever the file's mode has become.
//
//   arm | disarm | servo | hold | stop | reset   ->  "ok"
//   status                                       ->  "ok MODE STATE-OF-THE-ARM"
//   anything else                                ->  "error ..." and nothing happens
//
// Served by one ordinary thread, which waits here; nothing of it is on the way of the control.
#pragma once

#include <sys/types.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "firmware_like/daemon/operator_channel.hpp"
#include "firmware_like/mode.hpp"

namespace vergence {

inline constexpr std::size_t kMaxCommandBytes = 32;
inline constexpr int kMaxOperators = 8;  // connected at a time

enum class CommandVerb : std::uint8_t {
  kOperate,
  kStatus,
  kMalformed,
};
struct ParsedCommand {
  CommandVerb verb = CommandVerb::kMalformed;
  OperatorCommand command = OperatorCommand::kStop;
};
// Exactly one of the words above; a line's end may follow.
[[nodiscard]] ParsedCommand parse_command(std::string_view message);

struct CommandCounts {
  std::uint64_t accepted = 0;
  std::uint64_t malformed = 0;
  std::uint64_t not_allowed = 0;
  std::uint64_t too_many = 0;
};

enum class SocketStatus : std::uint8_t {
  kOk,
  kBadPath,
  kInUse,  // somebody answers there
  kCannotBind,
  kCannotListen,
};
// What is wrong and what to do, for people.
[[nodiscard]] const char* describe(SocketStatus status);

// Whether who has these credentials may command: root, the controller's own user, members of the socket's
// group.
[[nodiscard]] bool may_command(uid_t peer_user, std::span<const gid_t> peer_groups, uid_t own_user,
                               gid_t socket_group);

class CommandSocket {
 public:
  explicit CommandSocket(OperatorChannel& channel) : channel_(&channel) {}
  ~CommandSocket() { close(); }
  CommandSocket(const CommandSocket&) = delete;
  CommandSocket& operator=(const CommandSocket&) = delete;

  [[nodiscard]] SocketStatus open(const char* path);
  void close();
  // Waits for messages, at most so long, and answers them. `words` tells the mode and the arm's state.
  void serve(int timeout_ms, const char* mode, const char* arm_state);

  [[nodiscard]] const CommandCounts& counts() const { return counts_; }
  [[nodiscard]] int last_errno() const { return errno_; }

 private:
  [[nodiscard]] bool is_allowed(int operator_handle) const;
  void accept_one();
  [[nodiscard]] bool answer(int operator_handle, const char* mode, const char* arm_state);

  OperatorChannel* channel_;
  int listening_ = -1;
  std::array<int, kMaxOperators> operators_ = filled_with(-1);
  gid_t group_ = 0;
  std::array<char, 108> path_{};
  CommandCounts counts_;
  int errno_ = 0;

  static constexpr std::array<int, kMaxOperators> filled_with(int value) {
    std::array<int, kMaxOperators> all{};
    for (int& one : all) one = value;
    return all;
  }
};

}  // namespace vergence
