// SPDX-License-Identifier: LGPL-3.0-or-later
#include "edge_memory.hpp"

#include <cmath>
#include <limits>

namespace fretfe::edge_memory {

namespace {

/// Segments from the innermost place outward; the last one ends at the edge.
class Memory {
public:
  Memory(double base, double hold) : hold_(hold), places_{{base, 0.0}} {}

  const std::vector<Segment> &places() const { return places_; }

  void forget(double hold) {
    hold_ = hold;
    places_.assign(1, {hold, 0.0});
  }

  /// Without friction nothing is locked in, wherever the edge is.
  void release(double hold) {
    hold_ = hold;
    while (places_.size() > 1)
      places_.pop_back();
    places_.back().share = 0.0;
    if (places_.back().low > hold)
      places_.back().low = hold;
  }

  /// What places hold too much of with another coefficient.
  double change_friction(double before, double now) {
    double left = 0.0, top = hold_;
    for (auto each = places_.rbegin(); each != places_.rend(); ++each) {
      const double share = each->share * before / now;
      each->share = std::fmax(-1.0, std::fmin(1.0, share));
      if (each->share != share)
        left += now * (share - each->share) * (top - each->low);
      top = each->low;
    }
    return left;
  }

  /// What is left of a step of the shear where the edge moves outward.
  double press(double hold, double shear, double friction, bool at_once) {
    const double most = friction * (hold - hold_);
    const double share = at_once ? 0.0 : std::fmax(-1.0, std::fmin(1.0, shear / most));
    places_.push_back({hold_, share});
    hold_ = hold;
    return at_once || std::fabs(shear) > most ? shear - share * most : 0.0;
  }

  /// What the places that the edge leaves have held.
  double draw_back(double hold, double friction) {
    double held = 0.0, top = hold_;
    while (places_.size() > 1 && places_.back().low >= hold) {
      held += friction * places_.back().share * (top - places_.back().low);
      top = places_.back().low;
      places_.pop_back();
    }
    if (places_.back().share != 0.0)
      held += friction * places_.back().share * (top - hold);
    hold_ = hold;
    if (places_.back().low >= hold) // the edge has gone farther back than it came from
      places_.assign(1, {hold, 0.0});
    return held;
  }

  /// All places have slipped one way; the place that slip comes to.
  double slide(double way, double friction, std::int64_t state, std::vector<Slice> &slices) {
    const double low = places_.front().low;
    slices.push_back({state, low, hold_, friction * (hold_ - low)});
    places_.assign(1, {low, way});
    return low;
  }

  /// Slip by what is left of the shear; the place that it comes to.
  double slip(double left, double friction, std::int64_t state, std::vector<Slice> &slices) {
    const double way = left > 0.0 ? 1.0 : -1.0;
    double rest = std::fabs(left), top = hold_;
    while (!places_.empty()) {
      const Segment inner = places_.back();
      const double free = friction * (1.0 - way * inner.share);
      const double most = free > 0.0 ? free * (top - inner.low) : 0.0;
      if (most > rest) {
        const double front = top - rest / free;
        slices.push_back({state, front, top, rest});
        if (front <= inner.low)
          places_.pop_back();
        places_.push_back({front, way});
        return front;
      }
      if (most > 0.0)
        slices.push_back({state, inner.low, top, most});
      rest -= most;
      top = inner.low;
      places_.pop_back();
    }
    places_.assign(1, {top, way});
    return top;
  }

private:
  double hold_;
  std::vector<Segment> places_;
};

} // namespace

Followed follow(const Loads &loads, std::size_t first, bool at_once) {
  const double none = std::numeric_limits<double>::quiet_NaN();
  Followed found{
      std::vector<double>(loads.count, 0.0), std::vector<double>(loads.count, none), {}, {}};
  Memory memory(std::fmin(0.0, loads.hold[first]), loads.hold[first]);
  double friction = 0.0;
  for (std::size_t state = first + 1; state < loads.count; ++state) {
    const double hold = loads.hold[state], moved = hold - loads.hold[state - 1];
    const double shear = loads.shear[state] - loads.shear[state - 1], now = loads.friction[state];
    if (!(hold > 0.0)) {
      memory.forget(hold);
      continue;
    }
    if (!(now > 0.0)) {
      memory.release(hold);
      friction = 0.0;
      continue;
    }
    double left = friction > 0.0 && now != friction ? memory.change_friction(friction, now) : 0.0;
    friction = now;
    if (moved > 0.0)
      left += memory.press(hold, shear, now, at_once);
    else
      left += shear + (moved < 0.0 ? memory.draw_back(hold, now) : 0.0);
    if (loads.slid[state] != 0.0) {
      found.way[state] = loads.slid[state];
      found.front[state] =
          memory.slide(loads.slid[state], now, static_cast<std::int64_t>(state), found.slices);
      continue;
    }
    if (left == 0.0)
      continue;
    found.way[state] = left > 0.0 ? 1.0 : -1.0;
    found.front[state] = memory.slip(left, now, static_cast<std::int64_t>(state), found.slices);
  }
  found.locked = memory.places();
  return found;
}

} // namespace fretfe::edge_memory
