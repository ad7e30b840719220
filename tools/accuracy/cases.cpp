#include <array>
#include <initializer_list>

#include "tools/accuracy/case.hpp"

namespace vergence::accuracy {
namespace {

constexpr std::array<const char*, 6> kLights{"500lx", "30lx", "80lx", "1000lx", "2500lx", "lamp-moved"};
constexpr std::array<const char*, 12> kCreatures{"C12", "C05", "C02", "C07", "C01", "C03",
                                                 "C04", "C06", "C08", "C09", "C10", "C11"};

std::string joined(std::initializer_list<std::string> parts) {
  std::string text;
  for (const std::string& part : parts) text += part;
  return text;
}

std::string light(const std::string& preset) {
  return "light.preset = \"" + preset + "\"\n";
}

std::string creature(const std::string& code) {
  return "target.creature = \"" + code + "\"\n";
}

const std::string kColoured = "background.hue_deg = 50\nbackground.saturation = 0.55\n";
const std::string kCluttered =
    "background.kind = \"clutter\"\nbackground.objects = 60\n"
    "background.hues_deg = [0, 30, 60, 120, 180, 240, 300]\n";
// The whole of the thesis's boxes, as far as both eyes see the target.
const std::string kMarkerBox =
    "motion.amplitude = [200, 100, 200, 0.35, 0.35, 0.35]\nmotion.in_view = true\n";
const std::string kPhotoBox =
    "motion.pose = [0, 0, 500, 0, 0, 0]\nmotion.amplitude = [180, 180, 180, 0.35, 0.35, 0.35]\n"
    "motion.in_view = true\n";
const std::string kPlainWall = "background.kind = \"noise\"\n";

RenderedSet cold_marker(SuiteSize size) {
  return {"cold_marker", "marker_random", kMarkerBox + kPlainWall, size.frames(100, 25)};
}
RenderedSet cold_marker_clutter(SuiteSize size) {
  return {"cold_marker_clutter", "marker_random", kMarkerBox + "seed = 2\n", size.frames(100, 25)};
}
RenderedSet cold_creature(const std::string& code, SuiteSize size) {
  return {"cold_" + code, "photo_random", kPhotoBox + creature(code), size.frames(50, 15)};
}
// Photographed before blue, looked for before something else.
struct OtherBackground {
  const char* code;
  const char* scene;
};
constexpr std::array<OtherBackground, 4> kOtherBackgrounds{
    {{"C12", "background.hue_deg = 30\n"},
     {"C05", "background.hue_deg = 50\nbackground.saturation = 0.1\nbackground.value = 0.95\n"},
     {"C02", "background.hue_deg = 120\n"},
     {"C07", "background.hue_deg = 30\nbackground.kind = \"clutter\"\n"}}};
RenderedSet elsewhere(const OtherBackground& other, SuiteSize size) {
  const std::string photo =
      "model.background.hue_deg = 212\nmodel.background.saturation = 0.65\nmodel.background.value = 0.62\n";
  return {std::string("elsewhere_") + other.code, "photo_random",
          joined({"seed = 5\n", kPhotoBox, creature(other.code), other.scene, photo}), size.frames(50, 15)};
}
RenderedSet path_of(const std::string& code, SuiteSize size) {
  // At 8 frames a second, so that twenty steps take minutes neither to render nor to follow.
  const std::string patch = creature(code) + "image.fps = 8\nmotion.rest_s = 0.2\n";
  return {"path_" + code, "crab_track20", patch, size.frames(310, 130)};
}
RenderedSet lateral(const std::string& speed, SuiteSize size) {
  return {"marker_lateral_" + speed, "marker_lateral_" + speed, "", size.frames(150, 30)};
}
RenderedSet still_marker(SuiteSize size) {
  return {"marker_still", "marker_still", "", size.frames(45, 15)};
}
RenderedSet still_creature(const std::string& code, SuiteSize size) {
  return {"still_" + code, "creatures", creature(code), size.frames(45, 40)};
}

}  // namespace

std::vector<Case> marker_cases(SuiteSize size) {
  std::vector<Case> cases{{kMarker, still_marker(size)}};
  for (const char* speed : {"slow", "medium", "fast"}) cases.push_back({kMarker, lateral(speed, size)});
  for (const char* preset : kLights) {
    for (const auto& [name, patch] : {std::pair<std::string, std::string>{"neutral", ""},
                                      {"coloured", kColoured},
                                      {"clutter", kCluttered}}) {
      if (size.quick && name != "neutral" && std::string(preset) != "500lx") continue;
      cases.push_back({kMarker,
                       {std::string("marker_") + preset + "_" + name, "marker_lateral_medium",
                        light(preset) + patch, size.frames(24, 10)}});
    }
  }
  cases.push_back({kMarkerBar, {"marker_bar", "marker_occluded", "", size.frames(90, 90)}});
  cases.push_back(
      {kMarkerBar,
       {"marker_bar_lateral", "marker_occluded",
        "motion.kind = \"sine\"\nmotion.amplitude = [60, 0, 0, 0, 0, 0]\nmotion.omega_rad_s = 0.628\n",
        size.frames(90, 90)}});
  return cases;
}

std::vector<Case> photo_cases(SuiteSize size) {
  std::vector<Case> cases;
  for (std::size_t i = 0; i < (size.quick ? 4 : kCreatures.size()); ++i) {
    cases.push_back({kPhoto, still_creature(kCreatures[i], size)});
  }
  for (std::size_t i = 0; i < (size.quick ? 1 : 2); ++i) {
    cases.push_back({kPhoto, path_of(kCreatures[i], size)});
  }
  const std::string swaying =
      "motion.kind = \"sine\"\nmotion.amplitude = [20, 10, 20, 0.05, 0.05, 0.05]\nmotion.omega_rad_s = "
      "1.256\n";
  for (std::size_t i = 0; i < kLights.size(); ++i) {
    if (size.quick && i % 2 == 0) continue;
    for (const char* code : {"C12", "C07"}) {
      if (size.quick && code != std::string("C12")) continue;
      cases.push_back({kPhoto,
                       {std::string("light_") + kLights[i] + "_" + code, "creatures",
                        creature(code) + light(kLights[i]) + swaying, 45}});
    }
  }
  for (const char* code : {"C12", "C05"}) {
    if (size.quick && code != std::string("C12")) continue;
    cases.push_back({kPhoto, {std::string("bar_") + code, "creature_occluded", creature(code), 120}});
  }
  return cases;
}

std::vector<Case> lock_cases(SuiteSize size) {
  std::vector<Case> cases{{kColdMarker, cold_marker(size), Task::kCold},
                          {kColdMarker, cold_marker_clutter(size), Task::kCold}};
  for (const char* code : {"C12", "C05", "C02", "C07"}) {
    cases.push_back({kColdPhoto, cold_creature(code, size), Task::kCold});
  }
  for (const OtherBackground& other : kOtherBackgrounds) {
    cases.push_back({kElsewhere, elsewhere(other, size), Task::kCold});
  }
  const std::string bar =
      "[[occluder]]\nwidth_mm = 35\nlength_mm = 700\ndirection = [0.25, 1, 0]\n"
      "motion = { kind = \"random\", pose = [0, 0, 300, 0, 0, 0], amplitude = [60, 0, 0, 0, 0, 0] }\n";
  for (const char* preset : {"30lx", "2500lx"}) {
    const std::string dim = light(preset);
    const int frames = size.frames(40, 10);
    cases.push_back(
        {kHard,
         {std::string("hard_marker_") + preset, "marker_random", joined({kMarkerBox, dim, bar}), frames},
         Task::kCold});
    for (const char* code : {"C08", "C09"}) {
      cases.push_back({kHard,
                       {std::string("hard_") + preset + "_" + code, "photo_random",
                        joined({kPhotoBox, creature(code), dim, bar}), frames},
                       Task::kCold});
    }
  }
  // As the scenes say: a jump every eight frames; a board from 0.5 s to 2.5 s.
  const std::vector<int> jumps{8, 16, 24, 32, 40, 48};
  const std::vector<int> board_gone{75};
  cases.push_back({kRelockMarker, {"teleport_marker", "marker_teleport", "", 56}, Task::kRelock, jumps});
  cases.push_back({kRelockMarker, {"board_marker", "marker_board", "", 80}, Task::kRelock, board_gone});
  for (const char* code : {"C12", "C05", "C02"}) {
    if (size.quick && code != std::string("C12")) continue;
    cases.push_back({kRelockPhoto,
                     {std::string("teleport_") + code, "creature_teleport", creature(code), 56},
                     Task::kRelock,
                     jumps});
    cases.push_back({kRelockPhoto,
                     {std::string("board_") + code, "creature_board", creature(code), 80},
                     Task::kRelock,
                     board_gone});
  }
  return cases;
}

std::vector<Case> absent_cases(SuiteSize size) {
  std::vector<Case> cases;
  const auto add = [&](const char* group, const RenderedSet& set, const std::string& model_of) {
    cases.push_back({group, set, Task::kAbsent, {}, model_of});
  };
  const int frames = size.frames(20, 8);
  const auto emptied = [&](const std::string& name, const std::string& scene, const std::string& patch) {
    return RenderedSet{name, scene, "target.absent = true\n" + patch, frames};
  };
  // Clutter of the balls' own hues, another each time; then creatures.
  for (const char* seed : {"11", "12", "13", "14"}) {
    add(kAbsentMarker,
        emptied(std::string("no_marker_") + seed, "marker_random", std::string("seed = ") + seed + "\n"), "");
  }
  add(kAbsentMarker, cold_creature("C12", size), "cold_marker");
  add(kAbsentMarker, cold_creature("C05", size), "cold_marker");
  for (const char* seed : {"21", "22", "23", "24"}) {
    add(kAbsentPhoto,
        emptied(
            std::string("no_C12_") + seed, "photo_random",
            "background.kind = \"clutter\"\nbackground.objects = 120\nseed = " + std::string(seed) + "\n"),
        "");
  }
  for (const char* code : {"C05", "C02", "C07"}) add(kAbsentPhoto, cold_creature(code, size), "cold_C12");
  add(kAbsentPhoto, cold_creature("C12", size), "cold_C05");
  add(kAbsentPhoto, cold_marker_clutter(size), "cold_C07");
  for (const OtherBackground& other : kOtherBackgrounds) {
    add(kAbsentPhoto, elsewhere(other, size), other.code == std::string("C12") ? "cold_C05" : "cold_C12");
  }
  return cases;
}

std::vector<Case> confidence_cases() {
  // Twice those of few colours, and the mobula, which looks like little from the side.
  const std::array<const char*, 16> codes{"C10", "C01", "C03", "C04", "C06", "C08", "C09", "C11",
                                          "C10", "C12", "C05", "C02", "C07", "C02", "C12", "C05"};
  const std::string dense = "background.kind = \"clutter\"\nbackground.objects = 120\n";
  const std::array<std::string, 4> backdrops{"", kCluttered, kColoured, dense};
  const std::array<const char*, 7> lights{"500lx", "1000lx", "500lx",     "80lx",
                                          "900lx", "2500lx", "lamp-moved"};
  std::vector<Case> cases;
  for (std::size_t i = 0; i < codes.size(); ++i) {
    const std::string seed = joined({"seed = ", std::to_string(101 + i), "\n"});
    const std::string& backdrop = backdrops[(i + i / 4) % backdrops.size()];
    cases.push_back(
        {kColdPhoto,
         {"fit_" + std::to_string(i), "photo_random",
          joined({seed, kPhotoBox, creature(codes[i]), light(lights[i % lights.size()]), backdrop}), 40},
         Task::kCold});
  }
  for (std::size_t i = 0; i < codes.size(); ++i) {  // in each other's place
    RenderedSet half = cases[i].set;
    half.frames = 20;
    for (std::size_t k = 0; k < codes.size(); ++k) {
      if (std::string(codes[i]) == codes[k]) continue;
      cases.push_back({kAbsentPhoto, half, Task::kAbsent, {}, cases[k].set.name});
    }
  }
  const std::array<std::string, 6> empty{dense, kCluttered, dense, kCluttered, kPlainWall, kColoured};
  for (std::size_t i = 0; i < empty.size(); ++i) {
    const std::string seed = joined({"seed = ", std::to_string(201 + i), "\n"});
    const RenderedSet set{
        "fit_no_" + std::to_string(i), "photo_random",
        joined({"target.absent = true\n", seed, kPhotoBox, creature(codes[i]), light(lights[i]), empty[i]}),
        12};
    for (std::size_t k = 0; k < 13; ++k) {  // each creature once, the mobula twice
      cases.push_back({kAbsentPhoto, set, Task::kAbsent, {}, cases[k].set.name});
    }
  }
  return cases;
}

std::vector<RenderedSet> generation_sets(SuiteSize size) {
  return {still_marker(size),
          lateral("fast", size),
          still_creature("C12", size),
          path_of("C12", size),
          {"card_flat", "card_flat", "", size.frames(45, 20)}};
}

std::vector<TimedSet> timed_sets(SuiteSize size) {
  return {{cold_marker(size), true},
          {cold_creature("C12", size), true},
          {lateral("fast", size), false},
          {path_of("C12", size), false}};
}

}  // namespace vergence::accuracy
