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
