// SPDX-License-Identifier: LGPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "facet.hpp"
#include "mortar.hpp"
#include "polygon.hpp"

namespace fretfe::space {

/// Facets of one shape and order: coordinates of their nodes in Gmsh order, corners first and
/// counter-clockwise seen from outside the body.
struct Facets {
  const double *nodes;         // (count, nodes_per_facet, 3), row-major
  std::size_t count;           // number of facets
  std::size_t nodes_per_facet; // 3, 6: triangle; 4, 9: quadrilateral
};

/// One integration point of the coupling: a point of the near side and its projection.
struct PointPair {
  std::int64_t facet;       // facet on the near side
  std::int64_t other_facet; // facet on the other side
  Place at;                 // reference coordinates on `facet`
  Place other_at;           // reference coordinates on `other_facet`
  double weight;            // quadrature weight times area element
  double gap;               // distance along the normal, positive when the bodies are apart
  Vector normal;            // unit normal at the point, out of the near side's body
};

/// Integration points on the overlap of two surfaces in space.
///
/// The corners of a facet of the other side, and points on its edges, are projected along the
/// (continuous) normal field of the near side to the reference cell of a near facet. Neighbours
/// share these points: their polygons fill the cell without gaps and without covering each other.
/// The part of a polygon inside the cell gets the points of `square` if it is a quadrilateral, or
/// those of `triangle` in each triangle of a fan. From there on all geometry is that of the curved
/// facets. Only candidates that face each other and are closer than `max_gap` are coupled, and of
/// several behind each other the nearest.
///
/// @param facets      near side
/// @param normals     unit normals at the nodes of `facets`, same layout
/// @param other       other side
/// @param candidates  at least the facets of the other side that each facet meets
/// @param square      rule for quadrilaterals
/// @param triangle    rule for triangles
/// @param max_gap     largest distance along the normal, on either side of the surface
std::vector<PointPair> overlap_points(const Facets &facets, const double *normals,
                                      const Facets &other, const Candidates &candidates,
                                      const Rule &square, const Rule &triangle, double max_gap);

} // namespace fretfe::space
