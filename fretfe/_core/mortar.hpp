// SPDX-License-Identifier: LGPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace fretfe {

using Point = std::array<double, 2>;

/// A chain of plane facets of one order: node coordinates in Gmsh line order (end, end[, middle]).
struct Facets {
  const double *nodes;         // (count, nodes_per_facet, 2), row-major
  std::size_t count;           // number of facets
  std::size_t nodes_per_facet; // 2: straight, 3: curved
};

/// Quadrature rule on the reference facet [0, 1].
struct Rule {
  const double *points;  // (size,)
  const double *weights; // (size,), sum 1
  std::size_t size;
};

/// One integration point of the coupling: a point of the multiplier side and its projection.
struct PointPair {
  std::int64_t facet;       // facet on the multiplier side
  std::int64_t other_facet; // facet on the other side
  double xi;                // reference coordinate on `facet`
  double eta;               // reference coordinate on `other_facet`
  double weight;            // quadrature weight times arc-length element
  double gap;               // distance along the normal, positive when the bodies are apart
  Point normal;             // unit outward normal of the multiplier side
};

/// Integration points on the true overlap segments of two facet chains.
///
/// Points of the multiplier side are projected along its own (continuous) normal field. A facet is
/// cut at the projections of the other side's facet ends, so that no integrand has a kink inside a
/// segment. Only pairs that face each other and are closer than `max_gap` are coupled.
///
/// @param facets   multiplier side
/// @param normals  unit outward normals at the nodes of `facets`, same layout
/// @param other    other side
/// @param rule     quadrature rule used on every segment
/// @param max_gap  largest distance along the normal, on either side of the surface
std::vector<PointPair> overlap_points(const Facets &facets, const double *normals,
                                      const Facets &other, const Rule &rule, double max_gap);

} // namespace fretfe
