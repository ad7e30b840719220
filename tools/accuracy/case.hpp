// What the accuracy suite runs: data sets, what is done with each, and which claim it speaks for.
#pragma once

#include <string>
#include <vector>

namespace vergence::accuracy {

// A scene of tools/render/scenes/, changed by `patch` (TOML), rendered once.
struct RenderedSet {
  std::string name;   // of its directory
  std::string scene;  // file, without .toml
  std::string patch;
  int frames = 1;
};

enum class Task {
  kFollow,  // every frame from what the one before left
  kCold,    // every frame from nothing; where it is not found, the same pair again, three times in all
  kRelock,  // as kFollow; counted is how fast it is found again after `events`
  kAbsent,  // as kFollow, with the model of a target that is not there
};

struct Case {
  std::string group;  // data sets that one claim is about, as the page names them
  RenderedSet set;
  Task task = Task::kFollow;
  std::vector<int> events{};  // kRelock: frames in which the target is seen anew
  std::string model_of{};     // kAbsent: the data set whose model and search box are used; empty: its own
  bool unlearned = false;     // kCold: no look has a relief from the one before
  int stay = 0;               // kCold: each look goes on for so many frames; 0: until it is found
};

// Names of the groups.
inline constexpr const char* kMarker = "marker";
inline constexpr const char* kMarkerBar = "marker behind a bar";
inline constexpr const char* kPhoto = "photo-model of a solid";
inline constexpr const char* kColdMarker = "marker from nothing";
inline constexpr const char* kColdPhoto = "photo-model from nothing";
inline constexpr const char* kElsewhere = "photo-model before another background than its photo's";
inline constexpr const char* kHard = "hard views";  // dim, covered in part: for confidence alone
inline constexpr const char* kRelockMarker = "marker found again";
inline constexpr const char* kRelockPhoto = "photo-model found again";
inline constexpr const char* kAbsentMarker = "no marker";
inline constexpr const char* kAbsentPhoto = "no such solid";

struct SuiteSize {
  bool quick = false;
  [[nodiscard]] int frames(int full, int few) const { return quick ? few : full; }
};

[[nodiscard]] std::vector<Case> marker_cases(SuiteSize size);
[[nodiscard]] std::vector<Case> photo_cases(SuiteSize size);
[[nodiscard]] std::vector<Case> lock_cases(SuiteSize size);  // kCold, kRelock
[[nodiscard]] std::vector<Case> absent_cases(
    SuiteSize size);  // of the sets of lock_cases(), and emptied ones
// What photo_confidence() is fitted to: with seeds that no other case has.
[[nodiscard]] std::vector<Case> confidence_cases();
// Error against generations, and time a frame.
[[nodiscard]] std::vector<RenderedSet> generation_sets(SuiteSize size);

struct TimedSet {
  RenderedSet set;
  bool cold = false;
};
[[nodiscard]] std::vector<TimedSet> timed_sets(SuiteSize size);

}  // namespace vergence::accuracy
