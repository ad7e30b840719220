// A picture in linear light, before the sensor.
#pragma once

#include <cstddef>
#include <vector>

#include "tools/render/colour_math.hpp"

namespace vergence::render {

struct LinearImage {
  int width_px = 0;
  int height_px = 0;
  std::vector<Rgb> data;  // rows packed

  LinearImage() = default;
  LinearImage(int width, int height)
      : width_px(width),
        height_px(height),
        data(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)) {}
  // What it held is lost.
  void resize(int width, int height) {
    width_px = width;
    height_px = height;
    data.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  }
  [[nodiscard]] std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_px) + static_cast<std::size_t>(x);
  }
  [[nodiscard]] Rgb& at(int x, int y) { return data[index(x, y)]; }
  [[nodiscard]] const Rgb& at(int x, int y) const { return data[index(x, y)]; }
};

}  // namespace vergence::render
