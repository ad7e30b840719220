#include "tools/bringup/look_at_files.hpp"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>

#include "firmware_like/daemon/black_box.hpp"
#include "tools/config/config_file.hpp"
#include "tools/io/input_error.hpp"
#include "tools/io/toml_reader.hpp"

namespace vergence::tools {
namespace {

namespace fs = std::filesystem;

bool is_there(const fs::path& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}

// Also of a configuration that is wrong elsewhere.
void look_at_parts(const fs::path& config, FileObservation& seen) {
  const TomlReader root = TomlReader::from_file(config);
  for (const char* const what : {"rig", "model", "search", "arm"}) {
    if (!root.has(what)) continue;
    fs::path path = config.parent_path() / root.text(what);
    if (std::strcmp(what, "model") == 0) path /= "model.toml";
    seen.parts.push_back({what, path, is_there(path)});
  }
}

FolderState look_at_folder_of(const fs::path& file) {
  FolderState state;
  state.path = file.has_parent_path() ? file.parent_path() : fs::path(".");
  std::error_code ignored;
  state.exists = fs::is_directory(state.path, ignored);
  state.is_writable = state.exists && ::access(state.path.c_str(), W_OK | X_OK) == 0;
  return state;
}

void look_at_box(const char* path, FileObservation& seen) {
  seen.box_folder = look_at_folder_of(path);
  std::error_code error;
  const fs::space_info space = fs::space(seen.box_folder.path, error);
  if (!error) seen.box_free_bytes = space.available;
  for (int i = 1; i <= BlackBoxFile::kMostFiles; ++i) {
    if (is_there(std::string(path) + "." + std::to_string(i))) ++seen.boxes;
  }
}

FileObservation::Controller look_for_controller(const PathText& path) {
  using Controller = FileObservation::Controller;
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  static_assert(std::tuple_size_v<PathText> <= sizeof address.sun_path);
  std::copy_n(path.begin(), path.size(), address.sun_path);
  const int probe = ::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (probe < 0) return Controller::kUnknown;
  const int answer = ::connect(probe, reinterpret_cast<const sockaddr*>(&address), sizeof address);
  const int error = errno;
  (void)::close(probe);
  // Full is busy, and so is alive.
  if (answer == 0 || error == EAGAIN) return Controller::kRuns;
  return error == EACCES || error == EPERM ? Controller::kUnknown : Controller::kStopped;
}

}  // namespace

ConfigLook look_at_files(const fs::path& file) {
  ConfigLook look;
  FileObservation& seen = look.seen;
  seen.config = file;
  seen.is_image = is_config_image(file);
  try {
    if (!seen.is_image) look_at_parts(file, seen);
    look.config = read_any_config(file);
  } catch (const InputError& error) {
    seen.config_problem = error.what();
    return look;
  }
  try {
    seen.image_bytes = image_of(file, *look.config).size();
  } catch (const InputError& error) {
    seen.image_problem = error.what();
  }
  const RuntimeConfig& runtime = look.config->runtime;
  look_at_box(runtime.black_box.data(), seen);
  seen.socket_folder = look_at_folder_of(runtime.command_socket.data());
  seen.controller = look_for_controller(runtime.command_socket);
  return look;
}

}  // namespace vergence::tools
