// From light to bytes: lens blur, vignetting, exposure, noise, quantisation.
#pragma once

#include <cstdint>

#include "tools/io/image_file.hpp"
#include "tools/render/light.hpp"
#include "tools/render/linear_image.hpp"

namespace vergence::render {

struct SensorOptions {
  double auto_exposure = 0.6;  // 0: a fourth of the light is a fourth of the signal; 1: fully compensated
  double full_well_e = 9000;   // electrons of a white surface at 500 lx: shot noise
  double read_noise_e = 12;    // electrons
  bool noise = true;
  double blur_px = 0.45;     // standard deviation of the lens's blur
  double vignetting = 0.08;  // loss at the corners
};

// `light` gives exposure, colour and saturation; `seed` is the frame's and the camera's own.
void develop(LinearImage& image, const SensorOptions& options, const Light& light, std::uint64_t seed,
             tools::RgbImage& out);

}  // namespace vergence::render
