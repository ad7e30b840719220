// Data sets of the suite on disk: rendered where they are not there yet, or not as they should be.
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "tools/accuracy/case.hpp"

namespace vergence::accuracy {

struct Places {
  std::filesystem::path scenes;  // *.toml
  std::filesystem::path work;    // a directory for each data set
};

[[nodiscard]] std::filesystem::path directory_of(const Places& places, const RenderedSet& set);

// Renders what is missing. A data set is as it should be where its stamp says the hash of the same scene,
// change and number of frames (more frames do as well). `rendered` is called after each set.
void render_missing(const Places& places, const std::vector<RenderedSet>& sets,
                    const std::function<void()>& rendered);

}  // namespace vergence::accuracy
