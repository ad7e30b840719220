// Step and direction pulses of one motor, in whole numbers: says when the next edge is due and what the lines
// are to be. It knows neither lines nor clocks; whoever has them asks advance() and tells written() when the
// lines had their new levels.
//
//              ______________                 ______________
//   step _____|              |_______________|              |_________________________________|~~~~
//             :              :               :              :                                 :
//             :<- steplen -->:<- stepspace ->:<- steplen -->:<- dirhold ->:<---- dirsetup --->:
//        _________________________________________________________________
//   dir                                                                   |__________________________
//
//   position  n+1                            n+2                                              n+1
//
// All four are least times. They count from when a line surely had its level (written()) to when it may begin
// to change (advance()), so an edge that comes late moves the following ones and shortens nothing. The
// direction never changes in the same instant as the step line. Position is steps issued: it counts with the
// active edge.
//
// Whatever makes an edge late, the call or the lines, is forgiven up to the jitter, and beyond it the motion
// is delayed: steps are neither lost nor caught up with in a burst. What falls due while a direction line
// keeps its times is lost, but for one step.
//
// The rate is a staircase that climbs one ramp step each ramp_ns; the phase is its exact integral. A step is
// due where the phase is a whole step ahead of the steps issued, in either direction, so that a rate that
// hovers about zero moves nothing.
#pragma once

#include <cstdint>
#include <limits>

#include "hal/gpio_step/step_timing.hpp"

namespace vergence::step {

inline constexpr std::int64_t kNever_ns = std::numeric_limits<std::int64_t>::max();

struct StepLevels {
  bool step = false;
  bool forward = true;  // level of the direction line
  bool operator==(const StepLevels&) const = default;
};

class StepGenerator {
 public:
  // At rest, position 0, step line at rest, direction forward since now_ns. Errors: those of check().
  [[nodiscard]] TimingError configure(const StepTiming& timing, std::int64_t now_ns);

  [[nodiscard]] bool accepts(std::int64_t rate_millisteps_per_s) const {
    return rate_millisteps_per_s >= -timing_.max_rate_millisteps_per_s &&
           rate_millisteps_per_s <= timing_.max_rate_millisteps_per_s;
  }
  // The rate to ramp to, from now on. False where it is above the maximum: then it ramps to rest.
  bool command(std::int64_t now_ns, std::int64_t rate_millisteps_per_s);
  // At rest at once, without a ramp. A pulse that has begun still gets its length.
  void halt();
  // Steps issued count from here.
  void set_position(std::int64_t steps) { position_steps_ = steps; }

  // When advance() is to be called next; kNever_ns: not before a command.
  [[nodiscard]] std::int64_t next_event_ns() const;
  // Moves on to now_ns, which never goes back, and answers the levels from now on. Where they differ from
  // before, the lines are to be set, and written() called before anything else.
  StepLevels advance(std::int64_t now_ns);
  // The lines had these levels by done_ns, not before the now_ns of advance().
  void written(std::int64_t done_ns);
  // The same after an attempt to set them that failed: nobody knows which line had which level before.
  void rewritten(std::int64_t done_ns);

  [[nodiscard]] StepLevels levels() const { return levels_; }
  [[nodiscard]] std::int64_t position_steps() const { return position_steps_; }
  [[nodiscard]] std::int64_t rate_millisteps_per_s() const { return rate_; }
  [[nodiscard]] std::int64_t target_millisteps_per_s() const { return target_; }
  // How many events came, or were through, later than the jitter allows, and by how much the motion is
  // delayed for that.
  [[nodiscard]] std::uint64_t late_events() const { return late_events_; }
  [[nodiscard]] std::int64_t delay_ns() const { return delay_ns_; }

 private:
  enum class Edge : std::uint8_t {
    kNone,
    kRise,
    kFall,
    kTurn,
  };
  void excuse(std::int64_t now_ns);
  void note_edge(std::int64_t done_ns);
  void integrate_to(std::int64_t own_ns);
  void move_to(std::int64_t own_ns);
  [[nodiscard]] bool wants_forward() const;
  [[nodiscard]] std::int64_t step_due_ns() const;

  StepTiming timing_;
  std::int64_t ramp_step_ = 0;

  // The motion, in a time of its own that stands still while the step task is later than it may be:
  // own = now - delay.
  std::int64_t delay_ns_ = 0;
  std::int64_t due_own_ns_ = 0;  // the event of the last advance()
  bool is_late_ = false;         // that event
  std::int64_t integrated_own_ns_ = 0;
  std::int64_t changed_own_ns_ = 0;  // the rate, last
  std::int64_t change_own_ns_ = 0;   // next, where rate and target differ
  std::int64_t rate_ = 0;            // thousandths of a step a second, like target_
  std::int64_t target_ = 0;
  std::int64_t ahead_ = 0;  // of the steps issued, in 1e-12 steps
  std::int64_t position_steps_ = 0;

  // The lines.
  StepLevels levels_;
  Edge edge_ = Edge::kNone;  // made by the last advance()
  std::int64_t risen_ns_ = 0;
  std::int64_t fallen_ns_ = 0;
  std::int64_t turned_ns_ = 0;
  std::uint64_t late_events_ = 0;
};

}  // namespace vergence::step
