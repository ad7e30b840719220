#include "tools/bench/cyclictest.hpp"

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace vergence::tools {
namespace {

// It keeps a count a nanosecond up to there; of what is longer, the number and the greatest.
constexpr int kCounted_ns = 1'000'000;

std::vector<std::string> command_of(const CyclictestOptions& options, const std::filesystem::path& file) {
  std::vector<std::string> command = {"cyclictest",
                                      "--quiet",
                                      "--mlockall",
                                      "--nsecs",
                                      "--threads=1",
                                      "--duration=" + std::to_string(options.seconds),
                                      "--interval=" + std::to_string(options.interval_ns / 1000),
                                      "--priority=" + std::to_string(options.priority),
                                      "--histogram=" + std::to_string(kCounted_ns),
                                      "--json=" + file.string()};
  if (options.core >= 0) command.push_back("--affinity=" + std::to_string(options.core));
  return command;
}

rt::DurationHistogram read(const nlohmann::json& thread) {
  rt::DurationHistogram histogram;
  for (const auto& [ns, count] : thread.at("histogram").items()) {
    for (std::uint64_t i = 0; i < count.get<std::uint64_t>(); ++i) histogram.add(std::stoll(ns));
  }
  const std::uint64_t cycles = thread.at("cycles").get<std::uint64_t>();
  const auto longest_ns = thread.at("max").get<std::int64_t>();
  while (histogram.count() < cycles) histogram.add(longest_ns);
  return histogram;
}

}  // namespace

Cyclictest::Cyclictest(const CyclictestOptions& options, const std::filesystem::path& file)
    : file_(file), process_(command_of(options, file)) {}

std::optional<rt::DurationHistogram> Cyclictest::result() {
  const int status = process_.wait();
  std::optional<rt::DurationHistogram> histogram;
  if (status == 0) {
    std::ifstream in(file_);
    try {
      histogram = read(nlohmann::json::parse(in).at("thread").at("0"));
    } catch (const std::exception&) {
      histogram.reset();  // a version that writes something else
    }
  }
  std::filesystem::remove(file_);
  return histogram;
}

}  // namespace vergence::tools
