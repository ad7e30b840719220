// All creatures at a glance.
#pragma once

#include "tools/render/scene.hpp"

namespace vergence::render {

// Two cells a creature, its model photo beside what the left eye sees in the scene at its first frame; four
// creatures a row, scaled down by `shrink`.
[[nodiscard]] tools::RgbImage contact_sheet(const std::filesystem::path& scene_file, SceneOverrides overrides,
                                            int shrink);

}  // namespace vergence::render
