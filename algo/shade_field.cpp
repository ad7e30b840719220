#include "algo/shade_field.hpp"

#include "algo/relief_parts.hpp"

namespace vergence {
namespace {

constexpr float kBlack = 128;      // below the centre of luma
constexpr double kMaxShade = 0.5;  // either way

}  // namespace

void ShadeField::start(const float* x_mm, const float* y_mm, int points) {
  float left = x_mm[0];
  float right = left;
  float top = y_mm[0];
  float bottom = top;
  for (int i = 1; i < points; ++i) {
    left = x_mm[i] < left ? x_mm[i] : left;
    right = x_mm[i] > right ? x_mm[i] : right;
    top = y_mm[i] < top ? y_mm[i] : top;
    bottom = y_mm[i] > bottom ? y_mm[i] : bottom;
  }
  const float width = right - left;
  const float height = bottom - top;
  const float side = (width > height ? width : height) / kCells;
  const float per_mm = side > 0 ? 1 / side : 0;
  const auto cell_of = [](float position) {
    const int cell = static_cast<int>(position);
    return cell < kCells ? cell : kCells - 1;
  };
  for (int i = 0; i < points; ++i) {
    const float across = (x_mm[i] - left) * per_mm;
    const float down = (y_mm[i] - top) * per_mm;
    const int column = cell_of(across);
    const int row = cell_of(down);
    const float fx = across - static_cast<float>(column);
    const float fy = down - static_cast<float>(row);
    node_[at(i)] = static_cast<std::uint8_t>(row * kNodes + column);
    share_[at(i)] = {(1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy};
  }
  shade_.fill(0);
}

void ShadeField::reset() {
  pull_.fill(0);
  hold_.fill(0);
}

void ShadeField::add(int i, const std::array<float, 4>& photo, double gain,
                     const std::array<double, 3>& residual, double weight) {
  double br = 0;
  double bb = 0;
  for (unsigned c = 0; c < 3; ++c) {
    const double b = gain * static_cast<double>(c == 0 ? photo[c] + kBlack : photo[c]);
    br += b * residual[c];
    bb += b * b;
  }
  const unsigned first = node_[at(i)];
  for (unsigned k = 0; k < 4; ++k) {
    const unsigned node = first + k % 2 + k / 2 * kNodes;
    const double share = weight * static_cast<double>(share_[at(i)][k]);
    pull_[node] += share * br;
    hold_[node] += share * bb;
  }
}

void ShadeField::solve(double stiffness) {
  for (unsigned node = 0; node < shade_.size(); ++node) {
    shade_[node] = clamped(pull_[node] / (hold_[node] + stiffness), -kMaxShade, kMaxShade);
  }
}

double ShadeField::shade(int i) const {
  const unsigned first = node_[at(i)];
  double sum = 0;
  for (unsigned k = 0; k < 4; ++k) {
    sum += static_cast<double>(share_[at(i)][k]) * shade_[first + k % 2 + k / 2 * kNodes];
  }
  return sum;
}

std::array<float, 4> ShadeField::relit(int i, const std::array<float, 4>& photo) const {
  const auto s = static_cast<float>(shade(i));
  return {photo[0] + s * (photo[0] + kBlack), photo[1] + s * photo[1], photo[2] + s * photo[2], 0.0F};
}

}  // namespace vergence
