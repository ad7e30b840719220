#include "tools/io/dataset.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <string>

#include "tools/io/csv.hpp"
#include "tools/io/input_error.hpp"
#include "tools/io/toml_reader.hpp"
#include "tools/photo_model/find_target.hpp"

namespace vergence::tools {
namespace {

// What no camera and no target exceeds; within it, nothing overflows later.
constexpr Range kFocalLength_px{1, 1e6};
constexpr Range kLength_mm{1e-3, 1e6};
constexpr Range kWithin1e6{-1e6, 1e6};

Transform rigid_transform(const TomlReader& table, std::string_view key) {
  const std::vector<double> m = table.numbers(key, 16);
  Transform T;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column)
      T.R(row, column) = m[static_cast<std::size_t>(4 * row + column)];
    T.t_mm[row] = m[static_cast<std::size_t>(4 * row + 3)];
  }
  const bool last_row = m[12] == 0 && m[13] == 0 && m[14] == 0 && m[15] == 1;
  const double skew = (T.R * T.R.transpose() - Matrix3::Identity()).norm();
  if (!last_row || !(skew < 1e-3) || T.R.determinant() < 0) {
    table.fail(key, "is not a rigid transform",
               "a row-major 4x4 matrix: a rotation, a translation in mm, and the last row 0 0 0 1");
  }
  // What was rounded in the file becomes an exact rotation.
  T.R = rotation_from_quaternion_vector(quaternion_vector_from_rotation(T.R));
  return T;
}

CameraModel read_intrinsics(const TomlReader& table) {
  CameraModel camera;
  camera.fx_px = table.number("fx", kFocalLength_px);
  camera.fy_px = table.number("fy", kFocalLength_px);
  camera.cx_px = table.number("cx", kWithin1e6);
  camera.cy_px = table.number("cy", kWithin1e6);
  if (table.has("distortion")) {
    const auto k = table.numbers("distortion", 5);
    std::copy(k.begin(), k.end(), camera.distortion.begin());
  }
  return camera;
}

std::vector<Frame> list_frames(const std::filesystem::path& directory) {
  const auto numbers = [&](const char* side) {
    const std::filesystem::path folder = directory / side;
    std::error_code error;
    std::set<int> found;
    for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
      const std::filesystem::path& path = entry.path();
      const std::string stem = path.stem().string();
      if (path.extension() != ".png" || stem.size() != 6 ||
          stem.find_first_not_of("0123456789") != std::string::npos) {
        continue;
      }
      found.insert(std::stoi(stem));
    }
    if (error)
      throw InputError(folder, "", "no such folder", "expected left/000000.png, right/000000.png, ...");
    if (found.empty())
      throw InputError(folder, "", "holds no images", "expected six digits and .png: 000000.png");
    return found;
  };
  const std::set<int> left = numbers("left");
  const std::set<int> right = numbers("right");
  const auto path = [&](const char* side, int number) {
    std::string name = std::to_string(number);
    name.insert(0, 6 - name.size(), '0');
    return directory / side / (name + ".png");
  };
  std::vector<Frame> frames;
  for (const int number : left) {
    if (right.count(number) == 0) {
      throw InputError(path("right", number), "", "missing",
                       "the left image of that frame is there: " + std::to_string(left.size()) +
                           " left images, " + std::to_string(right.size()) + " right");
    }
    frames.push_back({number, path("left", number), path("right", number)});
  }
  for (const int number : right) {
    if (left.count(number) == 0) {
      throw InputError(path("left", number), "", "missing",
                       "the right image of that frame is there: " + std::to_string(left.size()) +
                           " left images, " + std::to_string(right.size()) + " right");
    }
  }
  return frames;
}

// A pose from six columns starting at `first`.
Pose pose_of(const std::filesystem::path& file, const Csv& csv, const CsvRow& row, std::size_t first) {
  Pose pose;
  for (int i = 0; i < 3; ++i) {
    pose.position_mm[i] = row.values[first + static_cast<std::size_t>(i)];
    pose.e[i] = row.values[first + 3 + static_cast<std::size_t>(i)];
  }
  if (!is_valid(pose)) {
    throw InputError(file, "line " + std::to_string(row.line) + ": " + csv.columns[first + 3],
                     "e1, e2, e3 are no part of a unit quaternion", "their length must be at most 1");
  }
  return pose;
}

void expect_columns(const std::filesystem::path& file, const Csv& csv,
                    const std::vector<std::string>& columns) {
  if (csv.columns == columns) return;
  std::string wanted;
  for (const auto& column : columns) wanted += (wanted.empty() ? "" : ",") + column;
  throw InputError(file, "header", "has other columns", "expected " + wanted);
}

int frame_of(const std::filesystem::path& file, const CsvRow& row, std::set<int>& seen) {
  const double value = row.values[0];
  const std::string where = "line " + std::to_string(row.line) + ": frame";
  if (value != std::floor(value) || value < 0 || value > 999999)
    throw InputError(file, where, "is not a frame number", "0 to 999999, whole");
  const int frame = static_cast<int>(value);
  if (!seen.insert(frame).second) throw InputError(file, where, "appears twice", "one row a frame");
  return frame;
}

std::map<int, Truth> read_truth(const std::filesystem::path& file) {
  std::map<int, Truth> truth;
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored)) return truth;
  const Csv csv = read_csv(file);
  const bool timed = csv.columns.size() > 1 && csv.columns[1] == "t_s";
  std::vector<std::string> columns{"frame", "x_mm", "y_mm", "z_mm", "e1", "e2", "e3"};
  if (timed) columns.insert(columns.begin() + 1, "t_s");
  expect_columns(file, csv, columns);
  std::set<int> seen;
  for (const CsvRow& row : csv.rows) {
    const int frame = frame_of(file, row, seen);
    truth[frame] = {timed ? row.values[1] : frame / 30.0, pose_of(file, csv, row, timed ? 2 : 1)};
  }
  return truth;
}

std::map<int, HandMotion> read_motion(const std::filesystem::path& file, const std::vector<Frame>& frames) {
  std::map<int, HandMotion> motion;
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored)) return motion;
  const Csv csv = read_csv(file);
  expect_columns(
      file, csv,
      {"frame", "x_mm", "y_mm", "z_mm", "e1", "e2", "e3", "tilt_rad", "pan_right_rad", "pan_left_rad"});
  std::set<int> seen;
  for (const CsvRow& row : csv.rows) {
    const int frame = frame_of(file, row, seen);
    for (std::size_t i = 7; i < 10; ++i) {
      if (std::abs(row.values[i]) > std::numbers::pi) {
        throw InputError(file, "line " + std::to_string(row.line) + ": " + csv.columns[i],
                         "is beyond half a turn", "angles are in rad");
      }
    }
    motion[frame] = {pose_of(file, csv, row, 1), {row.values[7], row.values[8], row.values[9]}};
  }
  for (const Frame& frame : frames) {
    if (motion.count(frame.number) == 0) {
      throw InputError(file, "frame", "no row for frame " + std::to_string(frame.number),
                       "one row for every frame that has images");
    }
  }
  return motion;
}

Rectangle read_roi(const TomlReader& photo, const RgbImage& image) {
  const auto r = photo.numbers("roi", 4);
  for (const double value : r) {
    if (value != std::floor(value) || std::abs(value) > 1e6)
      photo.fail("roi", "must hold whole pixels", "[x, y, width, height]");
  }
  const Rectangle roi{static_cast<int>(r[0]), static_cast<int>(r[1]), static_cast<int>(r[2]),
                      static_cast<int>(r[3])};
  if (roi.width < 2 || roi.height < 2 || roi.x < 0 || roi.y < 0 || roi.x + roi.width > image.width_px ||
      roi.y + roi.height > image.height_px) {
    photo.fail("roi", "reaches outside the photo, or is empty",
               "[x, y, width, height] within " + std::to_string(image.width_px) + " x " +
                   std::to_string(image.height_px));
  }
  return roi;
}

bool marks_anything(const GreyImage& mask, const Rectangle& roi) {
  for (int y = roi.y; y < roi.y + roi.height; ++y) {
    const auto row = mask.data.begin() + std::ptrdiff_t{y} * mask.width_px + roi.x;
    if (std::any_of(row, row + roi.width, [](std::uint8_t value) { return value != 0; })) return true;
  }
  return false;
}

Target read_photo_target(const std::filesystem::path& directory, const TomlReader& root) {
  Target target;
  target.kind = TargetKind::kPhoto;
  const TomlReader photo = root.table("photo");
  target.photo = read_png_rgb(directory / photo.text("image"));
  target.roi = read_roi(photo, target.photo);
  target.distance_mm = photo.number("distance_mm", kLength_mm);
  target.camera = read_intrinsics(root.table("camera"));
  if (photo.has("mask")) {
    const std::filesystem::path file = directory / photo.text("mask");
    target.mask = read_png_grey(file);
    if (target.mask->width_px != target.photo.width_px || target.mask->height_px != target.photo.height_px) {
      throw InputError(file, "", "is not the size of the photo",
                       "one pixel of the mask for each of the photo");
    }
    if (!marks_anything(*target.mask, target.roi)) {
      throw InputError(file, "", "marks no pixel of the photo's roi", "non-zero is the target");
    }
  }
  if (photo.has("background_hue_deg")) {
    target.background_hue_deg = photo.number("background_hue_deg", {-360, 360});
    if (!target.mask) {
      target.silhouette = silhouette_before_plain(target.background_hue_deg, target.photo, target.roi);
    }
  } else if (photo.has("background")) {
    const std::filesystem::path file = directory / photo.text("background");
    const RgbImage background = read_png_rgb(file);
    const auto hue = mean_hue_deg(background);
    if (!hue) {
      throw InputError(file, "", "the background has no hue",
                       "take it against a coloured background, or give photo.background_hue_deg");
    }
    target.background_hue_deg = *hue;
    if (!target.mask) target.silhouette = silhouette_before(background, target.photo, target.roi);
  } else {
    photo.fail("background", "missing", "give background = \"FILE.png\" or background_hue_deg");
  }
  if (target.mask) target.silhouette = with_rim(*target.mask, target.roi);
  return target;
}

Target read_marker_target(const TomlReader& root) {
  Target target;
  target.kind = TargetKind::kMarker;
  for (const TomlReader& table : root.tables("ball")) {
    Ball ball;
    const auto centre = table.numbers("centre_mm", 3);
    ball.centre_mm = {centre[0], centre[1], centre[2]};
    ball.radius_mm = table.number("radius_mm", kLength_mm);
    ball.hue_deg = table.number("hue_deg", {-360, 360});
    ball.tolerance_deg = table.number_or("tolerance_deg", 20, {0.1, 179});
    target.balls.push_back(ball);
  }
  if (target.balls.size() > kMaxBalls) {
    root.fail("ball", "there are " + std::to_string(target.balls.size()) + " balls",
              "at most " + std::to_string(kMaxBalls));
  }
  return target;
}

}  // namespace

PhotoSource Target::source(TargetArea area) const {
  PhotoSource source{photo.view(), nullptr, nullptr, roi, distance_mm, camera, background_hue_deg};
  if (silhouette && area == TargetArea::kSilhouette) {
    source.mask = silhouette->with_rim.data.data();
    source.target = silhouette->target.data.data();
  } else if (mask) {
    source.mask = mask->data.data();
  }
  return source;
}

double Dataset::time_of(int frame) const {
  const auto found = truth.find(frame);
  return found == truth.end() ? frame / 30.0 : found->second.t_s;
}

FrameMotion Dataset::motion_of(int frame) const {
  FrameMotion result;
  result.t_s = time_of(frame);
  const auto found = motion.find(frame);
  const HandMotion hand = found == motion.end() ? HandMotion{} : found->second;
  result.T_W_H = to_transform(hand.T_W_H);
  result.T_H_CL = left_eye_in_hand(rig.left.T_H_C, hand.eyes);
  result.T_H_CR = right_eye_in_hand(rig.right.T_H_C, hand.eyes);
  return result;
}

StereoRig read_rig(const std::filesystem::path& file) {
  const TomlReader root = TomlReader::from_file(file);
  const TomlReader image = root.table("image");
  const int width = image.integer("width", 16, kMaxImageWidth);
  const int height = image.integer("height", 16, kMaxImageHeight);
  const auto camera = [&](std::string_view side) {
    const TomlReader table = root.table(side);
    CameraModel model = read_intrinsics(table);
    model.width_px = width;
    model.height_px = height;
    model.T_H_C = rigid_transform(table, "T_H_C");
    return model;
  };
  return {camera("left"), camera("right")};
}

Target read_target(const std::filesystem::path& model_directory) {
  const TomlReader root = TomlReader::from_file(model_directory / "model.toml");
  const std::string kind = root.text("kind");
  if (kind == "marker") return read_marker_target(root);
  if (kind != "photo") root.fail("kind", "is '" + kind + "'", "\"marker\" or \"photo\"");
  return read_photo_target(model_directory, root);
}

SearchBox read_search_box(const std::filesystem::path& file) {
  const TomlReader root = TomlReader::from_file(file);
  SearchBox box;
  const auto centre = root.numbers("centre", kGenes);
  const auto half_range = root.numbers("half_range", kGenes);
  std::copy(centre.begin(), centre.end(), box.centre.begin());
  std::copy(half_range.begin(), half_range.end(), box.half_range.begin());
  for (const double value : half_range) {
    if (!(value > 0)) root.fail("half_range", "the search box is empty", "every half range must be above 0");
  }
  if (check(box) != Status::kOk)
    root.fail("centre", "e1, e2, e3 are no part of a unit quaternion", "their length must be below 1");
  return box;
}

Dataset read_dataset(const std::filesystem::path& directory) {
  std::error_code ignored;
  if (!std::filesystem::is_directory(directory, ignored))
    throw InputError(directory, "", "no such data set directory");
  Dataset dataset;
  dataset.directory = directory;
  dataset.rig = read_rig(directory / "rig.toml");
  dataset.target = read_target(directory / "model");
  dataset.box = read_search_box(directory / "search.toml");
  dataset.frames = list_frames(directory);
  dataset.motion = read_motion(directory / "motion.csv", dataset.frames);
  dataset.truth = read_truth(directory / "truth.csv");
  return dataset;
}

std::pair<RgbImage, RgbImage> read_frame(const Dataset& dataset, const Frame& frame) {
  const auto read = [](const std::filesystem::path& file, const CameraModel& camera) {
    RgbImage image = read_png_rgb(file);
    if (image.width_px != camera.width_px || image.height_px != camera.height_px) {
      throw InputError(file, "size",
                       "is " + std::to_string(image.width_px) + " x " + std::to_string(image.height_px) +
                           " but rig.toml says " + std::to_string(camera.width_px) + " x " +
                           std::to_string(camera.height_px),
                       "set image.width and image.height to those of the pictures");
    }
    return image;
  };
  return {read(frame.left, dataset.rig.left), read(frame.right, dataset.rig.right)};
}

std::optional<double> mean_hue_deg(const RgbImage& image, const HueLimits& limits) {
  double sine = 0;
  double cosine = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i + 2 < image.data.size(); i += 3) {
    const std::uint8_t code = hue_code_rgb(image.data[i], image.data[i + 1], image.data[i + 2], limits);
    if (!is_hue(code)) continue;
    const double angle = hue_degrees(code) * std::numbers::pi / 180;
    sine += std::sin(angle);
    cosine += std::cos(angle);
    ++count;
  }
  if (count * 300 < image.data.size() || std::hypot(sine, cosine) < 1e-3 * static_cast<double>(count))
    return {};
  const double angle = std::atan2(sine, cosine) * 180 / std::numbers::pi;
  return angle < 0 ? angle + 360 : angle;
}

void build_model(const Dataset& dataset, const MarkerOptions& options, MarkerModel& model) {
  const auto& balls = dataset.target.balls;
  if (const Status status = build_marker_model(balls.data(), static_cast<int>(balls.size()), options, model);
      status != Status::kOk) {
    throw InputError(dataset.directory / "model" / "model.toml", "ball", describe(status));
  }
}

void build_model(const Dataset& dataset, const PhotoOptions& options, const HueLimits& limits,
                 PhotoModel& model, TargetArea area) {
  const Status status = build_photo_model(dataset.target.source(area), options, limits, model);
  if (status == Status::kOk) return;
  const char* remedy = status == Status::kNoHue ? "use a photo in colour, of a coloured target" : "";
  throw InputError(dataset.directory / "model" / "model.toml", "photo", describe(status), remedy);
}

}  // namespace vergence::tools
