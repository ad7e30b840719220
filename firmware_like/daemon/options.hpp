// The command line of `vergenced`.
#pragma once

#include "hal/rt/rt_thread.hpp"

namespace vergence {

struct DaemonOptions {
  const char* config = nullptr;
  rt::RealtimePolicy realtime = rt::RealtimePolicy::kEnforce;
  bool checks_only = false;  // the machine and the configuration; nothing is opened
  bool shows_help = false;
  bool shows_version = false;
};

// False with what is wrong in `problem`.
[[nodiscard]] bool parse_options(int argc, char** argv, DaemonOptions& options, const char*& problem);

inline constexpr const char* kUsage =
    "Usage: vergenced --config robot.vcfg [--realtime=enforce|ignore] [--check]\n"
    "\n"
    "  --config FILE         made by `vergence config build`\n"
    "  --realtime=enforce    refuse a machine that cannot keep time (default)\n"
    "  --realtime=ignore     say what is missing, and run without\n"
    "  --check               judge configuration and machine, and end\n"
    "  --version, --help\n"
    "\n"
    "Drives stay off until `vergence ctl arm`. SIGTERM and SIGINT stop the arm, then the program.\n"
    "Exit status: 0 ended as asked, 1 failed, 2 usage or bad configuration.\n";

}  // namespace vergence
