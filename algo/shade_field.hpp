// How a surface is lit otherwise than in its photo: a factor 1 + s on its colours that varies slowly over it,
// as where the lamp has moved and the light comes from another side. A colour p of the photo (luma, 2 cb,
// 2 cr, centred) then looks like p + s (p + black), black being how far below the centre black is.
//
// s is bilinear between the nodes of a square grid. A node's is what explains the residuals r of the points
// around it best, sum(w b r) / (sum(w b b) + stiffness): a least-squares fit to those points alone, with a
// prior that nothing has changed.
#pragma once

#include <array>
#include <cstdint>

#include "algo/limits.hpp"

namespace vergence {

class ShadeField {
 public:
  // Lays the grid over the first `points` points of a model (kMaxReliefPoints at most), as the photo shows
  // them.
  void start(const float* x_mm, const float* y_mm, int points);

  // A fit: reset, then add residuals of points, then solve.
  void reset();
  // That colours of point i, `photo`, leave the `residual` after gain and offset, weighted.
  void add(int i, const std::array<float, 4>& photo, double gain, const std::array<double, 3>& residual,
           double weight);
  // The stiffness is in the unit of the sums: a squared colour.
  void solve(double stiffness);

  [[nodiscard]] double shade(int i) const;  // s
  // The photo's colour as it looks in this light.
  [[nodiscard]] std::array<float, 4> relit(int i, const std::array<float, 4>& photo) const;

 private:
  static constexpr int kCells = 14;  // a side: a claw or a fin has some
  static constexpr int kNodes = kCells + 1;

  std::array<std::uint8_t, kMaxReliefPoints> node_{};           // upper left of a point's cell
  std::array<std::array<float, 4>, kMaxReliefPoints> share_{};  // of its four nodes
  std::array<double, kNodes * kNodes> pull_{};
  std::array<double, kNodes * kNodes> hold_{};
  std::array<double, kNodes * kNodes> shade_{};
};

}  // namespace vergence
