#include "tools/render/light.hpp"

#include <algorithm>

namespace vergence::render {

std::string_view light_preset_names() {
  return "30lx, 80lx, 500lx, 900lx, 1000lx, 2200lx, 2500lx, lamp-moved";
}

std::optional<Light> light_preset(std::string_view name) {
  Light light;
  if (name == "500lx") return light;
  if (name == "30lx" || name == "80lx") {  // what is left of a dark room is warm
    light.lux = name == "30lx" ? 30 : 80;
    light.cast = {1.06F, 1.0F, 0.90F};
    light.saturation = 0.92;
    return light;
  }
  if (name == "900lx" || name == "1000lx") {
    light.lux = name == "900lx" ? 900 : 1000;
    return light;
  }
  if (name == "2200lx" || name == "2500lx") {  // bright lamps are cold and glare
    light.lux = name == "2200lx" ? 2200 : 2500;
    light.cast = {0.97F, 1.0F, 1.05F};
    light.veil = 0.05;
    return light;
  }
  if (name == "lamp-moved") {
    light.towards_lamp = Vector3(0.85, -0.15, -0.50).normalized();
    light.ambient = 0.30;
    return light;
  }
  return std::nullopt;
}

Rgb shade(const Light& light, const Rgb& albedo, float openness, float gloss, const Vector3& normal,
          const Vector3& to_viewer) {
  const double facing = normal.dot(light.towards_lamp);
  // Light from everywhere is a little stronger from above (-y).
  const double sky = light.ambient * (1 - 0.25 * normal[1]) * openness;
  const double lamp = (1 - light.ambient) * std::max(0.0, facing) * (0.5 + 0.5 * openness);
  Rgb radiance = albedo * static_cast<float>(1.25 * (sky + lamp));
  if (gloss > 0 && facing > 0) {
    double highlight = std::max(0.0, normal.dot((light.towards_lamp + to_viewer).normalized()));
    for (int i = 0; i < 5; ++i) highlight *= highlight;
    const auto glint = static_cast<float>(gloss * (1 - light.ambient) * highlight);
    radiance += Rgb{glint, glint, glint};
  }
  return radiance * light.cast;
}

}  // namespace vergence::render
