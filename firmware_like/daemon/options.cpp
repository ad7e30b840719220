#include "firmware_like/daemon/options.hpp"

#include <string_view>

namespace vergence {

bool parse_options(int argc, char** argv, DaemonOptions& options, const char*& problem) {
  problem = "";
  for (int i = 1; i < argc; ++i) {
    const std::string_view argument = argv[i];
    constexpr std::string_view kConfig = "--config=";
    if (argument == "--config" && i + 1 < argc) {
      options.config = argv[++i];
    } else if (argument.starts_with(kConfig)) {
      options.config = argv[i] + kConfig.size();
    } else if (argument == "--realtime=enforce") {
      options.realtime = rt::RealtimePolicy::kEnforce;
    } else if (argument == "--realtime=ignore") {
      options.realtime = rt::RealtimePolicy::kIgnore;
    } else if (argument == "--check") {
      options.checks_only = true;
    } else if (argument == "--help" || argument == "-h") {
      options.shows_help = true;
    } else if (argument == "--version") {
      options.shows_version = true;
    } else {
      problem = argv[i];
      return false;
    }
  }
  if (options.config == nullptr && !options.shows_help && !options.shows_version) {
    problem = "--config is missing";
    return false;
  }
  return true;
}

}  // namespace vergence
