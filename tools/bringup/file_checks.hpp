// Is everything there that the controller reads and writes?
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "tools/bringup/finding.hpp"

namespace vergence::tools {

// A folder the controller writes to.
struct FolderState {
  std::filesystem::path path;
  bool exists = false;
  bool is_writable = false;  // for whoever runs this
};

struct FileObservation {
  std::filesystem::path config;
  bool is_image = false;
  std::string config_problem;  // empty: it was read
  struct Part {
    std::string what;  // rig, model, search, arm
    std::filesystem::path path;
    bool exists = false;
  };
  std::vector<Part> parts;  // that TOML names; an image holds them
  std::size_t image_bytes = 0;
  std::string image_problem;

  FolderState box_folder;
  std::uint64_t box_free_bytes = 0;
  int boxes = 0;  // black boxes that are there already
  FolderState socket_folder;
  enum class Controller : std::uint8_t {
    kStopped,
    kRuns,
    kUnknown,  // something is there that we may not ask
  };
  Controller controller = Controller::kStopped;
};

[[nodiscard]] std::vector<Finding> judge(const FileObservation& seen);

}  // namespace vergence::tools
