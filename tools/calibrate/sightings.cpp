#include "tools/calibrate/sightings.hpp"

#include <optional>

#include "algo/limits.hpp"
#include "tools/calibrate/find_corners.hpp"
#include "tools/calibrate/picture_file.hpp"
#include "tools/io/input_error.hpp"

namespace vergence::calibrate {
namespace {

using tools::InputError;

std::string size_text(int width, int height) {
  return std::to_string(width) + " x " + std::to_string(height);
}

void require_size(const std::filesystem::path& file, const tools::GreyImage& image,
                  const Sightings& sightings, const std::filesystem::path& first) {
  if (image.width_px > kMaxImageWidth || image.height_px > kMaxImageHeight) {
    throw InputError(file, "size",
                     "is " + size_text(image.width_px, image.height_px) + " but at most " +
                         size_text(kMaxImageWidth, kMaxImageHeight) + " is possible",
                     "set the cameras to the format they will work in, and take the pictures anew");
  }
  if (image.width_px == sightings.width_px && image.height_px == sightings.height_px) return;
  throw InputError(file, "size",
                   "is " + size_text(image.width_px, image.height_px) + " but " + first.string() + " is " +
                       size_text(sightings.width_px, sightings.height_px),
                   "all pictures of both cameras must have one size");
}

}  // namespace

Sightings find_board(const std::vector<PicturePair>& pairs, const Board& board,
                     const std::function<void()>& after_pair) {
  Sightings sightings;
  for (const PicturePair& pair : pairs) {
    Sighting sighting{pair, {}};
    bool found = true;
    Vector2 direction{1, 0};
    for (std::size_t side = 0; side < 2; ++side) {
      const std::filesystem::path& file = pair.files[side];
      const tools::GreyImage image = read_picture(file);
      if (sightings.width_px == 0) {
        sightings.width_px = image.width_px;
        sightings.height_px = image.height_px;
      }
      require_size(file, image, sightings, pairs.front().files[0]);
      std::optional<Corners> corners = find_corners(image, board, direction);
      if (!corners) {
        found = false;
        sightings.skipped.push_back(file.string() + ": the board is not found");
        continue;
      }
      direction = row_direction(*corners, board).normalized();
      sighting.corners[side] = std::move(*corners);
    }
    if (found) sightings.seen.push_back(std::move(sighting));
    after_pair();
  }
  if (sightings.seen.empty()) {
    throw InputError(
        pairs.front().files[0].parent_path(), "--board",
        "no pair shows all " + std::to_string(board.columns) + " x " + std::to_string(board.rows) +
            " inner corners in both pictures",
        "count the inner corners, not the squares; keep the whole board with a white margin in both "
        "pictures, sharp and evenly lit");
  }
  return sightings;
}

}  // namespace vergence::calibrate
