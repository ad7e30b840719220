#include "tools/calibrate/time_offset.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <string>

#include "tools/calibrate/least_squares.hpp"
#include "tools/calibrate/pose_track.hpp"
#include "tools/calibrate/slopes.hpp"
#include "tools/io/input_error.hpp"

namespace vergence::calibrate {
namespace {

using tools::InputError;

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kScanStep_s = 0.004;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::string shown(double value, const char* pattern = "%.3g") {
  char text[48];
  std::snprintf(text, sizeof text, pattern, value);
  return text;
}

// The wandering of the target: where its mean pose in the world is in the hand at each frame, minus where it
// was seen. In the hand, because there the noise of sight has its directions; each of the six has its own
// weight.
class Wandering {
 public:
  Wandering(std::vector<TimedPose> T_H_M, const PoseTrack& hand)
      : frames_(std::move(T_H_M)), hand_(hand), use_(frames_.size(), true) {
    constexpr double kUsual_mm = 1;
    constexpr double kUsual_rad = 0.01;
    sigma_ << Vector3::Constant(kUsual_mm), Vector3::Constant(kUsual_rad);
  }

  // Weighted squares at an offset, with the mean pose that makes them least. Infinite where there is none.
  [[nodiscard]] double operator()(double offset_s) const { return fit(offset_s, nullptr); }

  // The residuals of all frames, whether used or not.
  [[nodiscard]] std::vector<Vector6> residuals(double offset_s) const {
    Transform mean;
    fit(offset_s, &mean);
    std::vector<Vector6> all;
    for (const TimedPose& frame : frames_) all.push_back(residual(frame, offset_s, mean));
    return all;
  }

  // Weights after the scatter of the residuals, and frames left out that are far from it.
  void weigh(const std::vector<Vector6>& residuals) {
    constexpr double kFar = 6;  // standard deviations
    for (Eigen::Index k = 0; k < 6; ++k) {
      std::vector<double> sizes;
      for (const Vector6& r : residuals) sizes.push_back(std::abs(r[k]));
      const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
      std::nth_element(sizes.begin(), middle, sizes.end());
      constexpr double kSigmaOverMedian = 1.4826;
      sigma_[k] = std::max(kSigmaOverMedian * *middle, k < 3 ? 1e-6 : 1e-9);
    }
    for (std::size_t i = 0; i < residuals.size(); ++i)
      use_[i] = residuals[i].cwiseQuotient(sigma_).cwiseAbs().maxCoeff() < kFar;
  }

  // Without the frames first <= i < end.
  [[nodiscard]] Wandering without(std::size_t first, std::size_t end) const {
    Wandering rest = *this;
    for (std::size_t i = first; i < end; ++i) rest.use_[i] = false;
    return rest;
  }

  [[nodiscard]] std::size_t used() const {
    return static_cast<std::size_t>(std::count(use_.begin(), use_.end(), true));
  }
  [[nodiscard]] std::size_t size() const { return frames_.size(); }
  [[nodiscard]] bool uses(std::size_t i) const { return use_[i]; }

 private:
  [[nodiscard]] Vector6 residual(const TimedPose& frame, double offset_s, const Transform& mean) const {
    const std::optional<Transform> T_W_H = hand_.at(frame.t_s + offset_s);
    if (!T_W_H) return Vector6::Constant(kInfinity);
    const Transform expected = T_W_H->inverse() * mean;
    Vector6 r;
    r << expected.t_mm - frame.T.t_mm, vector_from_rotation(frame.T.R.transpose() * expected.R);
    return r;
  }

  double fit(double offset_s, Transform* mean_pose) const {
    std::vector<Transform> T_W_H;
    std::vector<const TimedPose*> frames;
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      if (!use_[i]) continue;
      const std::optional<Transform> T = hand_.at(frames_[i].t_s + offset_s);
      if (!T) return kInfinity;
      T_W_H.push_back(*T);
      frames.push_back(&frames_[i]);
    }
    if (frames.empty()) return kInfinity;
    Transform mean = T_W_H.front() * frames.front()->T;
    const Vector6 weight = sigma_.cwiseAbs2().cwiseInverse();
    double squares = 0;
    constexpr int kSteps = 3;  // Gauss-Newton; the last one only sums
    for (int step = 0; step < kSteps; ++step) {
      Matrix6 JtJ = Matrix6::Zero();
      Vector6 Jtr = Vector6::Zero();
      squares = 0;
      for (std::size_t i = 0; i < frames.size(); ++i) {
        const Matrix3 to_hand = T_W_H[i].R.transpose();
        Vector6 r;
        r << to_hand * (mean.t_mm - T_W_H[i].t_mm) - frames[i]->T.t_mm,
            vector_from_rotation(frames[i]->T.R.transpose() * to_hand * mean.R);
        squares += r.dot(weight.cwiseProduct(r));
        Matrix6 J = Matrix6::Identity();
        J.topLeftCorner<3, 3>() = to_hand * mean.R;
        JtJ += J.transpose() * weight.asDiagonal() * J;
        Jtr += J.transpose() * weight.cwiseProduct(r);
      }
      if (step + 1 < kSteps) mean = moved(mean, -JtJ.ldlt().solve(Jtr));
    }
    if (mean_pose != nullptr) *mean_pose = mean;
    return squares;
  }

  std::vector<TimedPose> frames_;
  const PoseTrack& hand_;
  std::vector<bool> use_;
  Vector6 sigma_;
};

struct Minimum {
  double at_s = 0;
  double squares = 0;
  double curvature = 0;  // of the squares, a second squared
};

// Golden section within [low, high], then the parabola through three points about what it found.
Minimum minimise_over(const Wandering& wandering, double low, double high) {
  constexpr double kGolden = 0.6180339887498949;
  constexpr double kEnough_s = 2e-5;
  double inner_low = high - kGolden * (high - low);
  double inner_high = low + kGolden * (high - low);
  double at_low = wandering(inner_low);
  double at_high = wandering(inner_high);
  while (high - low > kEnough_s) {
    if (at_low < at_high) {
      high = inner_high;
      inner_high = inner_low;
      at_high = at_low;
      inner_low = high - kGolden * (high - low);
      at_low = wandering(inner_low);
    } else {
      low = inner_low;
      inner_low = inner_high;
      at_low = at_high;
      inner_high = low + kGolden * (high - low);
      at_high = wandering(inner_high);
    }
  }
  // Wide enough that the ripple of interpolation does not count.
  constexpr double kHalf_s = 2e-3;
  const double middle = 0.5 * (low + high);
  const double before = wandering(middle - kHalf_s);
  const double here = wandering(middle);
  const double after = wandering(middle + kHalf_s);
  Minimum minimum{middle, here, (before - 2 * here + after) / (kHalf_s * kHalf_s)};
  const double slope = (after - before) / (2 * kHalf_s);
  if (minimum.curvature > 0) minimum.at_s -= std::clamp(slope / minimum.curvature, -kHalf_s, kHalf_s);
  return minimum;
}

// All that a range of offsets has to offer.
struct Search {
  std::vector<Minimum> minima;  // the best first
  bool falls_at_edge = false;   // the least of all is at the end of the range
};

Search search(const Wandering& wandering, double range_s) {
  const int steps = static_cast<int>(std::floor(range_s / kScanStep_s));
  std::vector<double> squares;
  for (int i = -steps; i <= steps; ++i) squares.push_back(wandering(i * kScanStep_s));
  Search result;
  for (std::size_t i = 1; i + 1 < squares.size(); ++i) {
    if (!(squares[i] < squares[i - 1] && squares[i] <= squares[i + 1])) continue;
    const double at_s = (static_cast<int>(i) - steps) * kScanStep_s;
    result.minima.push_back(minimise_over(wandering, at_s - kScanStep_s, at_s + kScanStep_s));
  }
  std::sort(result.minima.begin(), result.minima.end(),
            [](const Minimum& a, const Minimum& b) { return a.squares < b.squares; });
  const double at_edge = std::min(squares.front(), squares.back());
  result.falls_at_edge = result.minima.empty() || at_edge < result.minima.front().squares;
  return result;
}

double rms(const std::vector<Vector6>& residuals, const Wandering& wandering, Eigen::Index first) {
  double squares = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    if (!wandering.uses(i) || !residuals[i].allFinite()) continue;
    squares += residuals[i].segment<3>(first).squaredNorm();
    ++count;
  }
  return std::sqrt(squares / static_cast<double>(std::max<std::size_t>(count, 1)));
}

// Frames that every offset in the range has a hand pose for.
std::vector<TimedPose> covered_frames(const TimeOffsetFiles& files, const std::vector<TimedPose>& frames,
                                      const PoseTrack& hand, double range_s) {
  std::vector<TimedPose> covered;
  for (const TimedPose& frame : frames) {
    bool good = true;
    for (double offset = -range_s; good && offset <= range_s + 1e-9;
         offset += 0.25 * PoseTrack::kLongestGap_s)
      good = hand.at(frame.t_s + offset).has_value();
    if (good && hand.at(frame.t_s + range_s)) covered.push_back(frame);
  }
  if (covered.size() < kFewestFrames) {
    throw InputError(files.frames, "t_s",
                     std::to_string(covered.size()) + " of " + std::to_string(frames.size()) +
                         " frames have hand poses " + shown(1e3 * range_s) +
                         " ms before and after; at least " + std::to_string(kFewestFrames) + " are needed",
                     files.hand.filename().string() + " spans " + shown(hand.first_s(), "%.3f") + " to " +
                         shown(hand.last_s(), "%.3f") +
                         " s: both tables need one clock, and a hand pose at least every 100 ms");
  }
  return covered;
}

// How fast the target passes through the hand, whose noise would be the faster the more frames there are:
// from the hand's poses.
void measure_speed(const std::vector<TimedPose>& frames, const PoseTrack& hand, TimeOffset& result) {
  constexpr double kHalf_s = 0.02;
  double mm2 = 0;
  double rad2 = 0;
  std::size_t count = 0;
  for (const TimedPose& frame : frames) {
    const auto before = hand.at(frame.t_s - kHalf_s);
    const auto after = hand.at(frame.t_s + kHalf_s);
    const auto here = hand.at(frame.t_s);
    if (!before || !after || !here) continue;
    const Vector3 p_W = *here * frame.T.t_mm;
    mm2 += (after->inverse() * p_W - before->inverse() * p_W).squaredNorm();
    rad2 += vector_from_rotation(before->R.transpose() * after->R).squaredNorm();
    ++count;
  }
  const double scale = 1 / (2 * kHalf_s * std::sqrt(static_cast<double>(std::max<std::size_t>(count, 1))));
  result.speed_mm_per_s = std::sqrt(mm2) * scale;
  result.speed_deg_per_s = std::sqrt(rad2) * scale / kDegree;
}

// 95 % of offsets from such data lie so near: the larger of what the parabola says, and of what leaving out a
// tenth at a time shows (frames' errors hang together in time, which the parabola does not know).
double half_width_s(const Wandering& wandering, const Minimum& minimum) {
  const double left_over = 6 * static_cast<double>(wandering.used()) - 7;
  if (!(minimum.curvature > 0)) return kInfinity;
  const double sigma = std::sqrt(2 * minimum.squares / left_over / minimum.curvature);
  constexpr std::size_t kBlocks = 10;
  constexpr double kStudent = 2.262;  // 97.5 %, nine degrees of freedom
  std::array<double, kBlocks> offsets{};
  double mean = 0;
  for (std::size_t b = 0; b < kBlocks; ++b) {
    const std::size_t first = b * wandering.size() / kBlocks;
    const Wandering rest = wandering.without(first, (b + 1) * wandering.size() / kBlocks);
    offsets[b] = minimise_over(rest, minimum.at_s - kScanStep_s, minimum.at_s + kScanStep_s).at_s;
    mean += offsets[b] / kBlocks;
  }
  double scatter = 0;
  for (const double offset : offsets) scatter += (offset - mean) * (offset - mean);
  const double jackknife = std::sqrt(scatter * (kBlocks - 1) / kBlocks);
  return std::max(1.96 * sigma, kStudent * jackknife);
}

// Another offset that explains the frames as well: a motion that repeats itself.
void require_one_minimum(const TimeOffsetFiles& files, const std::vector<Minimum>& minima, double variance) {
  constexpr double kClearlyWorse = 30;  // in squared standard deviations
  if (minima.size() < 2 || minima[1].squares - minima[0].squares > kClearlyWorse * variance) return;
  throw InputError(files.hand, "t_s",
                   "offsets of " + shown(1e3 * minima[0].at_s, "%.0f") + " and " +
                       shown(1e3 * minima[1].at_s, "%.0f") +
                       " ms fit equally well: the motion repeats itself",
                   "move irregularly, or give a smaller --range-ms");
}

}  // namespace

TimeOffset find_time_offset(const TimeOffsetFiles& files, const std::vector<TimedPose>& T_H_M,
                            const std::vector<TimedPose>& T_W_H, double range_ms) {
  if (T_W_H.size() < 2) throw InputError(files.hand, "", "holds a single pose", "record the whole motion");
  const PoseTrack hand(T_W_H);
  const double range_s = 1e-3 * range_ms;
  const std::vector<TimedPose> frames = covered_frames(files, T_H_M, hand, range_s);
  TimeOffset result;
  measure_speed(frames, hand, result);

  const auto too_slow = [&](const std::string& how) {
    return InputError(
        files.hand, "",
        "the motion is too slow to tell the offset" + how + ": the target passes at " +
            shown(result.speed_mm_per_s) + " mm/s and " + shown(result.speed_deg_per_s) + " deg/s RMS",
        "move the hand to and fro faster, irregularly, for 20 s or longer, with the target in view");
  };
  constexpr double kStill_mm_per_s = 1e-3;
  if (result.speed_mm_per_s < kStill_mm_per_s && result.speed_deg_per_s < kStill_mm_per_s) throw too_slow("");

  Wandering wandering(frames, hand);
  Search found;
  // First with usual weights, then with those that the residuals suggest.
  for (int round = 0; round < 3; ++round) {
    found = search(wandering, range_s);
    if (found.falls_at_edge) {
      throw InputError(
          files.frames, "t_s", "no offset within " + shown(range_ms) + " ms fits best",
          "both tables need one clock, and a motion that is not too slow; or give a larger --range-ms");
    }
    if (round == 2) break;
    wandering.weigh(wandering.residuals(found.minima.front().at_s));
    if (wandering.used() < kFewestFrames) {
      throw InputError(files.frames, "",
                       "only " + std::to_string(wandering.used()) + " frames agree on where the target is",
                       "the target must stand still in the world, and be found in nearly every frame");
    }
  }
  const Minimum& minimum = found.minima.front();
  const double half_s = half_width_s(wandering, minimum);
  if (!std::isfinite(half_s)) throw too_slow("");
  if (half_s > 1e-3 * kWidestInterval_ms) throw too_slow(" (+- " + shown(1e3 * half_s) + " ms)");
  require_one_minimum(files, found.minima, minimum.squares / (6 * static_cast<double>(wandering.used()) - 7));

  result.offset_ms = 1e3 * minimum.at_s;
  result.half_width_ms = 1e3 * half_s;
  result.frames = wandering.used();
  result.left_out = T_H_M.size() - wandering.used();
  const auto before = wandering.residuals(0);
  const auto after = wandering.residuals(minimum.at_s);
  result.before_mm = rms(before, wandering, 0);
  result.before_deg = rms(before, wandering, 3) / kDegree;
  result.after_mm = rms(after, wandering, 0);
  result.after_deg = rms(after, wandering, 3) / kDegree;
  return result;
}

}  // namespace vergence::calibrate
