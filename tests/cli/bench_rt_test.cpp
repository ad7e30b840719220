// `vergence bench rt`: what its answer is made of; not how punctual the machine is that runs the tests.
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "tests/cli/run_vergence.hpp"

namespace vergence::test {
namespace {

class BenchRtTest : public ::testing::Test {
 protected:
  void SetUp() override { std::filesystem::create_directories(folder_); }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  // A program of that name, found before any other.
  void put_program(const std::string& name, const std::string& script) const {
    std::ofstream(folder_ / name) << "#!/bin/sh\n" << script;
    std::filesystem::permissions(folder_ / name, std::filesystem::perms(0755));
  }
  [[nodiscard]] nlohmann::json run(const std::string& options, const std::string& path,
                                   std::string& output) const {
    const std::string file = folder_ / "rt.json";
    const CommandResult result =
        run_vergence("bench rt --seconds 1 --json " + file + " " + options, "PATH=" + path);
    EXPECT_EQ(result.status, 0) << result.output;
    output = result.output;
    std::ifstream in(file);
    return nlohmann::json::parse(in);
  }

  std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("vergence-bench-rt-" + std::to_string(getpid()));
};

TEST_F(BenchRtTest, MeasuresJudgesAndSaysWhatIsMissing) {
  std::string output;
  const nlohmann::json json = run("--stress", folder_.string(), output);
  for (const char* part :
       {"PREEMPT_RT kernel", "lateness of wake-ups, us", "idle    arm", "idle    steps",
        "the arm's calculations, idle", "cyclictest is not installed: apt install rt-tests",
        "stress-ng is not installed: apt install stress-ng", "fit for 500 Hz: worst wake-up", "of 1000 us",
        "jitter_ns = ", "steps/s"}) {
    EXPECT_NE(output.find(part), std::string::npos) << part << " is not in:\n" << output;
  }
  EXPECT_EQ(output.find("ours / theirs"), std::string::npos) << output;
  EXPECT_EQ(json.at("machine").size(), 14U);
  ASSERT_EQ(json.at("loads").size(), 1U);
  for (const char* task : {"arm", "steps"}) {
    const nlohmann::json& of = json.at("loads").at("idle").at(task);
    EXPECT_GT(of.at("latency").at("number"), 1);
    EXPECT_LE(of.at("latency").at("median_us"), of.at("latency").at("max_us"));
    EXPECT_TRUE(of.at("cyclictest_latency").is_null());
    EXPECT_GT(of.at("stack_used_bytes"), 1000);
  }
  EXPECT_GE(json.at("worst_arm_wake_up_us"),
            json.at("loads").at("idle").at("arm").at("latency").at("max_us"));
  // A pulse, a pause and twice the jitter.
  EXPECT_NEAR(json.at("step_rate_steps_per_s").get<double>(),
              1e9 / (10'000 + 2 * json.at("step_jitter_ns").get<double>()), 1e-3);
}

// One that says what it was asked for, and always finds the same: half its wake-ups at 10 us, one at 2 ms.
TEST_F(BenchRtTest, ReadsWhatCyclictestFound) {
  put_program("cyclictest", R"(for word; do
  case "$word" in
    --json=*) file=${word#--json=};;
  esac
done
echo "$@" >>")" + (folder_ / "asked").string() +
                                R"("
echo '{"thread": {"0": {"histogram": {"10000": 5, "20000": 4}, "cycles": 10, "min": 10000, "max": 2000000}}}' >"$file"
)");
  std::string output;
  const nlohmann::json json = run("", folder_.string(), output);
  if (!json.at("real_time")) GTEST_SKIP() << "neither runs without real-time scheduling";
  for (const char* task : {"arm", "steps"}) {
    const nlohmann::json& of = json.at("loads").at("idle").at(task);
    const nlohmann::json& theirs = of.at("cyclictest_latency");
    EXPECT_EQ(theirs.at("number"), 10);
    EXPECT_NEAR(theirs.at("median_us").get<double>(), 10, 10.0 / 16);
    EXPECT_EQ(theirs.at("max_us"), 2000);
    EXPECT_NEAR(of.at("max_ratio_vs_cyclictest").get<double>(),
                of.at("latency").at("max_us").get<double>() / 2000, 1e-9);
  }
  EXPECT_NE(output.find("ours / theirs"), std::string::npos) << output;
  std::ifstream asked(folder_ / "asked");
  const std::string words((std::istreambuf_iterator<char>(asked)), {});
  EXPECT_NE(words.find("--interval=2000 "), std::string::npos) << words;
  EXPECT_NE(words.find("--interval=550 "), std::string::npos) << words;
  EXPECT_NE(words.find("--priority=80"), std::string::npos) << words;
  EXPECT_NE(words.find("--priority=85"), std::string::npos) << words;
}

TEST_F(BenchRtTest, GoesOnWithoutACyclictestThatFails) {
  for (const char* script : {"exit 1", "exit 0"}) {  // and one that writes nothing
    put_program("cyclictest", script);
    std::string output;
    const nlohmann::json json = run("", folder_.string(), output);
    EXPECT_NE(output.find(json.at("real_time") ? "cyclictest failed" : "cyclictest needs"), std::string::npos)
        << output;
    EXPECT_TRUE(json.at("loads").at("idle").at("arm").at("cyclictest_latency").is_null());
  }
}

TEST_F(BenchRtTest, RefusesWhatMakesNoSense) {
  expect_refusal("bench rt --seconds 0", "--seconds");
  expect_refusal("bench rt --seconds soon", "--seconds");
  expect_refusal("bench rt --json " + (folder_ / "none" / "rt.json").string(), "rt.json");
  expect_refusal("bench --quick rt", "--quick");
}

}  // namespace
}  // namespace vergence::test
