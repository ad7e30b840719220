// `vergence calibrate` from pictures and tables to rig.toml; and bad input ends with status 2, file, field,
// remedy.
#include <cmath>
#include <cstdio>
#include <functional>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>

#include "algo/rotation_vector.hpp"
#include "tests/cli/run_vergence.hpp"
#include "tests/support/chessboard.hpp"
#include "tests/support/small_dataset.hpp"
#include "tools/calibrate/rig_file.hpp"
#include "tools/calibrate/slopes.hpp"
#include "tools/io/dataset.hpp"

namespace vergence::test {
namespace {

using std::filesystem::path;
using Json = nlohmann::json;

constexpr calibrate::Board kBoard{7, 4, 30};
constexpr const char* kBoardOptions = " --board 7x4 --square-mm 30 --no-progress ";
constexpr double kNoise = 2;
constexpr int kViews = 10;
constexpr const char* kPoseColumns = "x_mm,y_mm,z_mm,e1,e2,e3\n";

// Small pictures, quickly made.
StereoRig small_rig() {
  StereoRig rig = true_rig();
  for (CameraModel* camera : {&rig.left, &rig.right}) {
    camera->width_px = 320;
    camera->height_px = 240;
    for (double* value : {&camera->fx_px, &camera->fy_px, &camera->cx_px, &camera->cy_px}) *value *= 0.5;
  }
  return rig;
}

std::string row(double first, const Pose& pose) {
  char text[256];
  const Vector3& p = pose.position_mm;
  const Vector3& e = pose.e;
  std::snprintf(text, sizeof text, "%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g\n", first, p[0], p[1], p[2], e[0],
                e[1], e[2]);
  return text;
}

// The pictures of a board that stands still, and hand.csv; made once.
const TempDirectory& good_pictures() {
  static const TempDirectory directory;
  static const bool made = [] {
    const StereoRig rig = small_rig();
    const auto T_H_B = board_poses(rig, kBoard, kViews, 1);
    write_board_pictures(directory.path(), rig, T_H_B, kBoard, kNoise, 1);
    const Transform T_W_B{turn_deg(170, {1, 0.1, 0.2}), {600, -200, 50}};
    std::string hand = std::string("frame,") + kPoseColumns;
    for (std::size_t i = 0; i < T_H_B.size(); ++i)
      hand += row(static_cast<double>(i), to_pose(T_W_B * T_H_B[i].inverse()));
    write_file(directory / "hand.csv", hand);
    calibrate::write_rig(directory / "rig.toml", rig, {});
    return true;
  }();
  EXPECT_TRUE(made);
  return directory;
}

// A copy that may be broken.
struct Copy {
  Copy() {
    std::filesystem::copy(
        good_pictures().path(), directory.path(),
        std::filesystem::copy_options::recursive | std::filesystem::copy_options::overwrite_existing);
  }
  [[nodiscard]] std::string stereo(const std::string& options = "") const {
    return "calibrate stereo " + directory.path().string() + kBoardOptions + "-o " +
           (directory / "out.toml").string() + " " + options;
  }
  [[nodiscard]] std::string hand_eye(const std::string& options = "") const {
    return "calibrate hand-eye " + directory.path().string() + kBoardOptions + "--rig " +
           (directory / "rig.toml").string() + " -o " + (directory / "out.toml").string() + " " + options;
  }
  TempDirectory directory;
};

TEST(CalibrateCli, FromPicturesToTheCamerasInTheHand) {
  const Copy data;
  const std::string json = (data.directory / "stereo.json").string();
  const CommandResult stereo =
      run_vergence(data.stereo("--json " + json + " --overlay " + (data.directory / "over").string()));
  ASSERT_EQ(stereo.status, 0) << stereo.output;
  EXPECT_NE(stereo.output.find("10 used, 0 left out"), std::string::npos) << stereo.output;
  const Json report = Json::parse(read_file(json));
  EXPECT_EQ(report["views"].size(), 10U);
  EXPECT_LT(report["left"]["rms_px"], 0.06);
  EXPECT_EQ(tools::read_png_rgb(data.directory / "over/000009.png").width_px, 640);
  const StereoRig truth = small_rig();
  const StereoRig found = tools::read_rig(data.directory / "out.toml");
  EXPECT_EQ(found.left.width_px, 320);
  EXPECT_LT(std::abs(found.left.fx_px - truth.left.fx_px), 4 * report["left"]["sigma"]["fx"].get<double>());
  EXPECT_NEAR(found.right.T_H_C.t_mm.x(), 0.5 * report["baseline_mm"].get<double>(), 1e-5);

  std::filesystem::rename(data.directory / "out.toml", data.directory / "rig.toml");
  const CommandResult hand_eye = run_vergence(data.hand_eye("--json -"));
  ASSERT_EQ(hand_eye.status, 0) << hand_eye.output;
  const Json result = Json::parse(hand_eye.output);
  const StereoRig placed = tools::read_rig(data.directory / "out.toml");
  // Ten small pictures leave half a pixel of doubt about the principal points: a millimetre at half a metre.
  EXPECT_LT((placed.left.T_H_C.t_mm - truth.left.T_H_C.t_mm).norm(), 3);
  EXPECT_LT((placed.right.T_H_C.t_mm - truth.right.T_H_C.t_mm).norm(), 3);
  EXPECT_LT(vector_from_rotation(placed.right.T_H_C.R.transpose() * truth.right.T_H_C.R).norm(), 0.002);
  EXPECT_EQ(placed.left.fx_px, found.left.fx_px);
  EXPECT_EQ(result["left"]["covariance"].size(), 36U);
  EXPECT_EQ(result["methods"].size(), 5U);

  calibrate::write_rig(data.directory / "rig.toml", truth, {});
  ASSERT_EQ(run_vergence(data.hand_eye()).status, 0);
  const StereoRig exact = tools::read_rig(data.directory / "out.toml");
  EXPECT_LT((exact.left.T_H_C.t_mm - truth.left.T_H_C.t_mm).norm(), 0.2);
  EXPECT_LT((exact.right.T_H_C.t_mm - truth.right.T_H_C.t_mm).norm(), 0.2);
}

TEST(CalibrateCli, SaysWhichPicturesHaveNoBoard) {
  const Copy data;
  tools::GreyImage grey{320, 240, std::vector<std::uint8_t>(320 * 240, 90)};
  write_png(data.directory / "right/000004.png", grey);
  const CommandResult result = run_vergence(data.stereo());
  EXPECT_EQ(result.status, 0) << result.output;
  EXPECT_NE(result.output.find("right/000004.png: the board is not found"), std::string::npos)
      << result.output;
  EXPECT_NE(result.output.find("9 used"), std::string::npos) << result.output;
}

struct Breakage {
  const char* name;
  bool hand_eye;
  std::function<void(const path&)> break_it;
  const char* file;  // what the message must hold
  const char* problem;
  const char* remedy = "";
  const char* options = "";
};

void PrintTo(const Breakage& breakage, std::ostream* out) {
  *out << breakage.name;
}

auto nothing() {
  return [](const path&) {};
}
auto remove(const char* file) {
  return [=](const path& data) { std::filesystem::remove_all(data / file); };
}
auto write(const char* file, const std::string& content) {
  return [=](const path& data) { write_file(data / file, content); };
}
auto replace(const char* file, const char* from, const char* to) {
  return [=](const path& data) { replace_in_file(data / file, from, to); };
}
void keep_first(const path& data, int count) {
  for (int i = count; i < kViews; ++i) {
    for (const char* side : {"left", "right"})
      std::filesystem::remove(data / side / ("00000" + std::to_string(i) + ".png"));
  }
}
// All views alike, straight on.
void take_one_view(const path& data) {
  const StereoRig rig = small_rig();
  const Transform T_H_B{rig.left.T_H_C.R, Vector3(-90, -145, 560)};
  write_board_pictures(data, rig, std::vector<Transform>(kViews, T_H_B), kBoard, 0, 1);
}
void swap_sides(const path& data) {
  std::filesystem::rename(data / "left", data / "other");
  std::filesystem::rename(data / "right", data / "left");
  std::filesystem::rename(data / "other", data / "right");
}
// Positions in metres.
void hand_in_metres(const path& data) {
  std::istringstream in(read_file(data / "hand.csv"));
  std::string text;
  std::getline(in, text);
  text += '\n';
  for (std::string line; std::getline(in, line);) {
    std::istringstream fields(line);
    std::string field;
    for (int i = 0; std::getline(fields, field, ','); ++i) {
      text += i == 0 ? "" : ",";
      text += i >= 1 && i <= 3 ? std::to_string(std::stod(field) / 1000) : field;
    }
    text += '\n';
  }
  write_file(data / "hand.csv", text);
}
void hand_stands_still(const path& data) {
  std::string text = std::string("frame,") + kPoseColumns;
  for (int i = 0; i < kViews; ++i) text += row(i, {{100.0 * i, 0, 500}, {0.1, 0, 0}});
  write_file(data / "hand.csv", text);
}

const Breakage kBreakages[] = {
    {"NoPictures", false, [](const path& d) { keep_first(d, 0); }, "", "holds no pictures",
     "left/000000.png"},
    {"NoRightFolder", false, remove("right"), "right", "no such folder", "left/000000.png"},
    {"MissingRight", false, remove("right/000003.png"), "right/000003.png", "missing", "take pairs"},
    {"MissingLeft", false, remove("left/000007.png"), "left/000007.png", "missing", "9 left pictures"},
    {"TwoOfANumber", false, write("left/000003.jpg", ""), "left/000003", "same number",
     "one picture a number"},
    {"OtherSize", false,
     [](const path& d) {
       write_png(d / "right/000002.png", tools::GreyImage{64, 48, std::vector<std::uint8_t>(3072)});
     },
     "right/000002.png", "size: is 64 x 48", "one size"},
    {"TooLarge", false,
     [](const path& d) {
       write_png(d / "left/000000.png", tools::GreyImage{2000, 100, std::vector<std::uint8_t>(200000)});
     },
     "left/000000.png", "size: is 2000 x 100", "1280 x 1024"},
    {"NoPng", false, write("left/000001.png", "text"), "left/000001.png", "PNG"},
    {"NoJpeg", false,
     [](const path& d) {
       std::filesystem::remove(d / "left/000001.png");
       write_file(d / "left/000001.jpg", "text");
     },
     "left/000001.jpg", "not a readable JPEG", "leave the pair out"},
    {"AnotherBoard", false, nothing(), "left", "--board: no pair shows all 9 x 6", "inner corners",
     "--board 9x6"},
    {"TooFewViews", false, [](const path& d) { keep_first(d, 4); }, "", "views: 4 good views, at least 5",
     "12 to 30"},
    {"TooStrict", false, nothing(), "", "left out for their error", "12 to 30",
     "--max-reprojection-px 0.001"},
    {"OneViewOnly", false, take_one_view, "", "views: the views do not", "tilt the board"},
    {"SwappedSides", false, swap_sides, "left", "to the left of the left one", "swap the folders"},
    {"BoardOfSquares", false, nothing(), "--board", "'7by4'", "inner corners", "--board 7by4"},
    {"BoardTooSmall", false, nothing(), "--board", "'2x4'", "3 to 40", "--board 2x4"},
    {"SquareNan", false, nothing(), "--square-mm", "nan", "", "--square-mm nan"},
    {"OutUnwritable", false, nothing(), "no/such/rig.toml", "cannot be written", "", "-o no/such/rig.toml"},
    {"NoRig", true, remove("rig.toml"), "rig.toml", "no such file"},
    {"RigNan", true, replace("rig.toml", "fx = ", "fx = nan #"), "rig.toml", "left.fx"},
    {"RigOfOtherSize", true, replace("rig.toml", "width = 320", "width = 640"), "rig.toml",
     "image: says 640 x 240", "calibrate stereo"},
    {"NoHand", true, remove("hand.csv"), "hand.csv", "no such file", "frame,x_mm"},
    {"HandHeader", true, replace("hand.csv", "frame,x_mm", "t_s,x_mm"), "hand.csv", "header",
     "expected frame,x_mm"},
    {"HandNan", true, write("hand.csv", std::string("frame,") + kPoseColumns + "0,1,2,nan,0,0,0\n"),
     "hand.csv", "line 2: z_mm", "finite"},
    {"HandNoQuaternion", true, write("hand.csv", std::string("frame,") + kPoseColumns + "0,1,2,3,1,1,0\n"),
     "hand.csv", "line 2: e1", "at most 1"},
    {"HandTwice", true,
     write("hand.csv", std::string("frame,") + kPoseColumns + "0,1,2,3,0,0,0\n0,1,2,3,0,0,0\n"), "hand.csv",
     "line 3: frame: appears twice", "one row"},
    {"HandEmpty", true, write("hand.csv", std::string("frame,") + kPoseColumns), "hand.csv", "no rows",
     "frame,x_mm"},
    {"HandRowMissing", true, replace("hand.csv", "\n6,", "\n66,"), "hand.csv", "frame: no row for",
     "number 6"},
    {"HandInMetres", true, hand_in_metres, "hand.csv", "contradict the pictures", "in mm"},
    {"HandStandsStill", true, hand_stands_still, "hand.csv", "e1, e2, e3: the hand turned by only",
     "20 to 40 degrees"},
    {"HandTooFew", true, [](const path& d) { keep_first(d, 4); }, "hand.csv", "4 pairs show the board",
     "12 to 30"},
    {"BoardIsSymmetric", true, nothing(), "--board", "half a turn", "9x6", "--board 8x4"},
};

class BadCalibration : public ::testing::TestWithParam<Breakage> {};

TEST_P(BadCalibration, EndsWithStatusTwoAndNamesIt) {
  const Copy data;
  const Breakage& breakage = GetParam();
  breakage.break_it(data.directory.path());
  std::string arguments = breakage.hand_eye ? data.hand_eye() : data.stereo();
  // An option may be given once: the breakage's stands in place of the usual one.
  std::istringstream words(breakage.options);
  std::string option;
  std::string value;
  if (words >> option >> value) {
    const std::size_t at = arguments.find(" " + option + " ");
    if (at == std::string::npos) {
      arguments += " " + option + " " + value;
    } else {
      const std::size_t from = at + option.size() + 2;
      arguments.replace(from, arguments.find(' ', from) - from, value);
    }
  }
  expect_refusal(arguments, breakage.file, breakage.problem, breakage.remedy);
  EXPECT_FALSE(std::filesystem::exists(data.directory / "out.toml"));
  EXPECT_FALSE(std::filesystem::exists(data.directory / "out.toml.new"));
}

INSTANTIATE_TEST_SUITE_P(Cases, BadCalibration, ::testing::ValuesIn(kBreakages),
                         [](const auto& test) { return std::string(test.param.name); });

// A target that stands still, seen from a swaying hand with stamps 12.5 ms early.
struct Sway {
  explicit Sway(double speed = 1) {
    std::string hand = std::string("t_s,") + kPoseColumns;
    std::string frames = hand;
    const auto hand_at = [&](double t_s) {
      Vector6 d;
      d << 60 * std::sin(2.1 * speed * t_s), 50 * std::sin(1.7 * speed * t_s),
          20 * std::sin(3.1 * speed * t_s), 0, 0.1 * std::sin(2.6 * speed * t_s), 0;
      return calibrate::moved({turn_deg(30, {1, 0, 0}), {0, 0, 900}}, d);
    };
    for (int i = 0; i < 2500; ++i) hand += row(0.004 * i, to_pose(hand_at(0.004 * i)));
    for (int i = 10; i < 290; ++i) {
      const Transform T_H_M = hand_at(i / 30.0).inverse() * Transform{Matrix3::Identity(), {0, -250, 1300}};
      frames += row(i / 30.0 - 0.0125, to_pose(T_H_M));
    }
    write_file(directory / "hand.csv", hand);
    write_file(directory / "frames.csv", frames);
  }
  [[nodiscard]] std::string command(const std::string& options = "") const {
    return "calibrate time-offset " + directory.path().string() + " " + options;
  }
  TempDirectory directory;
};

TEST(CalibrateCli, FindsTheTimeOffset) {
  const Sway sway;
  const CommandResult result = run_vergence(sway.command());
  EXPECT_EQ(result.status, 0) << result.output;
  EXPECT_NE(result.output.find("[cameras]\nstamp_to_mid_exposure_ms = 12.5"), std::string::npos)
      << result.output;
  const CommandResult json = run_vergence(sway.command("--json -"));
  EXPECT_NEAR(Json::parse(json.output)["stamp_to_mid_exposure_ms"].get<double>(), 12.5, 0.01);
}

TEST(CalibrateCli, TakesPosesInACameraForTheTimeOffset) {
  const Sway sway;
  const StereoRig rig = small_rig();
  calibrate::write_rig(sway.directory / "rig.toml", rig, {});
  std::istringstream in(read_file(sway.directory / "frames.csv"));
  std::string line;
  std::getline(in, line);
  std::string moved = line + "\n";
  while (std::getline(in, line)) {
    std::istringstream fields(line);
    std::vector<double> v;
    for (std::string field; std::getline(fields, field, ',');) v.push_back(std::stod(field));
    moved += row(v[0],
                 to_pose(rig.right.T_H_C.inverse() * to_transform({{v[1], v[2], v[3]}, {v[4], v[5], v[6]}})));
  }
  write_file(sway.directory / "frames.csv", moved);
  const CommandResult json = run_vergence(
      sway.command("--json - --in-camera right --rig " + (sway.directory / "rig.toml").string()));
  ASSERT_EQ(json.status, 0) << json.output;
  EXPECT_NEAR(Json::parse(json.output)["stamp_to_mid_exposure_ms"].get<double>(), 12.5, 0.01);
}

TEST(CalibrateCli, RefusesBadTablesOfTime) {
  const Sway sway;
  const auto good = read_file(sway.directory / "frames.csv");
  const std::string header = std::string("t_s,") + kPoseColumns;
  write_file(sway.directory / "frames.csv", header + "0,1,2,nan,0,0,0\n");
  expect_refusal(sway.command(), "frames.csv", "line 2: z_mm", "finite");
  write_file(sway.directory / "frames.csv", header + "0,1,2,3,0,0,0\n0,1,2,3,0,0,0\n");
  expect_refusal(sway.command(), "frames.csv", "line 3: t_s", "sort the rows by time");
  write_file(sway.directory / "frames.csv", header + "0,1,2,3,0,0,0\n1,1,2,3,0,0,0\n");
  expect_refusal(sway.command(), "frames.csv", "t_s", "at least 30");
  std::filesystem::remove(sway.directory / "frames.csv");
  expect_refusal(sway.command(), "frames.csv", "no such file", "t_s,x_mm");
  write_file(sway.directory / "frames.csv", good);
  std::filesystem::remove(sway.directory / "hand.csv");
  expect_refusal(sway.command(), "hand.csv", "no such file", "t_s,x_mm");
  write_file(sway.directory / "hand.csv", std::string("frame,") + kPoseColumns + "0,1,2,3,0,0,0\n");
  expect_refusal(sway.command(), "hand.csv", "header", "expected t_s,x_mm");
  expect_refusal(sway.command("--range-ms nan"), "--range-ms");
  expect_refusal(sway.command("--in-camera left"), "--in-camera", "--rig");
  const Sway still(0);
  expect_refusal(still.command(), "hand.csv", "too slow", "faster");
}

}  // namespace
}  // namespace vergence::test
