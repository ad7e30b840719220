// Bad input ends with status 2 and a message that names the file, the field and what to do.
#include <functional>

#include "tests/cli/run_vergence.hpp"
#include "tests/support/small_dataset.hpp"
#include "tools/io/image_file.hpp"

namespace vergence::test {
namespace {

using std::filesystem::path;

struct Breakage {
  const char* name;
  std::function<void(const path&)> break_it;  // of a good photo data set
  const char* file;                           // what the message must hold
  const char* field;
  const char* remedy = "";
};

void PrintTo(const Breakage& breakage, std::ostream* out) {
  *out << breakage.name;
}

auto replace(const char* file, const char* from, const char* to) {
  return [=](const path& dataset) { replace_in_file(dataset / file, from, to); };
}

auto remove(const char* file) {
  return [=](const path& dataset) { std::filesystem::remove_all(dataset / file); };
}

auto write(const char* file, const std::string& content) {
  return [=](const path& dataset) { write_file(dataset / file, content); };
}

auto write_image(const char* file, int width, int height, std::uint8_t level) {
  return [=](const path& dataset) {
    tools::RgbImage image(width, height);
    image.data.assign(image.data.size(), level);
    write_png(dataset / file, image);
  };
}

auto truncate(const char* file) {
  return [=](const path& dataset) {
    const std::string content = read_file(dataset / file);
    write_file(dataset / file, content.substr(0, content.size() / 2));
  };
}

constexpr const char* kMotionHeader = "frame,x_mm,y_mm,z_mm,e1,e2,e3,tilt_rad,pan_right_rad,pan_left_rad\n";

const Breakage kBreakages[] = {
    {"NoRig", remove("rig.toml"), "rig.toml", "no such file"},
    {"NoModel", remove("model"), "model.toml", "no such file"},
    {"NoSearchBox", remove("search.toml"), "search.toml", "no such file"},
    {"NoLeftFolder", remove("left"), "left", "no such folder", "000000.png"},
    {"NoPhoto", remove("model/photo.png"), "photo.png", "no such image"},
    {"RigIsNoToml", write("rig.toml", "[image\nwidth = 1"), "rig.toml", "line 1", "TOML"},
    {"RigIsBinary", write("rig.toml", "\xff\xfe\x01"), "rig.toml", "line 1", "TOML"},
    {"NoWidth", replace("rig.toml", "width = 320", ""), "rig.toml", "image.width", "expected a number"},
    {"WidthIsText", replace("rig.toml", "width = 320", "width = \"320\""), "rig.toml", "image.width",
     "number"},
    {"WidthIsFractional", replace("rig.toml", "width = 320", "width = 320.5"), "rig.toml", "image.width",
     "whole"},
    {"ImageTooLarge", replace("rig.toml", "width = 320", "width = 4000"), "rig.toml", "image.width", "1280"},
    {"FocalLengthZero", replace("rig.toml", "fx = 400.0", "fx = 0"), "rig.toml", "left.fx", "must lie in"},
    {"FocalLengthNan", replace("rig.toml", "fy = 400.0", "fy = nan"), "rig.toml", "left.fy", "finite"},
    {"CentreInfinite", replace("rig.toml", "cx = 159.5", "cx = inf"), "rig.toml", "left.cx", "finite"},
    {"CameraPoseShort", replace("rig.toml", " 0,0,0,1]", "]"), "rig.toml", "left.T_H_C", "16"},
    {"CameraPoseNan", replace("rig.toml", "-60", "nan"), "rig.toml", "left.T_H_C", "finite"},
    {"CameraPoseSkewed", replace("rig.toml", "0,1,0,0,", "0,1.5,0,0,"), "rig.toml", "left.T_H_C", "rotation"},
    {"CameraPoseMirrored", replace("rig.toml", "0,1,0,0,", "0,-1,0,0,"), "rig.toml", "left.T_H_C",
     "rotation"},
    {"DistortionShort", replace("rig.toml", "fy = 400.0", "fy = 400\ndistortion = [0.1]"), "rig.toml",
     "left.distortion", "5"},
    {"KindUnknown", replace("model/model.toml", "\"photo\"", "\"cube\""), "model.toml", "kind", "marker"},
    {"RoiOutside", replace("model/model.toml", "[110, 80, 100", "[250, 80, 100"), "model.toml", "photo.roi",
     "320 x 240"},
    {"RoiEmpty", replace("model/model.toml", "[110, 80, 100", "[110, 80, 0"), "model.toml", "photo.roi"},
    {"RoiFractional", replace("model/model.toml", "[110, 80,", "[110.5, 80,"), "model.toml", "photo.roi"},
    {"DistanceNegative", replace("model/model.toml", "= 400.0\n[", "= -1\n["), "model.toml",
     "photo.distance_mm"},
    {"NoCamera", replace("model/model.toml", "[camera]", "[kamera]"), "model.toml", "camera"},
    {"NoBackground", replace("model/model.toml", "background = \"background.png\"", ""), "model.toml",
     "photo.background", "background_hue_deg"},
    {"BackgroundGrey", write_image("model/background.png", 320, 240, 120), "background.png", "no hue",
     "background_hue_deg"},
    {"PhotoGrey", write_image("model/photo.png", 320, 240, 120), "model.toml", "photo", "colour"},
    {"PhotoDamaged", truncate("model/photo.png"), "photo.png", "PNG"},
    {"MaskOfOtherSize",
     [](const path& dataset) {
       write_image("model/mask.png", 32, 24, 255)(dataset);
       replace_in_file(dataset / "model/model.toml", "[photo]", "[photo]\nmask = \"mask.png\"");
     },
     "mask.png", "size of the photo"},
    {"MaskEmpty",
     [](const path& dataset) {
       write_image("model/mask.png", 320, 240, 0)(dataset);
       replace_in_file(dataset / "model/model.toml", "[photo]", "[photo]\nmask = \"mask.png\"");
     },
     "mask.png", "no pixel"},
    {"BoxEmpty", replace("search.toml", "[100, 100, 120", "[100, 0, 120"), "search.toml", "half_range",
     "above 0"},
    {"BoxNan", replace("search.toml", "[0, 0, 500", "[0, nan, 500"), "search.toml", "centre", "finite"},
    {"BoxShort", replace("search.toml", "[0, 0, 500,", "[0, 500,"), "search.toml", "centre", "6"},
    {"BoxBeyondUnitBall", replace("search.toml", "500, 0, 0, 0]", "500, 0, 2, 0]"), "search.toml", "centre"},
    {"FrameMissingRight", remove("right/000001.png"), "right/000001.png", "missing", "2 right"},
    {"FrameMissingLeft", remove("left/000002.png"), "left/000002.png", "missing", "2 left"},
    {"FrameNoPng", write("left/000000.png", "this is text"), "left/000000.png", "PNG"},
    {"FrameTruncated", truncate("right/000001.png"), "right/000001.png", "PNG"},
    {"FrameOfOtherSize", write_image("right/000000.png", 64, 48, 99), "right/000000.png", "64 x 48",
     "320 x 240"},
    {"TruthWithOtherColumns", replace("truth.csv", "x_mm", "x_m"), "truth.csv", "header",
     "expected frame,x_mm"},
    {"TruthRowShort", write("truth.csv", "frame,x_mm,y_mm,z_mm,e1,e2,e3\n0,1,2\n"), "truth.csv", "line 2"},
    {"TruthNan", write("truth.csv", "frame,x_mm,y_mm,z_mm,e1,e2,e3\n0,1,2,nan,0,0,0\n"), "truth.csv",
     "line 2: z_mm", "finite"},
    {"TruthFrameTwice", write("truth.csv", "frame,x_mm,y_mm,z_mm,e1,e2,e3\n0,1,2,3,0,0,0\n0,1,2,3,0,0,0\n"),
     "truth.csv", "line 3: frame", "twice"},
    {"TruthNoQuaternion", write("truth.csv", "frame,x_mm,y_mm,z_mm,e1,e2,e3\n0,1,2,3,0.9,0.9,0\n"),
     "truth.csv", "line 2", "length"},
    {"TruthEmpty", write("truth.csv", ""), "truth.csv", "empty", "header"},
    {"MotionWithoutAFrame", write("motion.csv", kMotionHeader + std::string("0,0,0,0,0,0,0,0,0,0\n")),
     "motion.csv", "frame 1"},
    {"MotionInDegrees", write("motion.csv", kMotionHeader + std::string("0,0,0,0,0,0,0,0,15,0\n")),
     "motion.csv", "pan_right_rad", "rad"},
    {"MotionWithOtherColumns", write("motion.csv", "frame,x_mm\n0,1\n"), "motion.csv", "header", "tilt_rad"},
};

class BadDataset : public testing::TestWithParam<Breakage> {};

TEST_P(BadDataset, EndsWithStatusTwoAndNamesIt) {
  const TempDirectory directory;
  write_small_photo_dataset(directory.path());
  GetParam().break_it(directory.path());
  expect_refusal("estimate " + directory.path().string(), GetParam().file, GetParam().field,
                 GetParam().remedy);
}

INSTANTIATE_TEST_SUITE_P(Cases, BadDataset, testing::ValuesIn(kBreakages),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(BadMarker, EndsWithStatusTwoAndNamesIt) {
  const TempDirectory directory;
  write_small_marker_dataset(directory.path());
  const std::string estimate = "estimate " + directory.path().string();
  replace_in_file(directory / "model/model.toml", "radius_mm = 20.0", "radius_mm = 0");
  expect_refusal(estimate, "model.toml", "ball[0].radius_mm");
  write_file(directory / "model/model.toml", "kind = \"marker\"\n");
  expect_refusal(estimate, "model.toml", "ball");
  std::string many = "kind = \"marker\"\n";
  for (int i = 0; i < 9; ++i) many += "[[ball]]\ncentre_mm = [0, 0, 0]\nradius_mm = 9\nhue_deg = 0\n";
  write_file(directory / "model/model.toml", many);
  expect_refusal(estimate, "model.toml", "ball", "at most 8");
}

TEST(BadUsage, EndsWithStatusTwoAndNamesTheOption) {
  const TempDirectory directory;
  write_small_marker_dataset(directory.path());
  const std::string dataset = directory.path().string();
  expect_refusal("");
  expect_refusal("estimat " + dataset);
  expect_refusal("estimate", "DIR");
  expect_refusal("estimate " + dataset + "-not", "no such data set");
  expect_refusal("estimate " + dataset + " --frames 3:1", "--frames", "3:1");
  expect_refusal("estimate " + dataset + " --frames x", "--frames");
  expect_refusal("estimate " + dataset + " --frames 5:9", "5:9", "0 to 2");
  expect_refusal("estimate " + dataset + " --generations -1", "--generations");
  expect_refusal("estimate " + dataset + " --budget-ms 0", "--budget-ms");
  expect_refusal("estimate " + dataset + " --budget-ms nan", "--budget-ms");
  expect_refusal("estimate " + dataset + " --seed -1", "--seed");
  expect_refusal("estimate " + dataset + " --set-mutation 1.5", "--set-mutation", "[0, 1]");
  expect_refusal("estimate " + dataset + " --method magic", "--method", "thesis");
  expect_refusal("estimate " + dataset + " --json " + dataset + "/no/such/folder.json", "folder.json");
  expect_refusal("estimate " + dataset + " --overlay " + dataset + "/rig.toml", "rig.toml");
  const std::string map = "fitness-map " + dataset + " --frame ";
  expect_refusal(map + "9 --axes x,z --step 10", "--frame", "0 to 2");
  expect_refusal(map + "0 --axes x,w --step 10", "--axes", "'w'");
  expect_refusal(map + "0 --axes x,x --step 10", "--axes");
  expect_refusal(map + "0 --axes x,z --step 0", "--step");
  expect_refusal(map + "0 --axes x,z --step nan", "--step");
  expect_refusal(map + "0 --axes x,z --step 1e-5", "--step", "4001");
  expect_refusal(map + "0 --axes x,z --step 10 --range x=5:1", "--range");
  expect_refusal(map + "0 --axes x,z --step 10 --at 1,2,3", "--at", "6 numbers");
}

}  // namespace
}  // namespace vergence::test
