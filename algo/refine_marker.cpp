#include "algo/refine_marker.hpp"

#include <Eigen/Cholesky>
#include <array>
#include <cmath>

namespace vergence {
namespace {

constexpr double kMaxStep_mm = 15;
constexpr double kMaxStep_rad = 0.15;

unsigned at(int i) {
  return static_cast<unsigned>(i);
}

// ---- Outlines ---------------------------------------------------------------------------------------------

struct ContourPoint {
  Vector2 uv_px;
  Vector2 normal;     // outwards, unit length
  Vector6 slope;      // how far the point moves along the normal with the pose increment, px
  double radius_px;   // from the projected centre of the outline
  bool seen = false;  // in the image with some room around, and not behind another ball
};

// The outline of a ball in one camera.
struct Outline {
  Vector2 centre_px = Vector2::Zero();
  Vector2 axis_u_px = Vector2::Zero();  // from the centre to the first point,
  Vector2 axis_v_px = Vector2::Zero();  // and to that a quarter of a turn on
  std::array<ContourPoint, kContourPoints> point;
  double radius_px = 0;
  bool in_front = false;
};

struct Direction {
  double cosine = 1;
  double sine = 0;
};

constexpr std::array<Direction, kContourPoints> make_directions() {
  static_assert(kContourPoints == 24);
  constexpr Direction kStep{0.96592582628906829, 0.25881904510252076};  // a 24th of a turn
  std::array<Direction, kContourPoints> table{};
  for (unsigned k = 1; k < kContourPoints; ++k) {
    const Direction& last = table[k - 1];
    table[k].cosine = last.cosine * kStep.cosine - last.sine * kStep.sine;
    table[k].sine = last.sine * kStep.cosine + last.cosine * kStep.sine;
  }
  return table;
}
constexpr std::array<Direction, kContourPoints> kDirections = make_directions();

// Whether a nearer ball stands before the point, or so close to its side that the profile would meet it.
bool is_hidden(const MarkerModel& model, int ball, const Transform& T_C_M, const Vector3& p_C_mm,
               double room_rad) {
  bool hidden = false;
  const double distance = std::sqrt(p_C_mm.squaredNorm());
  const Vector3 ray = p_C_mm / distance;
  for (int j = 0; j < model.balls; ++j) {
    const Vector3 c = T_C_M * model.ball[at(j)].centre_mm;
    const double along = c.dot(ray);
    const double radius = model.ball[at(j)].radius_mm + room_rad * along;
    const bool before = along > 0 && along < distance;
    hidden |= j != ball && before && c.squaredNorm() - along * along < radius * radius;
  }
  return hidden;
}

// `room_px`: how far along the normals the image is going to be looked at.
Outline outline_of(const MarkerModel& model, int ball, const CameraModel& camera, const Transform& T_C_M,
                   double room_px) {
  Outline outline;
  const Vector3& q = model.ball[at(ball)].centre_mm;
  const double R = model.ball[at(ball)].radius_mm;
  const Vector3 c = T_C_M * q;
  const double squared = c.squaredNorm();
  outline.in_front = c[2] > R + kMinDepth_mm;
  if (!outline.in_front) return outline;
  const double share = R * R / squared;
  const Vector3 middle = c * (1 - share);
  const double radius = R * std::sqrt(1 - share);
  // Two directions across the line of sight; it never lies along x: the ball is in front.
  const Vector3 sight = c / std::sqrt(squared);
  Vector3 a = Vector3::UnitX() - sight[0] * sight;
  a /= std::sqrt(a.squaredNorm());
  const Vector3 b{sight[1] * a[2] - sight[2] * a[1], sight[2] * a[0] - sight[0] * a[2],
                  sight[0] * a[1] - sight[1] * a[0]};
  if (!project(camera, middle, outline.centre_px)) return Outline{};

  const double room_rad = room_px / camera.fx_px;
  for (int k = 0; k < kContourPoints; ++k) {
    ContourPoint& point = outline.point[at(k)];
    const auto [cosine, sine] = kDirections[at(k)];
    const Vector3 p = middle + radius * (cosine * a + sine * b);
    Eigen::Matrix<double, 2, 3> slope;
    if (!project(camera, p, point.uv_px, slope)) return Outline{};
    const Vector2 outwards = point.uv_px - outline.centre_px;
    const Vector2 tangent = slope * (cosine * b - sine * a);
    Vector2 normal{tangent[1], -tangent[0]};
    if (normal.dot(outwards) < 0) normal = -normal;
    point.normal = normal / std::sqrt(normal.squaredNorm() + 1e-30);
    point.radius_px = std::sqrt(outwards.squaredNorm());
    // The ball's centre moves by R (dt - q x dw), and its outline along with it.
    const Vector3 g = (point.normal.transpose() * slope * T_C_M.R).transpose();
    point.slope << g, q[1] * g[2] - q[2] * g[1], q[2] * g[0] - q[0] * g[2], q[0] * g[1] - q[1] * g[0];
    const Vector2 near = point.uv_px - room_px * point.normal;
    const Vector2 far = point.uv_px + room_px * point.normal;
    const auto inside = [&camera](const Vector2& uv) {
      return uv[0] >= 1 && uv[1] >= 1 && uv[0] <= camera.width_px - 2.001 &&
             uv[1] <= camera.height_px - 2.001;
    };
    const bool hidden = is_hidden(model, ball, T_C_M, p, room_rad);
    point.seen = inside(near) && inside(far) && !hidden;
  }
  outline.axis_u_px = outline.point[0].uv_px - outline.centre_px;
  outline.axis_v_px = outline.point[kContourPoints / 4].uv_px - outline.centre_px;
  outline.radius_px = 0.5 * (outline.point[0].radius_px + outline.point[kContourPoints / 4].radius_px);
  return outline;
}

// Where a sample of S_in lies, drawn in to a share of the radius.
Vector2 inner_sample(const MarkerModel& model, unsigned i, const Outline& outline, double share) {
  const double across = share * static_cast<double>(model.pattern_x[i]);
  const double down = share * static_cast<double>(model.pattern_y[i]);
  return outline.centre_px + across * outline.axis_u_px + down * outline.axis_v_px;
}

// ---- Normal equations -------------------------------------------------------------------------------------

struct NormalEquations {
  Matrix6 H = Matrix6::Zero();
  Vector6 g = Vector6::Zero();
  double weights = 0;
  double squares = 0;  // weighted, of the residuals
};

// How far along the normals of one outline the edges were found, and how much each is worth (0..1).
struct Edges {
  std::array<double, kContourPoints> offset_px{};
  std::array<double, kContourPoints> clarity{};
};

// Geman and McClure: rho = r^2 / (r^2 + s^2).
double robust_weight(double residual, double scale) {
  const double share = scale * scale / (residual * residual + scale * scale);
  return share * share;
}

// The offset common to an outline's edges. It is held near zero as by one clear edge in ten.
constexpr double kOffsetPrior = 0.1;
double common_offset(const Edges& edges, double scale_px) {
  double offset = 0;
  for (int round = 0; round < 3; ++round) {
    double sum = 0;
    double weights = kOffsetPrior;
    for (unsigned k = 0; k < kContourPoints; ++k) {
      const double w =
          edges.clarity[k] * (round == 0 ? 1 : robust_weight(edges.offset_px[k] - offset, scale_px));
      sum += w * edges.offset_px[k];
      weights += w;
    }
    offset = sum / weights;
  }
  return offset;
}

void add_outline(const Outline& outline, const Edges& edges, double scale_px, NormalEquations& N) {
  const double offset = common_offset(edges, scale_px);
  Vector6 E = Vector6::Zero();
  double weights = kOffsetPrior;
  double moments = 0;
  for (unsigned k = 0; k < kContourPoints; ++k) {
    const double t = edges.offset_px[k];
    const double r = t - offset;
    const double w = edges.clarity[k] * robust_weight(r, scale_px);
    const Vector6& J = outline.point[k].slope;
    const Vector6 wJ = w * J;
    N.H.noalias() += wJ * J.transpose();
    N.g += wJ * t;
    E += wJ;
    weights += w;
    moments += w * t;
    N.weights += w;
    N.squares += w * r * r;
  }
  N.H.noalias() -= E * E.transpose() / weights;
  N.g -= E * (moments / weights);
}

Vector3 limited(const Vector3& step, double limit) {
  const double length = std::sqrt(step.squaredNorm());
  return length > limit ? Vector3(step * (limit / length)) : step;
}

void take_step(const NormalEquations& N, Transform& T_H_M) {
  // What the outlines leave open stays as it is.
  constexpr double kHold_per_mm2 = 1e-3;
  constexpr double kHold_per_rad2 = 3;
  Matrix6 H = N.H;
  for (int k = 0; k < 6; ++k) H(k, k) += 1e-4 * H(k, k) + (k < 3 ? kHold_per_mm2 : kHold_per_rad2);
  const Vector6 step = H.ldlt().solve(N.g);
  const Vector3 move = limited(step.head<3>(), kMaxStep_mm);
  const Vector3 turn = limited(step.tail<3>(), kMaxStep_rad);
  T_H_M = T_H_M * Transform{rotation_from_quaternion_vector(turn * 0.5), move};
  T_H_M.R = rotation_from_quaternion_vector(quaternion_vector_from_rotation(T_H_M.R));
}

// ---- Hue along rays ---------------------------------------------------------------------------------------

constexpr std::array<double, 4> kApproachScales{0.4, 0.3, 0.15, 0.1};  // of residuals, in radii
constexpr int kRaySamples = 14;
constexpr double kRayFrom = 0.20;  // of the radius
constexpr double kRayStep = 0.12;

// Index of the nearest pixel, or the outside index.
int pixel_at(const HuePlane& plane, const Vector2& uv) {
  const bool inside = uv[0] >= 0 && uv[1] >= 0 && uv[0] <= plane.width_px - 1 && uv[1] <= plane.height_px - 1;
  const int x = inside ? static_cast<int>(uv[0] + 0.5) : 0;
  const int y = inside ? static_cast<int>(uv[1] + 0.5) : 0;
  return inside ? y * plane.width_px + x : plane.outside_index();
}

// Where on each ray the ball's hue ends, as its share of samples tells; nothing where all or none have it.
Edges hue_edges(const Outline& outline, const HuePlane& plane, std::uint8_t hue, int tolerance) {
  Edges edges;
  for (int k = 0; k < kContourPoints; ++k) {
    const ContourPoint& point = outline.point[at(k)];
    const Vector2 ray = point.uv_px - outline.centre_px;
    int matches = 0;
    int within = 0;
    for (int i = 0; i < kRaySamples; ++i) {
      const Vector2 uv = outline.centre_px + (kRayFrom + kRayStep * i) * ray;
      const int index = pixel_at(plane, uv);
      within += static_cast<int>(index != plane.outside_index());
      matches += static_cast<int>(hue_distance(plane.code[at(index)], hue) <= tolerance);
    }
    const double edge = kRayFrom + kRayStep * (matches - 0.5);
    edges.offset_px[at(k)] = (edge - 1) * point.radius_px;
    const bool ends = matches > 0 && matches < kRaySamples && within == kRaySamples;
    edges.clarity[at(k)] = ends ? 1 : 0;
  }
  return edges;
}

// ---- Colour across the edge -------------------------------------------------------------------------------

using Linear = Eigen::Vector3f;  // red, green, blue; linear light, 1 is white

// The sRGB curve's inverse, as a cubic.
constexpr std::array<float, 256> make_linear_table() {
  std::array<float, 256> table{};
  for (int i = 0; i < 256; ++i) {
    const double x = i / 255.0;
    table[static_cast<unsigned>(i)] = static_cast<float>(
        x <= 0.04045 ? x / 12.92 : x * (x * (x * 0.305306011 + 0.682171111) + 0.012522878));
  }
  return table;
}
constexpr std::array<float, 256> kLinear = make_linear_table();

float light_of(int level) {
  return kLinear[at(level < 0 ? 0 : (level > 255 ? 255 : level))];
}

Linear linear_of_rgb(ColourPixel packed) {
  return {kLinear[packed & 0xFF], kLinear[(packed >> 8) & 0xFF], kLinear[(packed >> 16) & 0xFF]};
}

// BT.601, limited range, in 256ths.
Linear linear_of_yuv(ColourPixel packed) {
  const int grey = 298 * (static_cast<int>(packed & 0xFF) - 16) + 128;
  const int cb = static_cast<int>((packed >> 8) & 0xFF) - 128;
  const int cr = static_cast<int>((packed >> 16) & 0xFF) - 128;
  return {light_of((grey + 409 * cr) >> 8), light_of((grey - 100 * cb - 208 * cr) >> 8),
          light_of((grey + 516 * cb) >> 8)};
}

template <bool kYuv>
class Sampler {
 public:
  explicit Sampler(const ColourLevel& image) : image_(image) {}

  [[nodiscard]] Linear pixel(int x, int y) const {
    return linear(image_.pixel[static_cast<std::ptrdiff_t>(y) * image_.width_px + x]);
  }

  // Bilinear; (u, v) within the image less its last row and column.
  [[nodiscard]] Linear at_px(double u, double v) const {
    const int x = static_cast<int>(u);
    const int y = static_cast<int>(v);
    const auto fu = static_cast<float>(u - x);
    const auto fv = static_cast<float>(v - y);
    const ColourPixel* p = image_.pixel + static_cast<std::ptrdiff_t>(y) * image_.width_px + x;
    const Linear top_left = linear(p[0]);
    const Linear bottom_left = linear(p[image_.width_px]);
    const Linear top = top_left + fu * (linear(p[1]) - top_left);
    const Linear bottom = bottom_left + fu * (linear(p[image_.width_px + 1]) - bottom_left);
    return top + fv * (bottom - top);
  }

  [[nodiscard]] int width_px() const { return image_.width_px; }
  [[nodiscard]] int height_px() const { return image_.height_px; }

 private:
  static Linear linear(ColourPixel packed) { return kYuv ? linear_of_yuv(packed) : linear_of_rgb(packed); }
  ColourLevel image_;
};

// Mean colour of the ball as it is in this image: of its samples well inside that have its hue.
struct BallColour {
  Linear unit = Linear::Zero();  // direction
  float length = 0;              // 0: too few samples
};

template <bool kYuv>
BallColour colour_of_ball(const MarkerModel& model, int ball, const Outline& outline,
                          const MarkerSight& sight, const Sampler<kYuv>& sampler) {
  constexpr double kWellInside = 0.8;
  constexpr int kFewest = 3;
  Linear sum = Linear::Zero();
  int count = 0;
  for (unsigned i = 0; i < at(model.inner_samples); ++i) {
    const Vector2 uv = inner_sample(model, i, outline, kWellInside);
    const bool inside =
        uv[0] >= 0 && uv[1] >= 0 && uv[0] <= sampler.width_px() - 1.0 && uv[1] <= sampler.height_px() - 1.0;
    const int x = inside ? static_cast<int>(uv[0] + 0.5) : 0;
    const int y = inside ? static_cast<int>(uv[1] + 0.5) : 0;
    const std::uint8_t code = sight.hue->code[static_cast<std::size_t>(y) * at(sampler.width_px()) + at(x)];
    const bool match = inside && hue_distance(code, model.hue[at(ball)]) <= model.tolerance[at(ball)];
    sum += (match ? 1.0F : 0.0F) * sampler.pixel(x, y);
    count += static_cast<int>(match);
  }
  BallColour colour;
  const Linear mean = sum / static_cast<float>(count > 0 ? count : 1);
  const float length = std::sqrt(mean.squaredNorm());
  if (count < kFewest || !(length > 0)) return colour;
  colour.unit = mean / length;
  colour.length = length;
  return colour;
}

constexpr int kProfileSamples = 8;

// The edge between ball and background within +-reach of a contour point. The profile is seen along the
// colour in which the two differ, least of all along the ball's own: shading changes that one all over the
// ball, most near its limb, whereas the background's share does not depend on it.
template <bool kYuv>
void find_edge(const Sampler<kYuv>& sampler, const BallColour& ball, const ContourPoint& point,
               double reach_px, double& offset_px, double& clarity) {
  constexpr float kShading = 0.95F;        // of the ball's own colour direction that does not count
  constexpr float kLeastContrast = 0.10F;  // of the ball's brightness, where clarity is one half
  constexpr float kOffColour = 0.20F;      // of the inside's direction, likewise
  constexpr float kRagged = 0.04F;         // mean square misfit of the profile, likewise
  const auto look = [&](double t) {
    return sampler.at_px(point.uv_px[0] + t * point.normal[0], point.uv_px[1] + t * point.normal[1]);
  };
  const Linear inside = 0.5F * (look(-reach_px) + look(-reach_px - 1));
  const Linear outside = 0.5F * (look(reach_px) + look(reach_px + 1));
  const Linear difference = outside - inside;
  const float along = ball.unit.dot(difference);
  const float squared = difference.squaredNorm() - kShading * along * along;  // contrast squared
  const Linear direction = (difference - (kShading * along) * ball.unit) / (squared + 1e-12F);

  const double step = 2 * reach_px / kProfileSamples;
  std::array<float, kProfileSamples> share{};  // of the background
  float sum = 0;
  for (int i = 0; i < kProfileSamples; ++i) {
    const float b = (look(-reach_px + (i + 0.5) * step) - inside).dot(direction);
    share[at(i)] = b > -0.5F ? (b < 1.5F ? b : 1.5F) : -0.5F;
    sum += share[at(i)];
  }
  const double edge = reach_px - step * static_cast<double>(sum);
  // How like a blurred step it is: over two pixels from ball to background.
  float misfit = 0;
  for (int i = 0; i < kProfileSamples; ++i) {
    const auto ramp = static_cast<float>(0.5 + 0.5 * (-reach_px + (i + 0.5) * step - edge));
    const float r = share[at(i)] - (ramp > 0 ? (ramp < 1 ? ramp : 1) : 0);
    misfit += r * r;
  }
  misfit /= kProfileSamples;
  const float least = kLeastContrast * ball.length;
  const float off = inside.squaredNorm() - inside.dot(ball.unit) * inside.dot(ball.unit);
  const float off_limit = kOffColour * kOffColour * inside.squaredNorm() + 0.25F * least * least;
  const float worth = squared / (squared + least * least + 1e-12F) *
                      (off_limit / (off_limit + off + 1e-12F)) * (kRagged / (kRagged + misfit));
  offset_px = edge;
  clarity = static_cast<double>(worth);
}

// One way to look at the edges, from far to near.
struct EdgePass {
  double reach_px;
  double scale_px;  // of residuals
};
constexpr std::array<EdgePass, 4> kEdgePasses{{{6, 2.0}, {4, 1.0}, {3, 0.7}, {3, 0.7}}};
constexpr EdgePass kLastPass{3, 0.7};
constexpr double kLargestReach = 0.35;  // of the radius of the outline

template <bool kYuv>
Edges colour_edges_as(const MarkerModel& model, int ball, const Outline& outline, const MarkerSight& sight,
                      double reach_px) {
  Edges edges;
  const Sampler<kYuv> sampler(sight.colour);
  const BallColour colour = colour_of_ball(model, ball, outline, sight, sampler);
  ContourPoint middle;  // stands in where there is nothing to see, so that the work stays the same
  middle.uv_px = {sampler.width_px() / 2.0, sampler.height_px() / 2.0};
  middle.normal = Vector2::Zero();
  for (unsigned k = 0; k < kContourPoints; ++k) {
    const bool seen = outline.point[k].seen && colour.length > 0;
    find_edge(sampler, colour, seen ? outline.point[k] : middle, reach_px, edges.offset_px[k],
              edges.clarity[k]);
    if (!seen) edges.clarity[k] = 0;
  }
  return edges;
}

Edges colour_edges(const MarkerModel& model, int ball, const Outline& outline, const MarkerSight& sight,
                   double reach_px) {
  return sight.yuv ? colour_edges_as<true>(model, ball, outline, sight, reach_px)
                   : colour_edges_as<false>(model, ball, outline, sight, reach_px);
}

double reach_of(const EdgePass& pass, const MarkerModel& model, int ball, const CameraModel& camera,
                const Transform& T_C_M) {
  const double depth = (T_C_M * model.ball[at(ball)].centre_mm)[2];
  const double radius_px = camera.fx_px * model.ball[at(ball)].radius_mm / (depth > 1 ? depth : 1);
  const double most = kLargestReach * radius_px;
  return pass.reach_px < most ? pass.reach_px : most;
}

template <class F>
void for_each_outline(const MarkerModel& model, const MarkerSight& left, const MarkerSight& right,
                      const Transform& T_H_M, const EdgePass& pass, F&& f) {
  for (const MarkerSight* sight : {&left, &right}) {
    const Transform T_C_M = target_in_camera(*sight->camera, T_H_M);
    for (int ball = 0; ball < model.balls; ++ball) {
      const double reach_px = reach_of(pass, model, ball, *sight->camera, T_C_M);
      f(*sight, ball, outline_of(model, ball, *sight->camera, T_C_M, reach_px + 1.5), reach_px);
    }
  }
}

void approach_marker(const MarkerModel& model, const MarkerSight& left, const MarkerSight& right,
                     Transform& T_H_M) {
  for (const double scale : kApproachScales) {
    NormalEquations N;
    for_each_outline(model, left, right, T_H_M, kLastPass,
                     [&](const MarkerSight& sight, int ball, const Outline& outline, double) {
                       if (!outline.in_front) return;
                       const Edges edges =
                           hue_edges(outline, *sight.hue, model.hue[at(ball)], model.tolerance[at(ball)]);
                       add_outline(outline, edges, scale * outline.radius_px, N);
                     });
    take_step(N, T_H_M);
  }
}

void refine_marker_pose(const MarkerModel& model, const MarkerSight& left, const MarkerSight& right,
                        Transform& T_H_M) {
  for (const EdgePass& pass : kEdgePasses) {
    NormalEquations N;
    for_each_outline(model, left, right, T_H_M, pass,
                     [&](const MarkerSight& sight, int ball, const Outline& outline, double reach_px) {
                       const Edges edges = colour_edges(model, ball, outline, sight, reach_px);
                       if (outline.in_front) add_outline(outline, edges, pass.scale_px, N);
                     });
    take_step(N, T_H_M);
  }
}

// The evidence for a pose, and its normal equations.
MarkerFit assess(const MarkerModel& model, const MarkerSight& left, const MarkerSight& right,
                 const Transform& T_H_M) {
  constexpr double kClear = 0.25;
  constexpr double kThere_px = 1.25;
  constexpr double kSize = 0.10;  // of the radius, or
  constexpr double kSize_px = 1.5;
  constexpr int kFewest = 8;
  MarkerFit fit{T_H_M, {}, Matrix6::Zero()};
  MarkerEvidence& evidence = fit.evidence;
  NormalEquations N;
  double cost = 0;
  int points = 0;
  int there = 0;
  std::array<int, kMaxBalls> ball_seen{};
  std::array<int, kMaxBalls> ball_there{};
  for_each_outline(
      model, left, right, T_H_M, kLastPass,
      [&](const MarkerSight& sight, int ball, const Outline& outline, double reach_px) {
        const Edges edges = colour_edges(model, ball, outline, sight, reach_px);
        const double offset = common_offset(edges, kLastPass.scale_px);
        const double size = kSize * outline.radius_px > kSize_px ? kSize * outline.radius_px : kSize_px;
        const bool right_size = std::abs(offset) < size;
        if (outline.in_front) add_outline(outline, edges, kLastPass.scale_px, N);
        int seen = 0;
        int borne_out = 0;
        for (unsigned k = 0; k < kContourPoints; ++k) {
          const double r = edges.offset_px[k] - offset;
          seen += static_cast<int>(outline.point[k].seen);
          borne_out += static_cast<int>(edges.clarity[k] > kClear && std::abs(r) < kThere_px && right_size);
          cost += outline.point[k].seen
                      ? 1 - edges.clarity[k] * std::sqrt(robust_weight(r, kLastPass.scale_px))
                      : 0;
        }
        points += seen;
        ball_seen[at(ball)] += seen;
        ball_there[at(ball)] += borne_out;
        there += borne_out;
      });
  double least = 1;
  for (unsigned ball = 0; ball < at(model.balls); ++ball) {
    evidence.ball[ball] = ball_there[ball] / (ball_seen[ball] + 1e-9);
    if (ball_seen[ball] >= kFewest && evidence.ball[ball] < least) least = evidence.ball[ball];
  }
  if (points < kContourPoints) return fit;
  evidence.cost = cost / points;
  evidence.share = static_cast<double>(there) / points;
  evidence.least_ball = least;
  // Weights are relative: the residuals tell the variance of a weight of one.
  constexpr double kLeastVariance_px2 = 0.02 * 0.02;
  const double freedom = N.weights - 6 - 2 * model.balls;
  const double variance = N.squares / (freedom > 1 ? freedom : 1) + kLeastVariance_px2;
  fit.information = N.H / variance;
  return fit;
}

}  // namespace

MarkerEvidence marker_evidence(const MarkerModel& model, const MarkerSight& left, const MarkerSight& right,
                               const Transform& T_H_M) {
  return assess(model, left, right, T_H_M).evidence;
}

MarkerFit fit_marker(const MarkerModel& model, const MarkerSight& left, const MarkerSight& right,
                     const Transform& guess) {
  MarkerFit best = assess(model, left, right, guess);
  // By hue first where the guess is far off; but the sliver of a ball that something hides leads hue astray,
  // and a guess that was good is lost.
  for (const bool from_far : {true, false}) {
    Transform T_H_M = guess;
    if (from_far) approach_marker(model, left, right, T_H_M);
    refine_marker_pose(model, left, right, T_H_M);
    const MarkerFit moved = assess(model, left, right, T_H_M);
    if (moved.evidence.cost <= best.evidence.cost) best = moved;
  }
  return best;
}

void observe_light(const MarkerModel& model, const std::array<std::uint8_t, kMaxBalls>& configured,
                   const MarkerSight& left, const MarkerSight& right, const MarkerFit& fit,
                   LightFollower& light) {
  constexpr double kWellInside = 0.7;
  constexpr double kBorneOut = 0.7;
  for_each_outline(model, left, right, fit.T_H_M, kLastPass,
                   [&](const MarkerSight& sight, int ball, const Outline& outline, double) {
                     const HuePlane& plane = *sight.hue;
                     const bool sure = fit.evidence.ball[at(ball)] >= kBorneOut;
                     for (unsigned i = 0; i < at(model.inner_samples); ++i) {
                       const Vector2 uv = inner_sample(model, i, outline, kWellInside);
                       const int index = pixel_at(plane, uv);
                       light.observe(ball, configured[at(ball)], sure ? plane.code[at(index)] : kHueOutside);
                     }
                   });
}

}  // namespace vergence
