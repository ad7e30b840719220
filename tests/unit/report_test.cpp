// What a run leaves behind can be trusted: the log keeps every bit, its signature notices one that changed,
// the numbers read back, and the page stands alone.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "tests/support/small_dataset.hpp"
#include "tools/io/image_file.hpp"
#include "tools/io/input_error.hpp"
#include "tools/report/base64.hpp"
#include "tools/report/html_report.hpp"
#include "tools/report/log_table.hpp"
#include "tools/report/metric.hpp"

namespace vergence::tools {
namespace {

using test::read_file;
using test::TempDirectory;
using test::write_file;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kSmallest = std::numeric_limits<double>::denorm_min();

LogTable small_log() {
  LogTable log({"t_s", "hand_x_mm"});
  log.append({0.0, 1.5});
  log.append({0.002, -kInfinity});
  log.append({0.004, kNaN});
  log.append({-0.0, kSmallest});
  return log;
}

// Runs it and answers the message of what it throws.
template <class Error, class Run>
std::string message_of(Run run) {
  try {
    run();
  } catch (const Error& error) {
    return error.what();
  }
  ADD_FAILURE() << "nothing was thrown";
  return "";
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(LogTable, SignatureIsTheOneWorkedOutByHand) {
  EXPECT_EQ(small_log().signature(), "efadb371574928fc");
}

TEST(LogTable, SignatureNoticesOneBitAndAName) {
  const std::string signature = small_log().signature();
  for (int bit = 0; bit < 64; ++bit) {
    LogTable log({"t_s", "hand_x_mm"});
    log.append({0.0, std::bit_cast<double>(std::bit_cast<std::uint64_t>(1.5) ^ (1ULL << bit))});
    log.append({0.002, -kInfinity});
    log.append({0.004, kNaN});
    log.append({-0.0, kSmallest});
    EXPECT_NE(log.signature(), signature) << "bit " << bit;
  }
  EXPECT_NE(LogTable({"ab", "c"}).signature(), LogTable({"a", "bc"}).signature());
}

TEST(LogTable, SignatureTakesEveryNaNForTheSame) {
  LogTable a({"x"});
  LogTable b({"x"});
  a.append({kNaN});
  b.append({std::bit_cast<double>(0xFFF8000000000123ULL)});
  EXPECT_EQ(a.signature(), b.signature());
}

TEST(LogTable, FileIsThePromisedBytes) {
  const TempDirectory folder;
  small_log().write_csv(folder / "log.csv");
  EXPECT_EQ(read_file(folder / "log.csv"), "t_s,hand_x_mm\n0,1.5\n0.002,-inf\n0.004,\n-0,5e-324\n");
}

TEST(LogTable, ReadsBackBitByBit) {
  LogTable log({"a", "b", "c"});
  std::uint64_t state = 1;
  const auto any_double = [&] {  // of all bit patterns, so of all magnitudes
    state = state * 6364136223846793005ULL + 1442695040888963407ULL;
    return std::bit_cast<double>(state ^ (state >> 29));
  };
  for (int i = 0; i < 2000; ++i) log.append({any_double(), any_double(), any_double()});
  log.append({kInfinity, -kInfinity, kNaN});
  log.append({kSmallest, -kSmallest, std::numeric_limits<double>::min()});
  log.append({-0.0, std::numeric_limits<double>::max(), 0.1});
  const TempDirectory folder;
  log.write_csv(folder / "log.csv");
  const LogTable read = read_log_table(folder / "log.csv");
  ASSERT_EQ(read.rows(), log.rows());
  EXPECT_EQ(read.columns(), log.columns());
  for (const std::string& name : log.columns()) {
    for (std::size_t row = 0; row < log.rows(); ++row) {
      const double before = log.column(name)[row];
      const double after = read.column(name)[row];
      if (std::isnan(before)) {
        EXPECT_TRUE(std::isnan(after)) << name << " " << row;
      } else {
        EXPECT_EQ(std::bit_cast<std::uint64_t>(before), std::bit_cast<std::uint64_t>(after)) << name << row;
      }
    }
  }
  EXPECT_EQ(read.signature(), log.signature());
}

TEST(LogTable, KeepsEmptyRowsOfASingleColumn) {
  LogTable log({"x_mm"});
  for (const double value : {kNaN, 2.0, kNaN}) log.append({value});
  const TempDirectory folder;
  log.write_csv(folder / "log.csv");
  EXPECT_EQ(read_log_table(folder / "log.csv").signature(), log.signature());
}

TEST(LogTable, NamesWhatIsWrong) {
  EXPECT_TRUE(contains(message_of<std::invalid_argument>([] { (void)small_log().column("hand_y_mm"); }),
                       "hand_y_mm"));
  EXPECT_TRUE(small_log().has_column("t_s"));
  EXPECT_FALSE(small_log().has_column("hand_y_mm"));
  EXPECT_THROW(small_log().append({1, 2, 3}), std::invalid_argument);
  EXPECT_THROW(LogTable({"a", "a"}), std::invalid_argument);
  EXPECT_THROW(LogTable({"a,b"}), std::invalid_argument);
  EXPECT_THROW(LogTable({}), std::invalid_argument);

  const TempDirectory folder;
  const auto error_of = [&](const char* content) {
    write_file(folder / "log.csv", content);
    return message_of<InputError>([&] { (void)read_log_table(folder / "log.csv"); });
  };
  EXPECT_TRUE(contains(error_of("a,b\n1,2\n1,two\n"), "log.csv: line 3: b"));
  EXPECT_TRUE(contains(error_of("a,b\n1,2\n1\n"), "log.csv: line 3"));
  EXPECT_TRUE(contains(error_of("a,a\n1,2\n"), "two columns named 'a'"));
}

Summary small_summary() {
  Summary summary{"lateral", 18446744073709551615ULL, "00000000000000ff", 40, {}};
  summary.metrics = {
      {"error_mm", 3.5, "mm", 5.0, Bound::kAtMost, "12.4", "small is good"},
      {"gain_db", -4.5, "dB", -3.0, Bound::kAtLeast, "about -4", "large is good"},
      {"lost_s", 0.25, "s", {}, Bound::kAtMost, {}, "no target"},
      {"settled_s", kNaN, "s", 2.0, Bound::kAtMost, {}, "never measured"},
  };
  return summary;
}

TEST(Metric, IsMetOnTheGoodSideOfItsTarget) {
  Metric metric{"m", 1, "mm", 1.0, Bound::kAtMost, {}, ""};
  EXPECT_TRUE(metric.met());
  metric.value = 1.001;
  EXPECT_FALSE(metric.met());
  metric.bound = Bound::kAtLeast;
  EXPECT_TRUE(metric.met());
  metric.value = kNaN;
  EXPECT_FALSE(metric.met());
  metric.bound = Bound::kAtMost;
  EXPECT_FALSE(metric.met());
  metric.target.reset();
  EXPECT_TRUE(metric.met());
}

TEST(Summary, JsonHoldsWhatTheFormatPromises) {
  const TempDirectory folder;
  write_summary(folder / "summary.json", small_summary());
  const auto json = nlohmann::json::parse(read_file(folder / "summary.json"));
  EXPECT_EQ(json.at("scenario"), "lateral");
  EXPECT_EQ(json.at("seed").get<std::uint64_t>(), 18446744073709551615ULL);
  EXPECT_EQ(json.at("signature"), "00000000000000ff");
  EXPECT_EQ(json.at("duration_s"), 40);
  const auto& metrics = json.at("metrics");
  ASSERT_EQ(metrics.size(), 4U);
  for (const auto& [name, metric] : metrics.items()) {
    EXPECT_EQ(metric.size(), 5U) << name;
    for (const char* field : {"value", "unit", "target", "thesis", "met"}) {
      EXPECT_TRUE(metric.contains(field)) << name << " " << field;
    }
  }
  EXPECT_EQ(metrics.at("error_mm").at("value"), 3.5);
  EXPECT_EQ(metrics.at("error_mm").at("unit"), "mm");
  EXPECT_EQ(metrics.at("error_mm").at("target"), 5.0);
  EXPECT_EQ(metrics.at("error_mm").at("thesis"), 12.4);
  EXPECT_EQ(metrics.at("error_mm").at("met"), true);
  EXPECT_EQ(metrics.at("gain_db").at("thesis"), "about -4");
  EXPECT_EQ(metrics.at("gain_db").at("met"), false);
  EXPECT_TRUE(metrics.at("lost_s").at("target").is_null());
  EXPECT_TRUE(metrics.at("lost_s").at("thesis").is_null());
  EXPECT_TRUE(metrics.at("settled_s").at("value").is_null());
  EXPECT_FALSE(small_summary().all_met());
}

TEST(Summary, DoesNotLoseAMetricToItsNamesake) {
  Summary summary = small_summary();
  summary.metrics.push_back(summary.metrics.front());
  EXPECT_THROW((void)summary_json(summary), std::invalid_argument);
}

TEST(Summary, TextStandsInColumns) {
  EXPECT_EQ(summary_text(small_summary()),
            "lateral, seed 18446744073709551615, 40 s, signature 00000000000000ff\n"
            "  metric     value  unit  target  thesis\n"
            "  error_mm     3.5  mm    ≤ 5     12.4      met\n"
            "  gain_db     -4.5  dB    ≥ -3    about -4  not reached\n"
            "  lost_s      0.25  s     -       -\n"
            "  settled_s      -  s     ≤ 2     -         not reached\n");
}

TEST(Base64, AnswersTheVectorsOfRfc4648) {
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foo"), "Zm9v");
  EXPECT_EQ(base64("foob"), "Zm9vYg==");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(base64("\xFB\xFF\xFE"), "+//+");
}

ReportPage small_page(const std::filesystem::path& png) {
  write_png(png, RgbImage(3, 2));
  ReportPage page;
  page.title = "Lateral <fast> & \"far\"";
  page.description = "The hand's way.";
  page.command = "vergence demo lateral --seed 7 --out 'a & b'";
  page.summary = small_summary();
  page.pictures = {{png, "x < y"}, {png, "the end"}};
  page.notes = {"<script>alert(1)</script>"};
  return page;
}

TEST(HtmlReport, StandsAloneAndEscapes) {
  const TempDirectory folder;
  write_html_report(folder / "report.html", small_page(folder / "a.png"));
  const std::string html = read_file(folder / "report.html");
  EXPECT_TRUE(html.starts_with("<!DOCTYPE html>"));
  for (const char* outside : {"http", "url(", "@import", "<link", "<script"}) {
    EXPECT_FALSE(contains(html, outside)) << outside;
  }
  const std::string embedded = "src=\"data:image/png;base64," + base64(read_file(folder / "a.png")) + "\"";
  std::size_t sources = 0;
  for (std::size_t at = html.find("src="); at != std::string::npos; at = html.find("src=", at + 1)) {
    EXPECT_EQ(html.substr(at, embedded.size()), embedded);
    ++sources;
  }
  EXPECT_EQ(sources, 2U);
  for (const char* expected :
       {"Lateral &lt;fast&gt; &amp; &quot;far&quot;", "The hand&#39;s way.", "--out &#39;a &amp; b&#39;",
        "x &lt; y", "&lt;script&gt;", "00000000000000ff", "18446744073709551615", "not reached", "✓",
        "about -4", "large is good", "≤ 5", "prefers-color-scheme:dark", "@media print"}) {
    EXPECT_TRUE(contains(html, expected)) << expected;
  }
}

TEST(HtmlReport, WantsPicturesThatArePictures) {
  const TempDirectory folder;
  ReportPage page = small_page(folder / "a.png");
  write_file(folder / "b.png", "not one");
  page.pictures.push_back({folder / "b.png", ""});
  const auto write = [&] { write_html_report(folder / "report.html", page); };
  EXPECT_TRUE(contains(message_of<InputError>(write), "b.png"));
  EXPECT_FALSE(std::filesystem::exists(folder / "report.html"));
  page.pictures.back().png = folder / "c.png";
  EXPECT_TRUE(contains(message_of<InputError>(write), "c.png"));
}

TEST(Report, NamesTheFolderThatCannotBeWritten) {
  const TempDirectory folder;
  write_file(folder / "file", "");
  const std::filesystem::path below = folder / "file/below";  // not even for root
  EXPECT_TRUE(
      contains(message_of<InputError>([&] { small_log().write_csv(below / "log.csv"); }), below.string()));
  EXPECT_TRUE(
      contains(message_of<InputError>([&] { write_summary(below / "summary.json", small_summary()); }),
               below.string()));
  EXPECT_TRUE(contains(
      message_of<InputError>([&] { write_html_report(below / "report.html", small_page(folder / "a.png")); }),
      below.string()));
}

}  // namespace
}  // namespace vergence::tools
