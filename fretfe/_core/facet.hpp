// SPDX-License-Identifier: LGPL-3.0-or-later
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

namespace fretfe::space {

using Vector = std::array<double, 3>;
using Place = std::array<double, 2>; // reference coordinates on a facet

inline Vector operator+(const Vector &a, const Vector &b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
inline Vector operator-(const Vector &a, const Vector &b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
inline Vector operator*(double c, const Vector &a) { return {c * a[0], c * a[1], c * a[2]}; }
inline double dot(const Vector &a, const Vector &b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline double norm(const Vector &a) { return std::sqrt(dot(a, a)); }
inline Vector cross(const Vector &a, const Vector &b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

inline Place minus(const Place &a, const Place &b) { return {a[0] - b[0], a[1] - b[1]}; }
inline double cross(const Place &a, const Place &b) { return a[0] * b[1] - a[1] * b[0]; }
inline double dot(const Place &a, const Place &b) { return a[0] * b[0] + a[1] * b[1]; }
inline double norm(const Place &a) { return std::sqrt(dot(a, a)); }

/// Solution of x a + y b + z c = r; none if the columns lie in a plane.
std::optional<Vector> solve(const Vector &a, const Vector &b, const Vector &c, const Vector &r);

// Facets have 3 or 6 nodes, triangles, or 4 or 9, quadrilaterals, in Gmsh order: corners, middles
// of the edges, centre. Reference coordinates lie in [0, 1].

inline bool is_triangle(std::size_t count) { return count == 3 || count == 6; }
inline std::size_t corners(std::size_t count) { return is_triangle(count) ? 3 : 4; }

/// Node `k` of a facet.
inline Vector node(const double *nodes, std::size_t k) {
  return {nodes[3 * k], nodes[3 * k + 1], nodes[3 * k + 2]};
}

Place centre_of(std::size_t count);

/// Largest distance (in reference length) of a place from a half-plane that holds the cell.
double outside(std::size_t count, const Place &at);

/// Largest distance of two corners.
double largest_diameter(const double *nodes, std::size_t count);

/// Functions (end, end, middle) of an interval.
std::array<double, 3> line_values(bool linear, double t);

struct Field { // interpolated nodal vectors and their derivatives at one place
  Vector value{};
  Vector along_xi{};
  Vector along_eta{};
};

/// Interpolation of nodal vectors seen from `origin`. Differences of neighbouring coordinates are
/// exact, so that equations solved with them are as accurate far from the origin as close to it.
Field interpolate(const double *nodal, std::size_t count, const Place &at,
                  const Vector &origin = {0, 0, 0});

} // namespace fretfe::space
