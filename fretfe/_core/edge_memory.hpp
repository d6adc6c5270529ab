// SPDX-License-Identifier: LGPL-3.0-or-later
// What an edge that P moves remembers of the shear with which it covered and left places.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace fretfe::edge_memory {

/// What loads an edge at states: its hold, none where bodies are apart, the shear, the coefficient
/// in the step to each state, and the way in which all slips in it or zero.
struct Loads {
  const double *hold, *shear, *friction, *slid;
  std::size_t count;
};

/// Places from a hold up to that of the next ones, and the part of f p they are locked in with.
struct Segment {
  double low, share;
};

/// Places that slip takes in a step, by their holds, and how much of the shear it takes there.
struct Slice {
  std::int64_t state;
  double low, high, taken;
};

/// The step to each state: 1 where slip is forward, -1 backward, 0 without; and the hold of the
/// place that it comes to, NaN without slip.
struct Followed {
  std::vector<double> way, front;
  std::vector<Slice> slices;
  std::vector<Segment> locked;
};

/// Follows an edge from one state on, at which no place holds anything.
///
/// Places are covered with the ratio of the step, or with all of f p if that is more; what is left
/// over slips from the edge inward, and each place takes what its own share leaves.
/// All at the beginning of a step instead, as nodes close in a solved one, if `at_once`.
Followed follow(const Loads &loads, std::size_t first, bool at_once);

} // namespace fretfe::edge_memory
