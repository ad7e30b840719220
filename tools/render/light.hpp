// A lamp and what it does to surfaces; the light conditions of the experiments.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "algo/pose.hpp"
#include "tools/render/colour_math.hpp"

namespace vergence::render {

struct Light {
  double lux = 500;
  Vector3 towards_lamp = Vector3(-0.35, -0.60, -0.72).normalized();  // in the world
  double ambient = 0.45;                                             // share that comes from everywhere
  Rgb cast{1, 1, 1};                                                 // colour of the light
  double saturation = 1;                                             // of what the camera sees; 0 = grey
  double veil = 0;  // stray light, as reflectance of 0.18 grey
};

// From time t_s on.
struct LightStep {
  double t_s = 0;
  Light light;
};

// The light conditions of Fig. 4.10 and Fig. 4.13: "30lx", "80lx", "500lx", "900lx", "1000lx", "2200lx",
// "2500lx", "lamp-moved".
[[nodiscard]] std::optional<Light> light_preset(std::string_view name);
[[nodiscard]] std::string_view light_preset_names();

// Radiance towards the viewer of a matt surface with a highlight: Lambert and Blinn, exponent 32. Unit
// vectors.
[[nodiscard]] Rgb shade(const Light& light, const Rgb& albedo, float openness, float gloss,
                        const Vector3& normal, const Vector3& to_viewer);

}  // namespace vergence::render
