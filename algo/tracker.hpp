// The pose of the target, frame after frame: planes from images, prediction by motion feed-forward,
// evolution, refinement, and what the outcome is worth [3.5, 3.6.4, 5.4].
//
// Per frame: begin_frame() once, evolve() as often as the budget allows, end_frame() once. The budget lies
// with the caller: a number of generations (deterministic) or a clock.
#pragma once

#include <cstdint>

#include "algo/camera_model.hpp"
#include "algo/colour_pyramid.hpp"
#include "algo/correlation.hpp"
#include "algo/fitness.hpp"
#include "algo/hue_plane.hpp"
#include "algo/image.hpp"
#include "algo/light_follower.hpp"
#include "algo/motion_predictor.hpp"
#include "algo/photo_confidence.hpp"
#include "algo/photo_likeness.hpp"
#include "algo/refine.hpp"
#include "algo/refine_marker.hpp"
#include "algo/relief.hpp"
#include "algo/rm_ga.hpp"
#include "algo/status.hpp"
#include "algo/target_model.hpp"

namespace vergence {

enum class TargetKind : std::uint8_t {
  kMarker,
  kPhoto,
};

enum class Method : std::uint8_t {
  kVergence,  // this library's way
  kThesis,    // votes of hue alone, binary genes, no gate, planar model: for comparison
};

enum class TrackState : std::uint8_t {
  kSearching,  // not found yet
  kTracking,
  kLost,  // was tracked, or was searched for in vain
};

[[nodiscard]] const char* to_string(TrackState state);

// What a pose goes through within a frame; each takes up what the one before found.
enum class Stage : std::uint8_t {
  kEvolved,  // by RM-GA
  kRefined,  // below the plateau of the votes
  kRelief,   // refined on the learned relief of the photo-model
};

struct TrackerSettings {
  Method method = Method::kVergence;
  std::uint64_t seed = 1;
  SearchBox box;
  GaSettings ga;
  Stage last_stage = Stage::kRelief;  // later ones are left out, for comparison
  HueLimits hue_limits;
  // Around the prediction while tracking, in place of the search box; position in mm and e.
  double follow_mm = 30;
  double follow_e = 0.12;
};

// Defaults of a method for a kind of target: coding, mutation rate, saturation gate.
[[nodiscard]] TrackerSettings default_settings(Method method, TargetKind kind);

// What is known of the own motion when a frame was taken.
struct FrameMotion {
  double t_s = 0;
  Transform T_W_H;   // pose of the hand; constant where the hand stands still or is unknown
  Transform T_H_CL;  // pose of the left camera in the hand at this frame
  Transform T_H_CR;  // and of the right
};

struct Estimate {
  Pose pose;  // T_H_M: the target in the hand frame
  // Of [x y z e1 e2 e3], mm and 1, from the normal equations of refinement and, for a photo-model, what is
  // not known of its shape; zero where the pose was not refined.
  Matrix6 covariance = Matrix6::Zero();
  double fitness = 0;     // Eq. 3.22 or 5.19 at that pose
  double confidence = 0;  // in [0, 1]
  TrackState state = TrackState::kSearching;
  int generations = 0;           // evolved in this frame
  std::int64_t evaluations = 0;  // poses evaluated in this frame
};

// One large object (tens of megabytes): place it statically. It never allocates.
class Tracker {
 public:
  // Errors: kBadCamera, kBadSearchBox, kBadModel (no points or balls).
  [[nodiscard]] Status configure(const StereoRig& rig, const MarkerModel& model,
                                 const TrackerSettings& settings);
  [[nodiscard]] Status configure(const StereoRig& rig, const PhotoModel& model,
                                 const TrackerSettings& settings);

  // Takes a new pair of images and moves the population to where the target is expected. Images may be reused
  // as soon as this returns. kBadImage where size or format is not the rig's; the frame is then to be left
  // out. Equal `frame` numbers with equal seeds draw equal random numbers.
  [[nodiscard]] Status begin_frame(std::uint64_t frame, const ImageView& left, const ImageView& right,
                                   const FrameMotion& motion);

  // One generation. `progress` in [0, 1) is the share of this frame's budget that is spent: it decides when
  // searching wide gives way to settling.
  void evolve(double progress);

  // Refines the fittest, judges it and carries the population over.
  [[nodiscard]] Estimate end_frame();

  // Forgets target, velocity and population: the next frame starts from nothing.
  void forget();
  // And what was learned of the target itself, its relief.
  void unlearn();

  // Generations this frame is worth, where the caller has no wish of its own. To be asked again after each: a
  // target that turns out to be gone is worth a search in the same frame.
  [[nodiscard]] int usual_generations() const;

  // Fitness of Eq. 3.22 or 5.19 of any pose T_H_M on the images of the last begin_frame().
  [[nodiscard]] double fitness_at(const Pose& pose) const;

  [[nodiscard]] TrackState state() const { return state_; }

  // Whether this frame stays about where the target is expected; otherwise it searches the whole box.
  [[nodiscard]] bool is_following() const { return following_; }
  // The photo-model as it is used now, and how its relief came along. A relief is kept until configure(): a
  // target lost and found again has it still.
  [[nodiscard]] const PhotoModel& photo_model() const { return photo_; }
  [[nodiscard]] ReliefState relief_state() const { return relief_.state(); }
  // What bears out the last estimate; a photo-model's, Method::kVergence.
  [[nodiscard]] PhotoEvidence photo_evidence() const { return photo_evidence_of(T_H_M_last_); }

 private:
  // What a pose is scored by.
  enum class Measure : std::uint8_t {
    kVotes,   // of hue: the marker, and the thesis's method
    kSearch,  // correlation of few points at low resolution
    kSettle,  // of more points
    kJudge,   // of many points at half resolution
  };
  // That a photo-model is searched for in, as long as it may be a solid's.
  static constexpr unsigned kShapes = 2;
  // A pose, and how much the model is inflated there.
  struct Shaped {
    Pose pose;
    double inflation = 0;
  };

  [[nodiscard]] Status configure_common(const StereoRig& rig, const TrackerSettings& settings);
  [[nodiscard]] std::int64_t score(const Transform& T_H_M, Measure measure) const;
  [[nodiscard]] std::int64_t score(const Chromosome& chromosome, Measure measure);
  [[nodiscard]] Measure followed_measure() const;
  [[nodiscard]] bool is_gone() const;
  [[nodiscard]] bool is_doubtful() const;
  [[nodiscard]] bool is_confirmed(const Transform& T_H_M) const;
  void start_search();
  void start_rescue();
  void clear_archives();
  void scout();
  void evolve_search();
  [[nodiscard]] Chromosome draw_place();
  [[nodiscard]] Chromosome turned(const Chromosome& place);
  void settle();
  void merge_archives();
  void merge_archive(const Population& archive, const Population& running);
  void polish_archive();
  void keep_in_archive(const Individual& individual);
  [[nodiscard]] Transform refine_best();
  void build_measures();
  void put_before_backdrop(bool limited_range);
  void assess_photo(const Transform& T_H_M);
  [[nodiscard]] Transform refine_best_photo();
  [[nodiscard]] bool may_be_solid() const;
  void lay_relief_aside();
  void take_relief_up();
  [[nodiscard]] Transform with_or_without_relief(const Transform& T_H_M);
  void inflate(double share);
  void search_in_shape(unsigned shape);
  [[nodiscard]] double search_inflation() const;
  [[nodiscard]] Transform best_beside(const Transform& T_H_M);
  [[nodiscard]] Transform best_inflation(const Transform& T_H_M);
  [[nodiscard]] Transform finely_refined(Transform T_H_M);
  [[nodiscard]] bool will_be_believed(const Transform& T_H_M);
  [[nodiscard]] Transform found_or_followed(const Transform& found_T_H_M);
  [[nodiscard]] double photo_confidence_of(const Transform& T_H_M) const;
  [[nodiscard]] PhotoEvidence photo_evidence_of(const Transform& T_H_M) const;
  [[nodiscard]] double marker_confidence_of(const Transform& T_H_M) const;
  [[nodiscard]] Matrix6 marker_covariance() const;
  [[nodiscard]] Matrix6 photo_covariance(const Transform& T_H_M) const;
  void start_first_generation();
  [[nodiscard]] bool has_looked_everywhere() const;
  [[nodiscard]] MarkerSight marker_sight(bool of_left) const;
  [[nodiscard]] Transform refine_best_marker();
  [[nodiscard]] Transform pivoted(const MarkerFit& fit) const;
  void follow_light(const Transform& T_H_M);
  void expect_light();
  void learn_relief(Transform& T_H_M);
  [[nodiscard]] double confidence_of(const Transform& T_H_M) const;
  void update_state(double confidence);
  [[nodiscard]] bool is_thesis() const { return settings_.method == Method::kThesis; }
  [[nodiscard]] Measure search_measure() const;
  [[nodiscard]] Measure settle_measure() const;

  TargetKind kind_ = TargetKind::kMarker;
  TrackerSettings settings_;
  StereoRig rig_;  // T_H_C of the frame
  MarkerModel marker_;
  PhotoModel photo_;
  // Hues of the two as they were configured; those in them follow the light.
  std::array<std::uint8_t, kMaxBalls> marker_hue_{};
  std::array<std::uint8_t, kMaxPhotoPoints> photo_hue_{};
  std::uint8_t photo_background_hue_ = kHueUndefined;
  std::array<PointColours, kColourLevels> as_photographed_;  // of the photo-model
  CorrelationModel search_model_;
  CorrelationModel settle_model_;
  CorrelationModel judge_model_;

  // The frame.
  HuePlane hue_left_;
  HuePlane hue_right_;
  YuvHueTable hue_table_;
  ColourPyramid colour_left_;
  ColourPyramid colour_right_;
  std::array<CameraModel, kColourLevels> camera_left_;
  std::array<CameraModel, kColourLevels> camera_right_;
  Transform T_CL_H_;
  Transform T_CR_H_;
  bool yuv_ = false;  // the images are; a marker's colours are kept as they come
  FrameMotion motion_;
  CounterRandom random_;
  int generations_ = 0;
  std::int64_t evaluations_ = 0;
  bool settling_ = false;
  bool following_ = false;  // the population stays about the expected pose
  bool rescuing_ = false;   // it did, in vain or only just, and searches everywhere now
  bool doubting_ = false;   // only just: to see whether there is anything better
  Transform rescue_pose_;   // where it had got to
  // Of the pose that assess_photo() was shown last.
  Alignment photo_alignment_;
  PhotoLikeness likeness_left_;
  PhotoLikeness likeness_right_;

  // Carried over.
  MotionPredictor predictor_;
  Transform T_H_M_last_;  // the last estimate
  SearchBox box_;         // that the chromosomes of population and archive are written in
  Population population_;
  std::array<Population, kShapes> archive_;  // the best of each epoch of a search, for each shape
  unsigned shape_ = 0;                       // of the running epoch
  Shaped lesser_;                            // the best of the archive that is not settled
  bool population_ready_ = false;
  int epoch_generation_ = 0;
  int epochs_ = 0;        // ended since the search began
  int searches_ = 0;      // frames in a row that searched the whole box
  double inflation_ = 0;  // of the photo-model in use, where it has no relief
  Population scouts_;     // of the whole box, while a target is followed
  int scout_generation_ = 0;
  std::int64_t followed_score_ = 0;  // of the last estimate
  int frames_tracked_ = 0;           // since the target was found
  TrackState state_ = TrackState::kSearching;
  LightFollower light_;
  RefineWorkspace workspace_;

  MarkerFit marker_fit_;       // of this frame
  Relief relief_;              // of the photo-model; survives forget()
  bool relief_aside_ = false;  // this frame searches as if nothing had been learned
  PhotoModel with_relief_;     // the photo-model, as long as it is
};

}  // namespace vergence
