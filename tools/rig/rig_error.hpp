// What keeps the rig from working, for people.
#pragma once

#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <string>

namespace vergence::rig {

struct RigError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

[[noreturn]] inline void fail_with_errno(const std::string& what) {
  throw RigError(what + ": " + std::strerror(errno));
}

}  // namespace vergence::rig
