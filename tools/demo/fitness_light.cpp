// Section 4.2.1: the fitness of the marker over x and z under six conditions; is its peak where the marker
// is?
#include <algorithm>
#include <cmath>

#include "tools/demo/experiments.hpp"
#include "tools/demo/measures.hpp"
#include "tools/demo/still_sight.hpp"

namespace vergence::demo {
namespace {

struct Condition {
  const char* name;
  const char* light;
  const char* background;
};

constexpr const char* kWall = "hue_deg = 45\nsaturation = 0.12\nvalue = 0.60\n";
constexpr const char* kPainted =
    "kind = \"clutter\"\nhue_deg = 200\nsaturation = 0.5\nhues_deg = [30, 60, 180, 200, 300]\n";

constexpr Condition kConditions[] = {{"a: 30 lx", "30lx", kWall},
                                     {"b: 500 lx", "500lx", kWall},
                                     {"c: 1000 lx", "1000lx", kWall},
                                     {"d: 2500 lx", "2500lx", kWall},
                                     {"e: lamp moved", "lamp-moved", kWall},
                                     {"f: 2500 lx, painted background", "2500lx", kPainted}};

}  // namespace

Outcome fitness_light(const RunOptions& options) {
  Outcome outcome{tools::LogTable({"condition", "x_mm", "z_mm", "fitness"}), 0, {}, {}, {}};
  std::vector<tools::HeatMap> maps;
  std::vector<tools::Picture> eyes;
  const Pose truth{{0, -100, 545}, Vector3::Zero()};
  double worst_mm = 0;
  double worst_z_mm = 0;
  double at_500 = 0;
  int number = 0;
  for (const Condition& condition : kConditions) {
    const std::string scene = std::string("[rig]\nkind = \"eyes\"\n[target]\nkind = \"marker\"\n[motion]\n") +
                              "pose = [0, -100, 545, 0, 0, 0]\n[light]\npreset = \"" + condition.light +
                              "\"\n[background]\n" + condition.background;
    StillSight sight("condition-" + std::string(1, condition.name[0]), scene, options);
    (void)sight.look(0, false);
    // Every millimetre, as the thesis has it.
    const FitnessMap map = map_fitness(sight, truth, {0, {"x [mm]", -100, 1, 201}},
                                       {2, {"z [mm]", 350, 1, 401}}, condition.name);
    const Vector3 off = map.peak.position_mm - truth.position_mm;
    worst_mm = std::max(worst_mm, std::abs(off[0]));
    worst_z_mm = std::max(worst_z_mm, std::abs(off[2]));
    if (number == 1) at_500 = map.peak_fitness;
    outcome.metrics.push_back(at_least(std::string("peak_") + condition.name[0], map.peak_fitness, "",
                                       std::nullopt,
                                       number == 1 ? std::optional<std::string>("0.85") : std::nullopt,
                                       std::string("of 1.67; ") + condition.name));
    for (std::size_t i = 0; i < map.figure.values.size(); ++i) {
      const int columns = map.figure.x.count;
      outcome.log.append({static_cast<double>(number), map.figure.x.value(static_cast<int>(i) % columns),
                          map.figure.y.value(static_cast<int>(i) / columns), map.figure.values[i]});
    }
    maps.push_back(map.figure);
    eyes.push_back(
        sight.draw(options.out / ("condition_" + std::string(1, condition.name[0]) + ".png"), map.peak,
                   std::string(condition.name) + ": the marker at the peak (magenta), and as it is (white)"));
    ++number;
    if (options.progress)
      options.progress(static_cast<double>(number) / static_cast<double>(std::size(kConditions)));
  }
  outcome.metrics.insert(
      outcome.metrics.begin(),
      {at_least("peak_at_500lx", at_500, "", 0.85, "0.85", "highest fitness at 500 lx; at most 1.67"),
       at_most("peak_off_x_mm", worst_mm, "mm", 5, "4", "peak from truth along x, the worst of six"),
       at_most("peak_off_z_mm", worst_z_mm, "mm", 10, "5", "the same along z")});
  tools::write_heat_map_grid(options.out / "maps.png", "Fitness [Eq. 3.22] over x and z", maps, 3);
  outcome.pictures.push_back(
      {options.out / "maps.png", "As Fig. 4.10: each millimetre, the other four at the truth."});
  outcome.pictures.insert(outcome.pictures.end(), eyes.begin(), eyes.end());
  outcome.notes.emplace_back(
      "These are the votes of hue alone. What the controller acts on is refined below their plateau.");
  return outcome;
}

}  // namespace vergence::demo
