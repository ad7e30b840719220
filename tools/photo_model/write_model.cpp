#include "tools/photo_model/write_model.hpp"

#include <fstream>
#include <iomanip>

#include "tools/io/input_error.hpp"

namespace vergence::tools {

void write_photo_model(const std::filesystem::path& directory, const Target& target,
                       const RgbImage& background) {
  write_png(directory / "photo.png", target.photo);
  write_png(directory / "background.png", background);
  if (target.mask) write_png(directory / "mask.png", *target.mask);

  const std::filesystem::path file = directory / "model.toml";
  std::ofstream out(file);
  // Numbers with a decimal point, as TOML's floats are written.
  out << std::fixed << std::setprecision(6) << "kind = \"photo\"\n\n[photo]\nimage = \"photo.png\"\n"
      << "background = \"background.png\"\n";
  if (target.mask) out << "mask = \"mask.png\"\n";
  out << "roi = [" << target.roi.x << ", " << target.roi.y << ", " << target.roi.width << ", "
      << target.roi.height << "]  # x, y, width, height in px\n"
      << "distance_mm = " << target.distance_mm << "\n\n"
      << "[camera]  # that took the photo\n"
      << "fx = " << target.camera.fx_px << "\nfy = " << target.camera.fy_px
      << "\ncx = " << target.camera.cx_px << "\ncy = " << target.camera.cy_px << "\n";
  if (!out.flush()) throw InputError(file, "", "cannot be written");
}

}  // namespace vergence::tools
