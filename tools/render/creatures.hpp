// The twelve sea creatures C01..C12 of Fig. 5.2 as solids, in the sizes of its table.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "tools/render/mesh.hpp"
#include "tools/render/sculpture.hpp"

namespace vergence::render {

struct Creature {
  std::string_view code;  // C01
  std::string_view name;  // seahorse
  Vector3 size_mm;        // x, y, z as modelled: z is the h of the table
  void (*build)(Sculpture&);
};

[[nodiscard]] std::span<const Creature> creatures();

// By code or name; null where there is none.
[[nodiscard]] const Creature* find_creature(std::string_view name);

// Centred on its bounding box: x right, y down, seen from -z. Triangles about `cell_mm` in size.
[[nodiscard]] Mesh make_creature(const Creature& creature, double cell_mm);

// The builders; each in its own proportions, the size is set afterwards.
void build_seahorse(Sculpture& s);
void build_coelacanth(Sculpture& s);
void build_moray(Sculpture& s);
void build_dolphin(Sculpture& s);
void build_squid(Sculpture& s);
void build_jellyfish(Sculpture& s);
void build_turtle(Sculpture& s);
void build_octopus(Sculpture& s);
void build_anemonefish(Sculpture& s);
void build_mobula(Sculpture& s);
void build_ray(Sculpture& s);
void build_crab(Sculpture& s);

}  // namespace vergence::render
