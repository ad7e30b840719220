#include "tools/demo/experiments.hpp"
#include "tools/demo/scenario.hpp"

namespace vergence::demo {
namespace {

constexpr Scenario kScenarios[] = {
    {"lateral-known", "Lateral servoing, the pose given",
     "The marker sways 150 mm to each side; where it is, is given. What is left is how well hand and eyes "
     "are "
     "controlled [section 4.1.2].",
     lateral_known},
    {"lateral-3dof", "Lateral servoing, the position seen",
     "The marker sways 150 mm to each side; x, y and z come from the cameras, the orientation is given "
     "[section 4.1.3].",
     lateral_3dof},
    {"lateral-6dof", "Lateral servoing, the pose seen",
     "The marker sways 150 mm to each side; all six of its pose come from the cameras [section 4.1.4].",
     lateral_6dof},
    {"fitness-light", "The marker's fitness under six lights",
     "The marker stands still; its fitness is mapped over x and z, millimetre by millimetre, under six "
     "conditions of "
     "light and background [section 4.2.1].",
     fitness_light},
    {"arc-swing", "A swinging marker under changing light",
     "The marker swings by 20 degrees to each side on a turntable while lamps of 80, 500, 900 and 2200 lx "
     "take "
     "turns; eyes and hand follow [section 4.2.2].",
     arc_swing},
    {"fitness-12", "Twelve sea creatures, each from one photo",
     "Each creature stands still before the cameras: its fitness is mapped about the truth, and its pose is "
     "found from "
     "nothing [section 5.5].",
     fitness_twelve},
    {"track-20", "A crab goes through twenty steps",
     "The hand is still; a crab moves along x, y, z and turns about its axes, at 50 mm/s and 10 deg/s "
     "[section 6.1].",
     track_twenty},
    {"servo-position", "The hand follows a wandering crab",
     "A crab moves by 100 mm along three axes at once; the hand keeps 500 mm before it, by one photo of it "
     "[section 6.2.1].",
     servo_position},
    {"servo-orientation", "The hand follows a turning crab",
     "A crab turns by 25 degrees about its three axes, one after the other; the hand keeps facing it "
     "[section 6.2.2].",
     servo_orientation},
    {"pool", "A pen dropped on a squid",
     "A squid floats under rippled water, is hidden and pushed by a stick; the hand comes down to 600 mm "
     "over it and "
     "drops a pen [section 6.3].",
     pool},
    {"photo-vergence", "Photo-model with eyes that follow",
     "A crab swims about; hand and pan-tilt eyes both follow it, by one photo: the thesis's future work.",
     photo_vergence},
    {"teleport", "The target jumps",
     "A crab is suddenly elsewhere, four times; it is found again and followed.", teleport},
    {"shove", "The hand is pushed", "The arm is hit three times while the hand follows a crab.", shove},
    {"drop-outs", "Pictures are lost",
     "A tenth of the pictures is lost, and all of them for 0.1, 0.5 and 2 s, while the hand follows a crab.",
     drop_outs},
};

}  // namespace

std::span<const Scenario> scenarios() {
  return kScenarios;
}

const Scenario* find_scenario(const std::string& name) {
  for (const Scenario& scenario : kScenarios) {
    if (name == scenario.name) return &scenario;
  }
  return nullptr;
}

}  // namespace vergence::demo
