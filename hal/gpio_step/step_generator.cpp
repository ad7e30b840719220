#include "hal/gpio_step/step_generator.hpp"

#include <algorithm>

namespace vergence::step {
namespace {

constexpr std::int64_t magnitude(std::int64_t x) {
  return x < 0 ? -x : x;
}

}  // namespace

TimingError StepGenerator::configure(const StepTiming& timing, std::int64_t now_ns) {
  if (const TimingError error = check(timing); error != TimingError::kNone) return error;
  *this = StepGenerator();
  timing_ = timing;
  ramp_step_ = ramp_step_millisteps_per_s(timing);
  integrated_own_ns_ = now_ns;
  changed_own_ns_ = now_ns - timing.ramp_ns;
  risen_ns_ = now_ns;
  fallen_ns_ = now_ns;
  turned_ns_ = now_ns;
  return TimingError::kNone;
}

bool StepGenerator::command(std::int64_t now_ns, std::int64_t rate_millisteps_per_s) {
  const bool is_allowed = accepts(rate_millisteps_per_s);
  const std::int64_t target = is_allowed ? rate_millisteps_per_s : 0;
  // However often commands come, the rate changes once a ramp_ns.
  if (rate_ == target_ && rate_ != target) {
    change_own_ns_ = std::max({changed_own_ns_ + timing_.ramp_ns, now_ns - delay_ns_, integrated_own_ns_});
  }
  target_ = target;
  return is_allowed;
}

void StepGenerator::halt() {
  rate_ = 0;
  target_ = 0;
  ahead_ = 0;
}

bool StepGenerator::wants_forward() const {
  if (magnitude(ahead_) >= kPhasePerStep) return ahead_ > 0;
  return rate_ != 0 ? rate_ > 0 : levels_.forward;
}

// When the next step in the present direction may begin; kNever_ns: at this rate, never.
std::int64_t StepGenerator::step_due_ns() const {
  const std::int64_t may_ns = std::max(fallen_ns_ + timing_.stepspace_ns, turned_ns_ + timing_.dirsetup_ns);
  if (magnitude(ahead_) >= kPhasePerStep) return may_ns;
  if (rate_ == 0) return kNever_ns;
  const std::int64_t missing = kPhasePerStep - (rate_ > 0 ? ahead_ : -ahead_);
  const std::int64_t wait_ns = (missing + magnitude(rate_) - 1) / magnitude(rate_);
  return std::max(may_ns, integrated_own_ns_ + wait_ns + delay_ns_);
}

std::int64_t StepGenerator::next_event_ns() const {
  std::int64_t next_ns = kNever_ns;
  if (levels_.step) {
    next_ns = risen_ns_ + timing_.steplen_ns;
  } else if (wants_forward() != levels_.forward) {
    next_ns = fallen_ns_ + timing_.dirhold_ns;
  } else {
    next_ns = step_due_ns();
  }
  if (rate_ != target_) next_ns = std::min(next_ns, change_own_ns_ + delay_ns_);
  // What could have come earlier is due now.
  return std::max(next_ns, integrated_own_ns_ + delay_ns_);
}

// An event that is not through before now_ns: what that is beyond the jitter delays the motion. Own time so
// never runs more than the jitter past what was due, which also keeps the phase far from overflow.
void StepGenerator::excuse(std::int64_t now_ns) {
  const std::int64_t late_ns = now_ns - delay_ns_ - due_own_ns_ - timing_.jitter_ns;
  if (late_ns <= 0) return;
  delay_ns_ += late_ns;
  if (!is_late_) ++late_events_;
  is_late_ = true;
}

void StepGenerator::integrate_to(std::int64_t own_ns) {
  ahead_ += rate_ * (own_ns - integrated_own_ns_);
  integrated_own_ns_ = own_ns;
}

// Lateness is bounded by the jitter, and the jitter by the ramp: few changes at once.
void StepGenerator::move_to(std::int64_t own_ns) {
  while (rate_ != target_ && change_own_ns_ <= own_ns) {
    integrate_to(change_own_ns_);
    rate_ += std::clamp(target_ - rate_, -ramp_step_, ramp_step_);
    changed_own_ns_ = change_own_ns_;
    change_own_ns_ += timing_.ramp_ns;
  }
  integrate_to(own_ns);
}

StepLevels StepGenerator::advance(std::int64_t now_ns) {
  const std::int64_t due_ns = next_event_ns();
  due_own_ns_ = std::min(due_ns, now_ns) - delay_ns_;
  is_late_ = false;
  excuse(now_ns);
  move_to(std::max(now_ns - delay_ns_, integrated_own_ns_));

  edge_ = Edge::kNone;
  if (levels_.step) {
    if (now_ns >= risen_ns_ + timing_.steplen_ns) {
      levels_.step = false;
      edge_ = Edge::kFall;
    }
  } else if (wants_forward() != levels_.forward) {
    if (now_ns >= fallen_ns_ + timing_.dirhold_ns) {
      levels_.forward = !levels_.forward;
      edge_ = Edge::kTurn;
    }
  } else if (magnitude(ahead_) >= kPhasePerStep && now_ns >= step_due_ns()) {
    levels_.step = true;
    edge_ = Edge::kRise;
    position_steps_ += levels_.forward ? 1 : -1;
    ahead_ -= levels_.forward ? kPhasePerStep : -kPhasePerStep;
    // A step that had to wait for the direction is not followed by a burst either. The rate may have been
    // higher when the step fell due.
    const std::int64_t most = timing_.max_rate_millisteps_per_s * (timing_.jitter_ns + 1);
    ahead_ = std::clamp(ahead_, -most, most);
  }
  note_edge(now_ns);
  return levels_;
}

void StepGenerator::written(std::int64_t done_ns) {
  if (edge_ == Edge::kNone) return;
  excuse(done_ns);
  note_edge(done_ns);
}

void StepGenerator::rewritten(std::int64_t done_ns) {
  risen_ns_ = done_ns;
  fallen_ns_ = done_ns;
  turned_ns_ = done_ns;
}

void StepGenerator::note_edge(std::int64_t done_ns) {
  switch (edge_) {
    case Edge::kNone: break;
    case Edge::kRise: risen_ns_ = done_ns; break;
    case Edge::kFall: fallen_ns_ = done_ns; break;
    case Edge::kTurn: turned_ns_ = done_ns; break;
  }
}

}  // namespace vergence::step
