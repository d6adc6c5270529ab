// SPDX-License-Identifier: LGPL-3.0-or-later
// Shear that places next to an edge remember.
#pragma once

#include <cstddef>

namespace fretfe::edge_memory {

/// An edge at states: K_T, and what f K_I is below its largest value.
struct Edge {
  const double *k_t, *retreat;
};

/// Places next to it: half of f K_N y, increasing with the depth y.
struct Places {
  const double *radius;
  std::size_t count;
};

/// Leads what places remember after one state to what they do after a later one.
///
/// A place sticks while K_T is within its radius of what it remembers, f K_I counted. The edge
/// covers places at the beginning of a step, or in the course of it.
void follow(const Edge &edge, const Places &places, bool in_steps, std::size_t from, std::size_t to,
            double *memory);

} // namespace fretfe::edge_memory
