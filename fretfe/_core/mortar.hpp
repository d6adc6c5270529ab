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

/// Numbers of some facets, in ascending order.
struct FacetList {
  const std::int64_t *first;
  const std::int64_t *last;

  const std::int64_t *begin() const { return first; }
  const std::int64_t *end() const { return last; }
};

/// For each facet of the near side the facets of the other side that it may meet.
struct Candidates {
  const std::int64_t *starts; // (count + 1,)
  const std::int64_t *facets; // one list after the other

  FacetList of(std::size_t facet) const {
    return {facets + starts[facet], facets + starts[facet + 1]};
  }
};

/// Quadrature rule on the reference facet [0, 1].
struct Rule {
  const double *points;  // (size,)
  const double *weights; // (size,), sum 1
  std::size_t size;
};

/// One integration point of the coupling: a point of the near side and its projection.
struct PointPair {
  std::int64_t facet;       // facet on the near side
  std::int64_t other_facet; // facet on the other side
  double xi;                // reference coordinate on `facet`
  double eta;               // reference coordinate on `other_facet`
  double weight;            // quadrature weight times arc-length element
  double gap;               // distance along the normal, positive when the bodies are apart
  Point normal;             // unit outward normal of the near side
};

/// Integration points on the true overlap segments of two facet chains.
///
/// Points of the near side are projected along its own (continuous) normal field. A facet is
/// cut at the projections of the other side's facet ends, so that no integrand has a kink inside a
/// segment. Only candidates that face each other and are closer than `max_gap` are coupled.
///
/// @param facets      near side
/// @param normals     unit outward normals at the nodes of `facets`, same layout
/// @param other       other side
/// @param candidates  at least the facets of the other side that each facet meets
/// @param rule        quadrature rule used on every segment
/// @param max_gap     largest distance along the normal, on either side of the surface
std::vector<PointPair> overlap_points(const Facets &facets, const double *normals,
                                      const Facets &other, const Candidates &candidates,
                                      const Rule &rule, double max_gap);

} // namespace fretfe
