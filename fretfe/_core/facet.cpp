// SPDX-License-Identifier: LGPL-3.0-or-later
#include "facet.hpp"

#include <algorithm>

namespace fretfe::space {
namespace {

struct Shape { // functions of the nodes and their derivatives at one place
  std::array<double, 9> value{};
  std::array<double, 9> along_xi{};
  std::array<double, 9> along_eta{};
};

void triangle_shape(Shape &s, std::size_t count, const Place &at) {
  const std::array<double, 3> area{1 - at[0] - at[1], at[0], at[1]};
  constexpr std::array<double, 3> dxi{-1, 1, 0};
  constexpr std::array<double, 3> deta{-1, 0, 1};
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    const bool linear = count == 3;
    s.value[i] = linear ? area[i] : area[i] * (2 * area[i] - 1);
    s.along_xi[i] = linear ? dxi[i] : (4 * area[i] - 1) * dxi[i];
    s.along_eta[i] = linear ? deta[i] : (4 * area[i] - 1) * deta[i];
    if (linear)
      continue;
    s.value[3 + i] = 4 * area[i] * area[j];
    s.along_xi[3 + i] = 4 * (dxi[i] * area[j] + area[i] * dxi[j]);
    s.along_eta[3 + i] = 4 * (deta[i] * area[j] + area[i] * deta[j]);
  }
}

std::array<double, 3> line_slopes(bool linear, double t) {
  if (linear)
    return {-1, 1, 0};
  return {4 * t - 3, 4 * t - 1, 4 - 8 * t};
}

void quadrilateral_shape(Shape &s, std::size_t count, const Place &at) {
  // number of the interval's node for each node of the facet
  constexpr std::array<std::size_t, 9> first{0, 1, 1, 0, 2, 1, 2, 0, 2};
  constexpr std::array<std::size_t, 9> second{0, 0, 1, 1, 0, 2, 1, 2, 2};
  const bool linear = count == 4;
  const auto x = line_values(linear, at[0]);
  const auto dx = line_slopes(linear, at[0]);
  const auto y = line_values(linear, at[1]);
  const auto dy = line_slopes(linear, at[1]);
  for (std::size_t k = 0; k < count; ++k) {
    s.value[k] = x[first[k]] * y[second[k]];
    s.along_xi[k] = dx[first[k]] * y[second[k]];
    s.along_eta[k] = x[first[k]] * dy[second[k]];
  }
}

Shape shape_at(std::size_t count, const Place &at) {
  Shape s;
  if (is_triangle(count))
    triangle_shape(s, count, at);
  else
    quadrilateral_shape(s, count, at);
  return s;
}

} // namespace

std::optional<Vector> solve(const Vector &a, const Vector &b, const Vector &c, const Vector &r) {
  const Vector bc = cross(b, c);
  const double det = dot(a, bc);
  if (det == 0)
    return std::nullopt;
  return Vector{dot(r, bc) / det, dot(a, cross(r, c)) / det, dot(a, cross(b, r)) / det};
}

Place centre_of(std::size_t count) {
  return is_triangle(count) ? Place{1. / 3, 1. / 3} : Place{0.5, 0.5};
}

double outside(std::size_t count, const Place &at) {
  const double low = std::max(-at[0], -at[1]);
  if (is_triangle(count))
    return std::max(low, at[0] + at[1] - 1);
  return std::max({low, at[0] - 1, at[1] - 1});
}

double largest_diameter(const double *nodes, std::size_t count) {
  double largest = 0;
  for (std::size_t i = 0; i < corners(count); ++i)
    for (std::size_t j = 0; j < i; ++j)
      largest = std::max(largest, norm(node(nodes, i) - node(nodes, j)));
  return largest;
}

std::array<double, 3> line_values(bool linear, double t) {
  if (linear)
    return {1 - t, t, 0};
  return {(1 - t) * (1 - 2 * t), t * (2 * t - 1), 4 * t * (1 - t)};
}

Field interpolate(const double *nodal, std::size_t count, const Place &at, const Vector &origin) {
  const Shape s = shape_at(count, at);
  Field f;
  for (std::size_t k = 0; k < count; ++k)
    for (std::size_t d = 0; d < 3; ++d) {
      const double seen = nodal[3 * k + d] - origin[d];
      f.value[d] += s.value[k] * seen;
      f.along_xi[d] += s.along_xi[k] * seen;
      f.along_eta[d] += s.along_eta[k] * seen;
    }
  return f;
}

} // namespace fretfe::space
