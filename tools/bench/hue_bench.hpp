// What a hue plane costs against OpenCV's conversion of the same frames, in one run and one thread.
#pragma once

#include "tools/bench/stopwatch.hpp"

namespace vergence::tools {

// Times are ns a pixel, of 640 x 480 stereo pairs.
struct HueBenchTimes {
  PairOfTimes yuyv;                  // rival: YUV2RGB_YUYV, then RGB2HSV_FULL
  PairOfTimes yuyv_against_rgb_hsv;  // rival: RGB2HSV_FULL alone, of frames it is given as RGB
  PairOfTimes rgb;                   // rival: RGB2HSV_FULL
};

struct HueBenchResult {
  HueBenchTimes scene;                      // smooth colours, edges, and the noise of a sensor
  HueBenchTimes noise;                      // uniform bytes: the look-up of every pixel somewhere else
  double hue_time_ratio_vs_opencv = 0;      // YUYV, the worse of both contents
  double rgb_hue_time_ratio_vs_opencv = 0;  // RGB, likewise
  double yuyv_time_ratio_vs_hsv_alone = 0;  // YUYV against RGB2HSV_FULL alone, likewise
};

[[nodiscard]] HueBenchResult run_hue_bench(int turns = 201);

}  // namespace vergence::tools
