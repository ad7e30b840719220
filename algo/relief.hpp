// The relief of a photo-model: how far each of its points lies before or behind the flat model, learned from
// both cameras while the target is tracked. Solids are found some millimetres beside the truth without it.
//
// Three views see the target: left, right, and the photo, whose place in the target frame is known. A point
// of relief z lies on its ray of the photo, P(z) = C + (1 + z/d) (P0 - C), with the optical centre C and the
// flat model's point P0. The pose and all z are improved together, by Gauss-Newton on the three pairings of
// colours that refinement uses, so that a relief and the tilt that would explain it nearly as well are told
// apart.
//
// A first relief is adopted in the frame it was learned from where it explains that far better than the flat
// model does, a later one where it explains frames it has not learned from clearly better. While it is young
// it has to go on being better than the flat model, or is given back.
#pragma once

#include <array>
#include <cstdint>

#include "algo/camera_model.hpp"
#include "algo/colour_pyramid.hpp"
#include "algo/limits.hpp"
#include "algo/shade_field.hpp"
#include "algo/target_model.hpp"

namespace vergence {

enum class ReliefState : std::uint8_t {
  kFlat,      // nothing learned yet, or given up
  kLearning,  // a candidate is being learned, the model in use is flat
  kAdopted,   // the model in use has a relief
};

[[nodiscard]] const char* to_string(ReliefState state);

enum class ReliefAdvice : std::uint8_t {
  kKeep,      // the model as it is
  kAdopt,     // what was learned is better: adopt()
  kGiveBack,  // the flat model is as good after all: give_back()
};

// What the solver needs to know of a point. u and v are pixel coordinates at the level it was sampled at.
struct ReliefSample {
  alignas(16) std::array<float, 4> value{};    // luma, 2 cb, 2 cr, 0
  alignas(16) std::array<float, 4> slope_u{};  // their change a pixel to the right
  alignas(16) std::array<float, 4> slope_v{};  // and down
  std::array<double, 7> du{};  // change of u with the pose increment, as in refinement, and with z
  std::array<double, 7> dv{};
  double seen = 0;  // 1 or 0
};

inline constexpr int kReliefHypotheses = 25;  // depths tried before Gauss-Newton takes over

class Relief {
 public:
  // Starts from the flat model: who neighbours whom, which points look like background.
  void start(const PhotoModel& flat);

  // Learns from a frame on which the target was found at T_H_M with `model`, and says what is worth doing.
  // The same work for every image at the same pose. Where the target was `followed` there, rather than found
  // by a whole search, there is time to learn a young relief from nothing again, from other tilts as well,
  // and to see whether the flat model does as well. From the side a relief in use is not learned from. The
  // first time, depths are tried about what `model` has: flat, or inflated.
  [[nodiscard]] ReliefAdvice observe(const StereoRig& rig, const ColourPyramid& left,
                                     const ColourPyramid& right, const PhotoModel& model,
                                     const Transform& T_H_M, bool followed);

  // Makes `model`, of which no relief is known, its silhouette inflated to such a share of what inflate()
  // says; 0 is flat. Where the silhouette is not known it stays flat.
  void inflate_model(double share, PhotoModel& model) const;

  // Gives `model` what was learned, relief and weights; T_H_M becomes the pose on it.
  void adopt(PhotoModel& model, Transform& T_H_M);

  // Makes `model` what it was before there was a relief, flat, and forgets nothing.
  void lay_aside(PhotoModel& model) const;
  // Forgets what was learned but not adopted: it was of something else.
  void drop();
  // Forgets what was adopted as well, and makes `model` flat again.
  void give_back(PhotoModel& model);
  // Where the flat model was as good, at the last frame.
  [[nodiscard]] const Transform& flat_pose() const { return T_H_F_; }

  [[nodiscard]] ReliefState state() const { return state_; }
  [[nodiscard]] int frames() const { return frames_; }  // learned from
  [[nodiscard]] bool learning() const;                  // more is to be learned from views like these
  [[nodiscard]] bool is_young() const;                  // learned from few frames only

 private:
  struct View {
    CameraModel camera;
    ColourLevel image;
    const SurfaceNormals& normals;
  };
  struct Light {
    double gain = 1;
    std::array<double, 4> offset{};
    double scale = 1;  // of the residuals
    double cost = 0;   // mean absolute residual over the spread of the colours
  };
  using Points = std::array<double, kMaxReliefPoints>;
  using Slopes = std::array<Vector2, kMaxReliefPoints>;  // of z, along x and along y
  using PairingCosts = std::array<double, 3>;            // photo-left, photo-right, left-right

  [[nodiscard]] bool is_early() const;  // learned from few frames, of this view or at all
  [[nodiscard]] Vector3 point(int i, double z_mm) const;
  void sample(const Points& z_mm, const View& view, const Transform& T_H_M,
              std::array<ReliefSample, kMaxReliefPoints>& samples) const;
  void sample_colours(double z_mm, const View& view, const Transform& T_H_M,
                      std::array<ReliefSample, kMaxReliefPoints>& samples) const;
  template <class A, class B, class Seen>
  [[nodiscard]] Light fit_light(A&& a, B&& b, Seen&& seen) const;
  void fit_lights(const PhotoModel& model, int level);
  void relight();
  void look(const StereoRig& rig, const ColourPyramid& left, const ColourPyramid& right, int level,
            const PhotoModel& model, const Points& z_mm, const Transform& T_H_M);
  void glance(const StereoRig& rig, const ColourPyramid& left, const ColourPyramid& right, int level,
              const PhotoModel& model, double z_mm, const Transform& T_H_M);
  // Of the three pairings at the last look.
  [[nodiscard]] PairingCosts costs() const;
  [[nodiscard]] double cost() const;
  void linearise();
  void add_priors();
  void forget_depths();
  void find_slopes(const Points& z_mm, Slopes& slopes) const;
  void set_depths(const Points& z_mm, const Slopes& slopes, double share, PhotoModel& model) const;
  void start_slopes();
  [[nodiscard]] Vector2 slope(const Points& z_mm, int i) const;
  void multiply(const Vector6& pose, const Points& z, Vector6& out_pose, Points& out_z) const;
  [[nodiscard]] Vector6 solve_pose() const;
  void sweep(const StereoRig& rig, const ColourPyramid& left, const ColourPyramid& right,
             const PhotoModel& model, const Transform& T_H_C, int first, int count);
  void improve(const StereoRig& rig, const ColourPyramid& left, const ColourPyramid& right, int level,
               const PhotoModel& model, int steps, double share, Transform& T_H_C);
  [[nodiscard]] double learn_anew(const StereoRig& rig, const ColourPyramid& left, const ColourPyramid& right,
                                  const PhotoModel& model, Transform& T_H_C);
  void try_anew(const StereoRig& rig, const ColourPyramid& left, const ColourPyramid& right,
                const PhotoModel& model, const Transform& T_H_start, Transform& T_H_C);
  [[nodiscard]] double flat_cost(const StereoRig& rig, const ColourPyramid& left, const ColourPyramid& right,
                                 int level, const PhotoModel& model, const Transform& T_H_M);
  [[nodiscard]] double cost_in_use(const StereoRig& rig, const ColourPyramid& left,
                                   const ColourPyramid& right, int level, const PhotoModel& model,
                                   const Transform& T_H_M);
  [[nodiscard]] double spread_mm() const;
  [[nodiscard]] Vector3 view(const StereoRig& rig, const Transform& T_H_M) const;
  [[nodiscard]] float misfit(const std::array<Light, 3>& lights, int i) const;
  void average(std::array<float, kMaxReliefPoints>& of_points);
  [[nodiscard]] Transform take_plane_out();
  Vector6 solve_jointly();

  int points_ = 0;
  Vector3 photo_view_ = Vector3::Zero();  // where the photo was taken from, as view()
  std::array<std::array<std::int16_t, kReliefNeighbours>, kMaxReliefPoints> neighbour_{};
  // What makes slopes of the differences of z to the neighbours, along x and along y.
  std::array<std::array<Vector2, kReliefNeighbours>, kMaxReliefPoints> slope_of_{};
  Points x_mm_{};  // of the flat model
  Points y_mm_{};
  Points ray_x_{};  // how a point moves with its relief, a mm of z: along its ray of the photo
  Points ray_y_{};
  // The same in single precision, and what it was before there was a relief.
  alignas(16) std::array<float, kMaxReliefPoints> flat_x_mm_{};
  alignas(16) std::array<float, kMaxReliefPoints> flat_y_mm_{};
  alignas(16) std::array<float, kMaxReliefPoints> flat_ray_x_{};
  alignas(16) std::array<float, kMaxReliefPoints> flat_ray_y_{};
  std::array<std::uint8_t, kMaxReliefPoints> flat_weight_{};
  Points inflated_mm_{};  // z of the silhouette inflated
  Slopes inflated_slopes_;
  alignas(16) std::array<float, kMaxReliefPoints> about_mm_{};  // z that depths are tried about
  Points is_target_{};                                          // 1, or 0 where it looks like background

  // Carried over.
  Points z_mm_{};
  Points known_{};   // how well, in the unit of the normal equations
  Transform T_M_C_;  // the candidate's pose in the model in use
  Transform T_H_F_;  // the flat model's on the last frame of a young relief
  ReliefState state_ = ReliefState::kFlat;
  int frames_ = 0;
  int tries_ = 0;
  bool again_ = false;  // learned anew from a better view
  double aside_ = 0;    // how far beside the photo's the views were that it was learned from: the least
  Vector3 last_view_ = Vector3::Zero();
  int steady_ = 0;        // frames in a row that showed the same view as the one before
  bool is_anew_ = false;  // within learn_anew()
  Points before_z_mm_{};  // and before it
  Points before_known_{};
  int better_ = 0;  // frames in a row that the candidate explained better before it learned from them

  // The frame.
  std::array<ReliefSample, kMaxReliefPoints> left_;
  std::array<ReliefSample, kMaxReliefPoints> right_;
  std::array<std::array<float, 4>, kMaxReliefPoints> photo_{};  // as it looks in the light of the frame
  ShadeField shade_;
  std::array<Light, 3> light_;  // of the pairings
  Matrix6 H_;                   // normal equations: pose with pose
  Vector6 g_;
  std::array<std::array<double, kMaxReliefPoints>, 6> coupling_{};  // pose with z
  Points stiffness_{};                                              // z with itself
  Points pull_{};                                                   // right-hand side of z
  Points data_{};                                                   // stiffness of the images alone
  std::array<std::array<double, kReliefNeighbours>, kMaxReliefPoints> bond_{};
  double mean_bond_ = 0;
  double trend_bond_x_ = 0;
  double trend_bond_y_ = 0;
  double target_points_ = 0;
  std::array<std::array<float, kMaxReliefPoints>, kReliefHypotheses> sweep_{};  // cost of each depth tried
  std::array<float, kMaxReliefPoints> kept_{};                                  // and of the depth it has
  Points dz_mm_{};
  Points residual_{};
  Points direction_{};
  Points product_{};
};

}  // namespace vergence
