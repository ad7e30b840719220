// Evolution: the epochs of a search, the archive of their best, following, scouts and rescue.
#include <array>

#include "algo/tracker_parts.hpp"

namespace vergence {
namespace {

// Search: the population is evolved from scratch again and again, an epoch each time; the best of each epoch
// stands in the archive, from which the last part of a frame's budget settles.
struct SearchPlan {
  int epoch_generations;
  int founders;            // drawn for each of the first generation; the fittest of them stays
  int full_search_epochs;  // after so many in vain, the target is not there
  int epochs_anywhere;     // after so many, most take up a place of the archive and turn the target there
  int epochs_in_vain;      // after so many before this frame, the search begins anew: its places may be wrong
  double share;            // of a frame's budget
};
constexpr SearchPlan kMarkerSearch{60, 1, 8, INT32_MAX, INT32_MAX, 0.75};
constexpr SearchPlan kPhotoSearch{30, 8, 24, 30, 120, 0.95};

const SearchPlan& plan_for(TargetKind kind) {
  return kind == TargetKind::kMarker ? kMarkerSearch : kPhotoSearch;
}

constexpr int kSettleMutation_per_1024 = 51;  // half of the searching rate: fewer long jumps

// The thesis: nine generations; ours: what a cold lock takes.
constexpr int kThesisGenerations = 9;
constexpr int kPhotoSearchGenerations = 3900;
constexpr int kMarkerSearchGenerations = 1500;

// A search finds where a target is long before it finds how it is turned. Founders about a place of the
// archive lie this far from it in x and y, and twice as far in z; every kAnywhereEvery-th epoch still looks
// anywhere.
constexpr double kTurn_mm = 40;
constexpr int kAnywhereEvery = 9;

// While following: what the frame before reached, times this, is a target that is no longer where it was
// expected.
constexpr double kGone = 0.75;
// A photo-model is searched for again in the frames after it was found, with a part of the generations of a
// search: what was found first may be something like it, and would be followed.
constexpr int kDoubtfulFrames = 2;
constexpr int kDoubtfulGenerations = kPhotoSearchGenerations / 4 * 3;
// A photo-model without a relief is searched for inflated, some epochs to the one, some to the other: it may
// be flat, or rounder than its silhouette says. The other is one in one frame and one in the next; of so
// round a shape much is hidden as soon as it is turned, and is left out.
constexpr double kLittleInflation = 0.5;
constexpr std::array<double, 2> kMuchInflation{1.5, 2};
constexpr int kEpochsAShape = 4;
// A scout population searches the whole box while a target is followed, some generations a frame.
constexpr int kScoutGenerations = 20;

}  // namespace

int Tracker::usual_generations() const {
  if (is_thesis()) return kThesisGenerations;
  if (following_) return kTrackGenerations;
  const int search = kind_ == TargetKind::kMarker ? kMarkerSearchGenerations : kPhotoSearchGenerations;
  if (doubting_) return kDoubtfulGenerations;
  return rescuing_ ? kTrackGenerations + search : search;
}

Tracker::Measure Tracker::search_measure() const {
  return kind_ == TargetKind::kMarker || is_thesis() ? Measure::kVotes : Measure::kSearch;
}

// Of the pose that is followed: the measure of settling while it is.
Tracker::Measure Tracker::followed_measure() const {
  return kind_ == TargetKind::kMarker ? Measure::kVotes : Measure::kJudge;
}

Tracker::Measure Tracker::settle_measure() const {
  if (kind_ == TargetKind::kMarker || is_thesis()) return Measure::kVotes;
  return following_ ? followed_measure() : Measure::kSettle;
}

double Tracker::search_inflation() const {
  if (shape_ == 0) return kLittleInflation;
  return kMuchInflation[relief_aside_ ? 0 : at(searches_ % 2)];
}

void Tracker::search_in_shape(unsigned shape) {
  shape_ = may_be_solid() ? shape : 0;
  inflate(search_inflation());
}

void Tracker::start_first_generation() {
  if (epochs_ >= plan_for(kind_).epochs_in_vain) start_search();
  search_in_shape(shape_);
  const auto score_search = [this](const Chromosome& c) { return score(c, search_measure()); };
  if (!population_ready_) {
    found_population(population_, is_thesis() ? 1 : plan_for(kind_).founders, random_, score_search);
  } else {
    evaluate_population(population_, score_search);
  }
}

bool Tracker::has_looked_everywhere() const {
  return epochs_ >= plan_for(kind_).full_search_epochs;
}

void Tracker::evolve(double progress) {
  // Once the usual generations have followed it in vain, the rest of the frame's budget looks everywhere.
  if (following_ && generations_ == kTrackGenerations && is_gone()) start_rescue();
  ++generations_;
  if (!is_thesis() && !following_ && progress < plan_for(kind_).share) {
    evolve_search();
    return;
  }
  settle();
  GaSettings ga = settings_.ga;
  if (!is_thesis()) ga.mutation_per_1024 = kSettleMutation_per_1024;
  evolve_generation(population_, ga, random_,
                    [this](const Chromosome& c) { return score(c, settle_measure()); });
}

// Whether what is followed is seen far less well than in the frame before.
bool Tracker::is_gone() const {
  return static_cast<double>(population_.individual[0].score) < kGone * static_cast<double>(followed_score_);
}

// Whether what is followed was found so lately that a second search may find better.
bool Tracker::is_doubtful() const {
  return kind_ == TargetKind::kPhoto && frames_tracked_ <= kDoubtfulFrames;
}

void Tracker::start_search() {
  search_in_shape(0);
  box_ = settings_.box;
  clear_archives();
  population_ready_ = false;
}

void Tracker::clear_archives() {
  for (Population& archive : archive_) {
    archive = Population{};
    for (Individual& individual : archive.individual) individual.score = INT64_MIN;
  }
  epoch_generation_ = 0;
  epochs_ = 0;
}

void Tracker::start_rescue() {
  rescue_pose_ = to_transform(decode(population_.individual[0].chromosome, box_, settings_.ga.coding));
  following_ = false;
  rescuing_ = true;
  start_search();
  found_population(population_, plan_for(kind_).founders, random_,
                   [this](const Chromosome& c) { return score(c, search_measure()); });
  population_ready_ = true;
}

// Some generations of a population that has nothing to do with the target that is followed. The best of an
// epoch, where it is fitter than what is followed, and elsewhere, makes the frame a search.
void Tracker::scout() {
  const auto score_search = [this](const Chromosome& c) {
    ++evaluations_;
    return score(to_transform(decode(c, settings_.box, settings_.ga.coding)), search_measure());
  };
  if (scout_generation_ == 0) {
    found_population(scouts_, plan_for(kind_).founders, random_, score_search);
  } else {
    evaluate_population(scouts_, score_search);
  }
  for (int g = 0; g < kScoutGenerations; ++g) {
    evolve_generation(scouts_, settings_.ga, random_, score_search);
  }
  scout_generation_ += kScoutGenerations;
  if (scout_generation_ < plan_for(kind_).epoch_generations) return;
  scout_generation_ = 0;
  const Pose found = decode(scouts_.individual[0].chromosome, settings_.box, settings_.ga.coding);
  const Pose followed = decode(population_.individual[0].chromosome, box_, settings_.ga.coding);
  const auto mark = static_cast<double>(score(to_transform(followed), search_measure()));
  const auto scouted = static_cast<double>(scouts_.individual[0].score);
  if (distinct(found, followed) && clearly_fitter(scouted, mark)) {
    start_rescue();
    archive_[0].individual[0] = {encode(found, box_, settings_.ga.coding), scouts_.individual[0].score};
  }
}

void Tracker::evolve_search() {
  const auto score_search = [this](const Chromosome& c) { return score(c, search_measure()); };
  if (epoch_generation_ == plan_for(kind_).epoch_generations) {
    keep_in_archive(population_.individual[0]);
    ++epochs_;
    epoch_generation_ = 0;
    search_in_shape(at(epochs_ / kEpochsAShape) % kShapes);
    const bool nowhere = archive_[shape_].individual[0].score == INT64_MIN;
    if (nowhere || epochs_ < plan_for(kind_).epochs_anywhere || epochs_ % kAnywhereEvery == 0) {
      found_population(population_, plan_for(kind_).founders, random_, score_search);
    } else {
      const Chromosome place = draw_place();
      found_population_from(
          population_, plan_for(kind_).founders, [&] { return turned(place); }, score_search);
    }
  }
  ++epoch_generation_;
  evolve_generation(population_, settings_.ga, random_, score_search);
}

// A member of the archive, which fills from its front.
Chromosome Tracker::draw_place() {
  const Population& archive = archive_[shape_];
  std::uint32_t members = 0;
  for (const Individual& member : archive.individual) members += member.score > INT64_MIN ? 1 : 0;
  return archive.individual[random_.below(members)].chromosome;
}

// About the place of another chromosome, turned anyhow.
Chromosome Tracker::turned(const Chromosome& place) {
  Pose pose = decode(random_chromosome(random_), box_, settings_.ga.coding);
  const Pose about = decode(place, box_, settings_.ga.coding);
  for (int i = 0; i < 3; ++i) {
    const double share = (pose.position_mm[i] - box_.centre[at(i)]) / box_.half_range[at(i)];
    pose.position_mm[i] = about.position_mm[i] + share * kTurn_mm * (i == 2 ? 2 : 1);
  }
  return encode(pose, box_, settings_.ga.coding);
}

// Each place has one member of the archive, the best that was found there.
void Tracker::keep_in_archive(const Individual& individual) {
  const Pose pose = decode(individual.chromosome, box_, settings_.ga.coding);
  Population& archive = archive_[shape_];
  unsigned replaced = 0;
  for (unsigned i = 0; i < kPopulation; ++i) {
    const Individual& member = archive.individual[i];
    if (member.score > INT64_MIN && !distinct(decode(member.chromosome, box_, settings_.ga.coding), pose)) {
      replaced = i;
      break;
    }
    if (member.score < archive.individual[replaced].score) replaced = i;
  }
  if (individual.score > archive.individual[replaced].score) archive.individual[replaced] = individual;
}

void Tracker::settle() {
  if (!is_thesis() && !following_ && !settling_) merge_archives();
  settling_ = true;
}

// The shape that fits better is settled; the best in the other is kept as a guess.
void Tracker::merge_archives() {
  const Population running = population_;
  const unsigned shape = shape_;
  merge_archive(archive_[shape], running);
  if (!may_be_solid()) return;
  const Population settling = population_;
  const double inflation = inflation_;
  search_in_shape(kShapes - 1 - shape);
  merge_archive(archive_[shape_], running);
  const bool other_fits = population_.individual[0].score > settling.individual[0].score;
  const Individual& lesser = (other_fits ? settling : population_).individual[0];
  lesser_ = {decode(lesser.chromosome, box_, settings_.ga.coding), other_fits ? inflation : inflation_};
  if (other_fits) return;
  population_ = settling;
  search_in_shape(shape);
}

// The population becomes the archive, each member polished.
void Tracker::merge_archive(const Population& archive, const Population& running) {
  // The running epoch's best stand in for the epochs that have not ended yet.
  population_ = archive;
  int next = 0;
  for (Individual& individual : population_.individual) {
    if (individual.score == INT64_MIN) individual = running.individual[at(next++)];
  }
  population_.individual[kPopulation - 1] = running.individual[0];
  if (search_measure() == Measure::kSearch) polish_archive();
  evaluate_population(population_, [this](const Chromosome& c) { return score(c, settle_measure()); });
}

}  // namespace vergence
