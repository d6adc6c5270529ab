// SPDX-License-Identifier: LGPL-3.0-or-later
#include "edge_memory.hpp"

#include <algorithm>

namespace fretfe::edge_memory {

void follow(const Edge &edge, const Places &places, bool in_steps, std::size_t from, std::size_t to,
            double *memory) {
  const double *radius = places.radius, *end = radius + places.count;
  for (std::size_t state = from + 1; state <= to; ++state) {
    const double k_t = edge.k_t[state], before = edge.retreat[state - 1], now = edge.retreat[state];
    const auto outside = std::lower_bound(radius, end, now) - radius;
    if (now < before && !in_steps)
      for (auto i = outside; radius + i < end && radius[i] < before; ++i)
        memory[i] = k_t + (radius[i] - now) / (before - now) * (edge.k_t[state - 1] - k_t);
    std::fill(memory, memory + outside, k_t);
    for (auto i = outside; radius + i < end; ++i)
      memory[i] = std::min(std::max(memory[i], k_t + now - radius[i]), k_t - now + radius[i]);
  }
}

} // namespace fretfe::edge_memory
