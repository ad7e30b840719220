// `vergence ctl`, `watch`, `black-box`: the running controller, commanded, watched, and read after a fault.
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <thread>

#include "firmware_like/daemon/telemetry_segment.hpp"
#include "firmware_like/mode.hpp"
#include "tools/cli/commands.hpp"
#include "tools/cli/options.hpp"
#include "tools/controller/black_box_reader.hpp"
#include "tools/controller/record_table.hpp"

namespace vergence::tools {
namespace {

std::string ask(const std::string& path, const std::string& word) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof address.sun_path) throw std::runtime_error(path + ": the path is too long");
  std::copy(path.begin(), path.end(), address.sun_path);
  const int handle = ::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
  if (handle < 0) throw std::runtime_error(std::string("no socket: ") + std::strerror(errno));
  const timeval patience{2, 0};
  (void)::setsockopt(handle, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  std::array<char, 256> answer{};
  ssize_t got = -1;
  if (::connect(handle, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 &&
      ::send(handle, word.data(), word.size(), MSG_NOSIGNAL) > 0) {
    got = ::recv(handle, answer.data(), answer.size() - 1, 0);
  }
  const int error = errno;
  (void)::close(handle);
  if (got > 0) return {answer.data(), static_cast<std::size_t>(got)};
  if (got == 0)
    throw std::runtime_error(path + ": not allowed: only root, its user and its group may command");
  throw std::runtime_error(path + ": " + std::strerror(error) +
                           " (does vergenced run, and are you in its group?)");
}

void control(const std::string& path, const std::string& word) {
  const std::string answer = ask(path, word);
  std::fputs(answer.c_str(), stdout);
  if (!answer.starts_with("ok")) throw std::runtime_error("the controller refused");
}

nlohmann::json json_of(const TelemetryRecord& record) {
  nlohmann::json object;
  const std::vector<std::string>& columns = record_columns();
  const std::vector<double> values = record_values(record);
  for (std::size_t i = 0; i < columns.size(); ++i) object[columns[i]] = values[i];
  object["mode"] = to_string(static_cast<Mode>(record.mode));
  return object;
}

void print_line(const TelemetryRecord& record) {
  const auto& p = record.T_H_M.position_mm;
  std::printf(
      "%10.3f s  %-9s target %8.1f %8.1f %8.1f mm  confidence %.2f  arm period late %lld us at worst\n",
      static_cast<double>(record.t_ns) * 1e-9, to_string(static_cast<Mode>(record.mode)), p[0], p[1], p[2],
      record.confidence,
      static_cast<long long>(record.tasks[static_cast<std::size_t>(TaskId::kArm)].worst_latency_ns / 1000));
}

struct WatchOptions {
  std::string name = "/vergence";
  double every_s = 0.5;
  bool once = false;
  bool json = false;
};

void watch(const WatchOptions& options) {
  TelemetryReader reader;
  if (const SegmentStatus status = reader.open(options.name.c_str()); status != SegmentStatus::kOk) {
    throw std::runtime_error(options.name + ": " + describe(status));
  }
  TelemetryRecord record;
  std::int64_t last_ns = -1;
  do {
    if (!reader.read(record)) throw std::runtime_error(options.name + ": nothing was written yet");
    if (record.t_ns == last_ns) throw std::runtime_error(options.name + ": the controller has gone");
    last_ns = record.t_ns;
    if (options.json) {
      std::printf("%s\n", json_of(record).dump().c_str());
    } else {
      print_line(record);
    }
    (void)std::fflush(stdout);
    if (!options.once) std::this_thread::sleep_for(std::chrono::duration<double>(options.every_s));
  } while (!options.once);
}

}  // namespace

void add_controller_commands(CLI::App& app) {
  CLI::App* ctl = app.add_subcommand("ctl", "Command a running vergenced");
  const auto word = std::make_shared<std::string>();
  const auto path = std::make_shared<std::string>("/run/vergence/command");
  ctl->add_option("COMMAND", *word, "arm, disarm, servo, hold, stop, reset or status")
      ->required()
      ->check(CLI::IsMember({"arm", "disarm", "servo", "hold", "stop", "reset", "status"}));
  ctl->add_option("--socket", *path, "Where it listens: runtime.command_socket")->capture_default_str();
  ctl->callback([word, path] { control(*path, *word); });
  ctl->footer("\nExample:\n  vergence ctl arm && vergence ctl servo");

  CLI::App* watching = app.add_subcommand("watch", "Watch a running vergenced, without disturbing it");
  const auto options = std::make_shared<WatchOptions>();
  watching->add_option("--telemetry", options->name, "Its shared memory: runtime.telemetry")
      ->capture_default_str();
  watching->add_option("--every-s", options->every_s, "Seconds between lines")
      ->check(within(0.001, 3600))
      ->capture_default_str();
  watching->add_flag("--once", options->once, "One line");
  watching->add_flag("--json", options->json, "Everything, as a JSON object a line");
  watching->callback([options] { watch(*options); });

  CLI::App* box =
      app.add_subcommand("black-box", "Turn what vergenced kept of a fault into tables and pictures");
  const auto file = std::make_shared<std::filesystem::path>();
  const auto out = std::make_shared<std::filesystem::path>();
  box->add_option("FILE", *file, "As vergenced named it")->required();
  box->add_option("-o,--out", *out, "Directory for log.csv and pictures/")->required()->type_name("DIR");
  box->callback([file, out] {
    const BoxSummary summary = unpack_black_box(*file, *out);
    std::printf("%zu periods and %zu pairs of pictures, the fault at %.3f s: %s/log.csv\n", summary.records,
                summary.pairs, summary.fault_s, out->c_str());
  });
}

}  // namespace vergence::tools
