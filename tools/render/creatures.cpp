#include "tools/render/creatures.hpp"

#include <array>

#include "tools/render/random.hpp"

namespace vergence::render {
namespace {

// Sizes of Fig. 5.2, l x w x h in cm. h is the thickness along the viewing axis; l and w are laid along x or
// y as the animal is best seen.
const std::array<Creature, 12> kCreatures{{
    {"C01", "seahorse", {45, 130, 27}, build_seahorse},
    {"C02", "coelacanth", {145, 70, 60}, build_coelacanth},
    {"C03", "moray", {142, 30, 23}, build_moray},
    {"C04", "dolphin", {60, 80, 45}, build_dolphin},
    {"C05", "squid", {82.5, 210, 45}, build_squid},
    {"C06", "jellyfish", {90, 90, 110}, build_jellyfish},
    {"C07", "turtle", {132, 105, 30}, build_turtle},
    {"C08", "octopus", {125, 143, 35}, build_octopus},
    {"C09", "anemonefish", {120, 36, 50}, build_anemonefish},
    {"C10", "mobula", {100, 80, 20}, build_mobula},
    {"C11", "ray", {150, 85, 15}, build_ray},
    {"C12", "crab", {175, 140, 40}, build_crab},
}};

}  // namespace

std::span<const Creature> creatures() {
  return kCreatures;
}

const Creature* find_creature(std::string_view name) {
  for (const Creature& creature : kCreatures) {
    if (creature.code == name || creature.name == name) return &creature;
  }
  return nullptr;
}

Mesh make_creature(const Creature& creature, double cell_mm) {
  Sculpture sculpture;
  creature.build(sculpture);
  const auto number = static_cast<std::uint64_t>(&creature - kCreatures.data()) + 1;
  return sculpture.mesh(creature.size_mm, cell_mm, number);
}

}  // namespace vergence::render
