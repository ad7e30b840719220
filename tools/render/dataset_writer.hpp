// Data sets on disk, in the layout `vergence estimate` reads.
#pragma once

#include <filesystem>
#include <functional>

#include "tools/render/scene.hpp"

namespace vergence::render {

// Writes `frames` frames and everything beside them; `threads` threads share the frames, which changes no
// byte. `written` is called after each frame, from one thread at a time. Throws InputError where a file
// cannot be written.
void write_dataset(const Scene& scene, const std::filesystem::path& directory, int frames, int threads,
                   const std::function<void()>& written);

// The target's model alone, as in a data set's model/: model.toml and, of a photo-model, its photos.
void write_model(const Scene& scene, const std::filesystem::path& directory);

}  // namespace vergence::render
