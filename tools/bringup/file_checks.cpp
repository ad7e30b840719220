#include "tools/bringup/file_checks.hpp"

#include "firmware_like/daemon/black_box.hpp"

namespace vergence::tools {
namespace {

constexpr int kMostBoxes = BlackBoxFile::kMostFiles;

void judge_config(const FileObservation& seen, Findings& found) {
  if (seen.config_problem.empty()) {
    found.pass("configuration", seen.config.string() + (seen.is_image ? ", an image" : ", TOML"));
  } else {
    found.fail("configuration", seen.config_problem, "mend it; `vergence config check` says the same");
  }
  for (const FileObservation::Part& part : seen.parts) {
    if (part.exists) {
      found.pass(part.what, part.path.string());
    } else {
      found.fail(part.what, part.path.string() + " is not there",
                 "copy it there, or name another in the configuration (dist/examples has one of each)");
    }
  }
  if (seen.is_image && seen.config_problem.empty()) found.pass("rig, model, search, arm", "in the image");
  if (!seen.config_problem.empty()) {
    found.skip("image", "the configuration cannot be read");
  } else if (seen.image_problem.empty()) {
    found.pass("image", format("%zu bytes", seen.image_bytes));
  } else {
    found.fail("image", seen.image_problem, "mend the setting; `vergence config build` makes the image");
  }
}

std::string make_folder(const FolderState& folder) {
  return "sudo install -d -o vergence -g vergence -m 0750 " + folder.path.string();
}

// True where it is there and can be written.
bool judge_folder(const FolderState& folder, const char* check, Outcome missing, const std::string& remedy,
                  Findings& found) {
  const std::string path = folder.path.string();
  if (!folder.exists) {
    found.judge(missing, check, path + " is not there", remedy);
  } else if (!folder.is_writable) {
    // Who sets the robot up need not be who runs it.
    found.warn(check, path + " is not ours to write",
               "see that the user vergenced runs as may write it: `ls -ld " + path + "`");
  }
  return folder.exists && folder.is_writable;
}

void judge_box(const FileObservation& seen, Findings& found) {
  constexpr const char* kCheck = "black box";
  if (!judge_folder(seen.box_folder, kCheck, Outcome::kFail, make_folder(seen.box_folder), found)) return;
  const double mib = 1024.0 * 1024.0;
  const std::string measured = format("%s, %.0f MiB free, %d of %d names taken", seen.box_folder.path.c_str(),
                                      static_cast<double>(seen.box_free_bytes) / mib, seen.boxes, kMostBoxes);
  if (seen.box_free_bytes < kBoxFileBytes) {
    found.fail(kCheck, measured,
               format("make room: a box has %.0f MiB, and without one a fault leaves no record",
                      static_cast<double>(kBoxFileBytes) / mib));
  } else if (seen.boxes >= kMostBoxes) {
    found.fail(kCheck, measured, "move the old boxes elsewhere: none is overwritten");
  } else {
    found.pass(kCheck, measured);
  }
}

void judge_controller(FileObservation::Controller controller, Findings& found) {
  constexpr const char* kCheck = "vergenced";
  switch (controller) {
    case FileObservation::Controller::kStopped: return found.pass(kCheck, "does not run");
    case FileObservation::Controller::kRuns:
      return found.fail(kCheck, "runs, and holds the devices",
                        "stop it first: sudo systemctl stop vergenced");
    case FileObservation::Controller::kUnknown:
      return found.warn(kCheck, "its socket is there and does not let us ask",
                        "make sure that it does not run, or be in its group");
  }
}

}  // namespace

std::vector<Finding> judge(const FileObservation& seen) {
  Findings found("files");
  judge_config(seen, found);
  if (!seen.config_problem.empty()) {
    for (const char* const check : {"black box", "command socket", "vergenced"}) {
      found.skip(check, "the configuration cannot be read");
    }
    return found.take();
  }
  judge_box(seen, found);
  // Of a service, systemd makes it at the start and removes it at the end.
  if (judge_folder(seen.socket_folder, "command socket", Outcome::kWarn,
                   "nothing to do for the service (RuntimeDirectory=); to run vergenced by hand: " +
                       make_folder(seen.socket_folder),
                   found)) {
    found.pass("command socket", seen.socket_folder.path.string());
  }
  judge_controller(seen.controller, found);
  return found.take();
}

}  // namespace vergence::tools
