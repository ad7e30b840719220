// `vergence model`: a photo-model from a photo of the target and one of the bare background.
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "tools/cli/commands.hpp"
#include "tools/cli/options.hpp"
#include "tools/cli/parse_numbers.hpp"
#include "tools/draw/overlay.hpp"
#include "tools/io/dataset.hpp"
#include "tools/io/input_error.hpp"
#include "tools/io/writable.hpp"
#include "tools/photo_model/find_target.hpp"
#include "tools/photo_model/write_model.hpp"

namespace vergence::tools {
namespace {

struct Options {
  std::filesystem::path photo;
  std::filesystem::path background;
  std::filesystem::path out;
  double distance_mm = 400;
  std::optional<double> fx;
  std::optional<double> fy;
  std::optional<double> cx;
  std::optional<double> cy;
  std::string roi;
  std::filesystem::path mask;
};

// Of 640 pixels' width; the usual one of the method's cameras.
constexpr double kUsualFocalLength_px = 800;

CameraModel camera_of(const Options& options, const RgbImage& photo) {
  CameraModel camera;
  camera.width_px = photo.width_px;
  camera.height_px = photo.height_px;
  camera.fx_px = options.fx.value_or(kUsualFocalLength_px * photo.width_px / 640);
  camera.fy_px = options.fy.value_or(camera.fx_px);
  camera.cx_px = options.cx.value_or(0.5 * (photo.width_px - 1));
  camera.cy_px = options.cy.value_or(0.5 * (photo.height_px - 1));
  return camera;
}

void require_same_size(const std::filesystem::path& file, int width, int height, const RgbImage& photo) {
  if (width == photo.width_px && height == photo.height_px) return;
  throw InputError(file, "size",
                   "is " + std::to_string(width) + " x " + std::to_string(height) + " but the photo is " +
                       std::to_string(photo.width_px) + " x " + std::to_string(photo.height_px),
                   "take both with one camera that does not move between");
}

Rectangle parse_roi(const Options& options, const RgbImage& photo) {
  const auto n = parse_numbers("--roi", options.roi, ',', 4);
  const bool fits = n[0] >= 0 && n[1] >= 0 && n[2] >= 2 && n[3] >= 2 && n[0] + n[2] <= photo.width_px &&
                    n[1] + n[3] <= photo.height_px;
  for (const double value : n) {
    if (!fits || value != std::floor(value)) {
      throw InputError(options.photo, "--roi",
                       options.roi + " is not a rectangle of whole pixels in the photo",
                       "x,y,width,height within " + std::to_string(photo.width_px) + " x " +
                           std::to_string(photo.height_px));
    }
  }
  return {static_cast<int>(n[0]), static_cast<int>(n[1]), static_cast<int>(n[2]), static_cast<int>(n[3])};
}

FoundTarget find(const Options& options, const RgbImage& photo, const RgbImage& background) {
  FoundTarget found = find_target(photo, background);
  if (found.pixels == 0) {
    throw InputError(options.photo, "",
                     "nothing stands out from the background " + options.background.string(),
                     "photograph the target in front of that background, without moving the camera; or give "
                     "--roi x,y,w,h");
  }
  if (found.touches_border) {
    throw InputError(
        options.photo, "", "what stands out from the background reaches the edge of the photo",
        "leave room around the target, keep light and camera as they were; or give --roi x,y,w,h");
  }
  std::printf("found      %d pixels in %d piece%s\n", found.pixels, found.parts, found.parts == 1 ? "" : "s");
  return found;
}

// Rectangle and mask as given, else as found.
void locate(const Options& options, const RgbImage& background, Target& target) {
  if (!options.mask.empty()) {
    target.mask = read_png_grey(options.mask);
    require_same_size(options.mask, target.mask->width_px, target.mask->height_px, target.photo);
    target.roi = bounding_rectangle(*target.mask);
    if (target.roi.width == 0) {
      throw InputError(options.mask, "", "the mask is empty", "make the target non-zero");
    }
  }
  if (!options.roi.empty()) {
    target.roi = parse_roi(options, target.photo);
  } else if (options.mask.empty()) {
    FoundTarget found = find(options, target.photo, background);
    target.roi = found.roi;
    target.mask = std::move(found.mask);
  }
  if (target.mask) target.silhouette = with_rim(*target.mask, target.roi);
}

double share(int part, int whole) {
  return 100.0 * part / std::max(whole, 1);
}

void print_points(const PhotoModel& model) {
  int of_target = 0;
  int with_hue = 0;
  int like_background = 0;
  const int tolerance = hue_tolerance_steps(model.votes.background_tolerance_deg);
  for (unsigned i = 0; i < static_cast<unsigned>(model.inner); ++i) {
    if (model.weight[i] == 0) continue;  // its rim
    ++of_target;
    with_hue += is_hue(model.hue[i]) ? 1 : 0;
    like_background += hue_distance(model.hue[i], model.background_hue) <= tolerance ? 1 : 0;
  }
  std::printf(
      "points     %d S_in, %d of them on the target, %d S_out; of the target's, "
      "%.0f %% have a hue, %.0f %% the background's\n",
      model.inner, of_target, model.outer, share(with_hue, of_target), share(like_background, of_target));
  if (2 * like_background > of_target) {
    std::printf(
        "warning: most of the target has the background's hue; another background would serve better\n");
  }
}

void run(const Options& options) {
  Target target;
  target.kind = TargetKind::kPhoto;
  target.photo = read_png_rgb(options.photo);
  const RgbImage background = read_png_rgb(options.background);
  require_same_size(options.background, background.width_px, background.height_px, target.photo);
  target.distance_mm = options.distance_mm;
  target.camera = camera_of(options, target.photo);
  const auto hue = mean_hue_deg(background);
  if (!hue) {
    throw InputError(options.background, "", "the background has no hue",
                     "photograph the target before a background that is neither grey, black nor white");
  }
  target.background_hue_deg = *hue;

  locate(options, background, target);
  const Rectangle& roi = target.roi;
  std::printf("rectangle  x %d, y %d, %d x %d px; %.1f x %.1f mm at %.0f mm\n", roi.x, roi.y, roi.width,
              roi.height, roi.width * target.distance_mm / target.camera.fx_px,
              roi.height * target.distance_mm / target.camera.fy_px, target.distance_mm);
  std::printf("camera     fx %.1f, fy %.1f px%s\n", target.camera.fx_px, target.camera.fy_px,
              options.fx ? "" : " (assumed; --fx sets it, and with it the size of the model)");
  std::printf("background hue %.1f deg\n", target.background_hue_deg);

  const auto model = std::make_unique<PhotoModel>();
  const HueLimits limits = default_settings(Method::kVergence, TargetKind::kPhoto).hue_limits;
  if (const Status status = build_photo_model(target.source(), {}, limits, *model); status != Status::kOk) {
    throw InputError(options.photo, "", describe(status),
                     status == Status::kNoHue ? "use a photo in colour, of a coloured target" : "");
  }
  print_points(*model);

  make_directory(options.out);
  write_photo_model(options.out, target, background);
  write_png(options.out / "preview.png", draw_photo_model(target.photo, target.source(), *model));
  std::printf("written    %s: look at preview.png\n", options.out.c_str());
}

}  // namespace

void add_model_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("model", "Make a photo-model from a photo and a bare background");
  const auto options = std::make_shared<Options>();
  command->add_option("PHOTO", options->photo, "PNG of the target, seen straight on")->required();
  command->add_option("--background", options->background, "PNG of the same view without the target")
      ->type_name("BG")
      ->required();
  command->add_option("-o,--out", options->out, "Directory to write: a data set's model/")
      ->type_name("DIR")
      ->required();
  command->add_option("--distance-mm", options->distance_mm, "Camera to the plane of the target")
      ->type_name("D")
      ->check(within(1.0, 1e6))
      ->capture_default_str();
  const auto intrinsic = [&](const char* name, std::optional<double>& value, const char* text) {
    return command->add_option(name, value, text)->type_name("PX")->group("Camera that took the photo");
  };
  intrinsic("--fx", options->fx, "Default: 800 for 640 pixels' width")->check(within(1.0, 1e6));
  intrinsic("--fy", options->fy, "Default: as fx")->check(within(1.0, 1e6));
  intrinsic("--cx", options->cx, "Default: the middle")->check(within(-1e6, 1e6));
  intrinsic("--cy", options->cy, "Default: the middle")->check(within(-1e6, 1e6));
  command
      ->add_option("--roi", options->roi, "All of this rectangle is the target (or what --mask marks in it)")
      ->type_name("X,Y,W,H");
  command->add_option("--mask", options->mask, "PNG, non-zero on the target")->type_name("FILE");
  command->footer(
      "Writes model.toml, photo.png, background.png, mask.png, and preview.png: the points S_in (in their "
      "hues) and\n"
      "S_out (white) over the photo.\n"
      "\nExample:\n"
      "  vergence model crab.png --background table.png --distance-mm 400 --fx 812.4 -o lab/crab/model");
  command->callback([options] { run(*options); });
}

}  // namespace vergence::tools
