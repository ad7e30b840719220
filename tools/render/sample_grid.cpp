#include "tools/render/sample_grid.hpp"

#include <bit>

namespace vergence::render {
namespace {

struct Offset {
  double x;
  double y;
};

// Of the spans samples are tried in, px or rows: more than rounding can do.
constexpr double kSlack = 1e-3;

// In sixteenths of a pixel from its centre.
constexpr std::array<Offset, 4> kRotatedGrid{{{-2, -6}, {6, -2}, {-6, 2}, {2, 6}}};
constexpr std::array<Offset, 8> kEightRooks{
    {{1, -3}, {-1, 3}, {5, 1}, {-3, -5}, {-5, 5}, {-7, -1}, {3, 7}, {7, -7}}};
constexpr std::array<Offset, 16> kSixteen{{{1, 1},
                                           {-1, -3},
                                           {-3, 2},
                                           {4, -1},
                                           {-5, -2},
                                           {2, 5},
                                           {5, 3},
                                           {3, -5},
                                           {-2, 6},
                                           {0, -7},
                                           {-4, -6},
                                           {-6, 4},
                                           {-8, 0},
                                           {7, -4},
                                           {6, 7},
                                           {-7, -8}}};

std::vector<Offset> offsets(Sampling sampling) {
  std::vector<Offset> result;
  switch (sampling) {
    case Sampling::k4: result.assign(kRotatedGrid.begin(), kRotatedGrid.end()); break;
    case Sampling::k8: result.assign(kEightRooks.begin(), kEightRooks.end()); break;
    case Sampling::k16: result.assign(kSixteen.begin(), kSixteen.end()); break;
  }
  Offset mean{0, 0};
  for (Offset& o : result) {
    o = {o.x / 16, o.y / 16};
    mean = {mean.x + o.x / static_cast<double>(result.size()),
            mean.y + o.y / static_cast<double>(result.size())};
  }
  for (Offset& o : result) o = {o.x - mean.x, o.y - mean.y};
  return result;
}

}  // namespace

void SampleGrid::start(int x0, int y0, int x1, int y1, Sampling sampling) {
  x0_ = x0;
  y0_ = y0;
  x1_ = std::max(x0, x1);
  y1_ = std::max(y0, y1);
  low_x_ = x0_ - 1;
  low_y_ = y0_ - 1;
  high_x_ = x1_;
  high_y_ = y1_;
  const std::vector<Offset> chosen = offsets(sampling);
  samples_ = chosen.size();
  shift_ = std::countr_zero(samples_);
  for (std::size_t k = 0; k < samples_; ++k) {
    const Offset& o = chosen[k];
    rows_[k] = {o.x, o.y, 1 - kSlack - o.x, kSlack - o.x, k};
  }
  std::sort(rows_.begin(), rows_.begin() + samples_, [](const Row& a, const Row& b) { return a.y < b.y; });
  const double middle = (static_cast<double>(samples_) - 1) / 2;
  to_first_row_ = middle + 1 - kSlack;
  to_last_row_ = middle + kSlack;
  const auto height = static_cast<std::size_t>(y1_ - y0_);
  stride_ = static_cast<std::size_t>(x1_ - x0_) * samples_;
  const std::size_t size = stride_ * height;
  if (inverse_depth_.size() < size) {
    inverse_depth_.resize(size);
    seen_.resize(size);
  }
  drawn_.assign(height, {x1_, x0_});
}

void SampleGrid::resolve(LinearImage& image, Visibility* visibility) {
  const std::size_t n = samples_;
  const float share = 1 / static_cast<float>(n);
  for (int y = y0_; y < y1_; ++y) {
    const Span& drawn = drawn_[static_cast<std::size_t>(y - y0_)];
    if (drawn.from >= drawn.to) continue;
    std::size_t at = index(drawn.from, y);
    for (int x = drawn.from; x < drawn.to; ++x) {
      Rgb sum;
      std::size_t hits = 0;
      std::size_t on_target = 0;
      float depth = 0;
      for (std::size_t k = 0; k < n; ++k, ++at) {
        if (inverse_depth_[at] <= 0) continue;
        sum += seen_[at].colour;
        ++hits;
        if (!seen_[at].target) continue;
        ++on_target;
        if (visibility != nullptr) depth += 1 / inverse_depth_[at];
      }
      if (hits == 0) continue;
      Rgb& pixel = image.at(x, y);
      pixel = sum * share + pixel * (share * static_cast<float>(n - hits));
      if (visibility != nullptr && on_target > 0) {
        visibility->coverage[image.index(x, y)] = share * static_cast<float>(on_target);
        visibility->depth_mm[image.index(x, y)] = depth / static_cast<float>(on_target);
      }
    }
    std::fill(inverse_depth_.begin() + static_cast<std::ptrdiff_t>(index(drawn.from, y)),
              inverse_depth_.begin() + static_cast<std::ptrdiff_t>(at), 0.0F);
  }
}

}  // namespace vergence::render
