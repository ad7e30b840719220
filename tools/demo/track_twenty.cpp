// Section 6.1: the hand is still, a crab goes through twenty steps; how well is its pose tracked?
#include <cmath>

#include "tools/demo/closed_loop.hpp"
#include "tools/demo/experiments.hpp"
#include "tools/demo/measures.hpp"
#include "tools/render/motion.hpp"

namespace vergence::demo {

Outcome track_twenty(const RunOptions& options) {
  LoopSetup setup;
  setup.name = "track-20";
  setup.scene =
      "[target]\nkind = \"creature\"\ncreature = \"C12\"\n"
      "[motion]\nkind = \"steps20\"\npose = [0, 0, 500, 0, 0, 0]\nrest_s = 1.0\n";
  const auto keys = render::twenty_steps({{0, 0, 500}, Vector3::Zero()}, 1.0);
  setup.duration_s = std::ceil(keys.back().t_s + 1);
  setup.has_arm = false;
  setup.servo = false;
  ClosedLoop loop(setup, options);
  loop.run(options.progress);
  const tools::Picture last =
      loop.draw_last_frame(options.out / "last_frame.png",
                           "The last frame, with the photo-model as it was seen (magenta, its points "
                           "coloured by the relief it has learned) and as it is (white).");

  Outcome outcome{loop.take_log(), setup.duration_s, {}, {}, {}};
  const tools::LogTable& log = outcome.log;
  const SeenErrors seen = seen_errors(log, {});
  const SeenErrors later = seen_errors(log, {1, 1e9});
  const FirstLock lock = first_lock(log);
  outcome.metrics = {
      at_most("x_rms_mm", seen.rms_mm[0], "mm", 0.3, "within +-20", "over all frames tracked"),
      at_most("y_rms_mm", seen.rms_mm[1], "mm", 0.3, "within +-20", "the same"),
      at_most("z_rms_mm", seen.rms_mm[2], "mm", 1, "within +-30", "the same"),
      at_most("e_rms", seen.rms_e, "", 0.01, std::nullopt, "the same"),
      at_most("frames_before_lock", lock.frames_before, "", 0, "6 s", "frames looked at before it was found"),
      at_least("tracked_percent", 100.0 * seen.tracked / seen.frames, "%", 100, std::nullopt,
               "of the frames"),
      at_most("largest_mm", seen.largest_mm, "mm", std::nullopt, "beyond +-20 where it speeds up",
              "largest error of the position, over all frames"),
      at_most("largest_after_1s_mm", later.largest_mm, "mm", 3, "beyond +-20 where it speeds up",
              "the same after 1 s: no excursion where it speeds up"),
      at_most("largest_after_1s_e", later.largest_e, "", std::nullopt, std::nullopt,
              "the same of the orientation")};
  outcome.pictures = {
      drawn(options.out / "pose.png", seen_figure(log, "The crab's pose, as it is and as it is seen"),
            "As Fig. 6.2."),
      drawn(options.out / "errors.png", seen_error_figure(log, "Errors of the pose seen"), "As Fig. 6.3."),
      last};
  return outcome;
}

}  // namespace vergence::demo
