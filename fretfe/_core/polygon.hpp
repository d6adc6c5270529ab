// SPDX-License-Identifier: LGPL-3.0-or-later
#pragma once

#include <cstddef>
#include <vector>

#include "facet.hpp"

namespace fretfe::space {

using Polygon = std::vector<Place>;

/// Quadrature rule on [0, 1]² or on the triangle with corners (0, 0), (1, 0) and (0, 1).
struct Rule {
  const double *points;  // (size, 2)
  const double *weights; // (size,), sum 1 or 1/2
  std::size_t size;
};

/// Twice the signed area.
double area2(const Polygon &polygon);

/// Part of a polygon in the reference cell of a facet, without vertices on the line of their
/// neighbours.
Polygon inside_cell(std::size_t count, Polygon polygon);

bool contains(const Polygon &polygon, const Place &p);

struct Sample { // place in a polygon and its share of the area
  Place at;
  double weight;
};

/// Quadrature of a polygon: the points of `square` in a quadrilateral, those of `triangle` in each
/// triangle of a fan, which counts with the sign of its area.
std::vector<Sample> samples_of(const Polygon &polygon, const Rule &square, const Rule &triangle);

} // namespace fretfe::space
