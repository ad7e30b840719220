// Pictures of a chessboard with exact truth, for calibration: what a camera with a bent lens and noise sees
// of it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "algo/camera_model.hpp"
#include "tests/support/random.hpp"
#include "tools/calibrate/board.hpp"
#include "tools/io/image_file.hpp"

namespace vergence::test {

// Mean 0, variance 1 (the sum of twelve uniforms).
[[nodiscard]] double normal(testing::Random& random);

// A vector of three such numbers.
[[nodiscard]] Vector3 normal3(testing::Random& random);

// Paints for one camera. A pixel is a tent two pixels wide: about the blur of a lens in focus.
class ChessboardPainter {
 public:
  explicit ChessboardPainter(const CameraModel& camera);

  // `noise` is a standard deviation in levels; white is 220, black 30. The same arguments, the same picture.
  [[nodiscard]] tools::GreyImage paint(const Transform& T_C_B, const calibrate::Board& board, double noise,
                                       std::uint64_t seed) const;

 private:
  [[nodiscard]] std::size_t lattice(int x, int y) const;

  CameraModel camera_;
  std::vector<Vector3> rays_;  // of pixel centres, one row and column beyond the image on each side
};

// Two cameras of 640 x 480, 100 mm apart, turned towards each other, lenses bent as cheap ones are.
[[nodiscard]] StereoRig true_rig();

// Poses T_H_B at which both cameras see the whole board with its rim, spread over the images, tilted by 15 to
// 40 degrees in all directions.
[[nodiscard]] std::vector<Transform> board_poses(const StereoRig& rig, const calibrate::Board& board,
                                                 int count, std::uint64_t seed);

// Whether it does, in a camera.
[[nodiscard]] bool sees_board(const CameraModel& camera, const Transform& T_H_B,
                              const calibrate::Board& board);

// left/000000.png, right/000000.png and so on, one pair a pose.
void write_board_pictures(const std::filesystem::path& directory, const StereoRig& rig,
                          const std::vector<Transform>& T_H_B, const calibrate::Board& board, double noise,
                          std::uint64_t seed);

// A rotation by `degrees` about an axis of any length.
[[nodiscard]] Matrix3 turn_deg(double degrees, const Vector3& axis);

}  // namespace vergence::test
