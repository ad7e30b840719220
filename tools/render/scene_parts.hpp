// The parts of a scene file that describe bodies: target, motions, occluders.
#pragma once

#include "tools/io/toml_reader.hpp"
#include "tools/render/scene.hpp"

namespace vergence::render {

[[nodiscard]] SceneTarget read_target(const tools::TomlReader& table, const SceneOverrides& overrides,
                                      const PhotoOptionsOfScene& photo);

// `fallback` is where the body is if the table does not say.
[[nodiscard]] Motion read_motion(const tools::TomlReader& table, const Motion& fallback);

[[nodiscard]] Occluder read_occluder(const tools::TomlReader& table, const Motion& fallback);

// A picture to print on a card, of many hues and sizes of detail.
[[nodiscard]] tools::RgbImage make_card_picture(int width_px, int height_px, std::uint64_t seed);

}  // namespace vergence::render
