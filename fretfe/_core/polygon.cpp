// SPDX-License-Identifier: LGPL-3.0-or-later
#include "polygon.hpp"

#include <cmath>
#include <utility>

namespace fretfe::space {
namespace {

// Vertices this close (in reference length) to a line are on it.
constexpr double on_line = 1e-10;

/// Part of a polygon for which distance(place) ≥ 0 (Sutherland and Hodgman).
template <class F> Polygon clipped(const Polygon &polygon, F distance) {
  Polygon kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Place &a = polygon[i];
    const Place &b = polygon[(i + 1) % polygon.size()];
    const double da = distance(a);
    const double db = distance(b);
    if (da >= 0)
      kept.push_back(a);
    if ((da < 0) != (db < 0)) {
      const double t = da / (da - db);
      kept.push_back({a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])});
    }
  }
  return kept;
}

/// The polygon without vertices that lie on the line of their neighbours.
Polygon without_straight_vertices(Polygon polygon) {
  std::size_t straight = 0; // vertices in a row that are needed
  for (std::size_t i = 0; polygon.size() > 2 && straight < polygon.size();) {
    const std::size_t count = polygon.size();
    i %= count;
    const Place &before = polygon[(i + count - 1) % count];
    const Place from = minus(polygon[i], before);
    const Place line = minus(polygon[(i + 1) % count], before);
    const double length = norm(line);
    const double away = length > on_line ? std::abs(cross(line, from)) / length : 0;
    if (away > on_line && norm(from) > on_line) {
      ++straight;
      ++i;
      continue;
    }
    polygon.erase(polygon.begin() + static_cast<std::ptrdiff_t>(i));
    straight = 0;
  }
  return polygon;
}

void add_triangle(std::vector<Sample> &samples, const Rule &rule, const Place &a, const Place &b,
                  const Place &c) {
  const Place u = minus(b, a);
  const Place v = minus(c, a);
  for (std::size_t q = 0; q < rule.size; ++q) {
    const double s = rule.points[2 * q];
    const double t = rule.points[2 * q + 1];
    samples.push_back(
        {{a[0] + s * u[0] + t * v[0], a[1] + s * u[1] + t * v[1]}, rule.weights[q] * cross(u, v)});
  }
}

void add_quadrilateral(std::vector<Sample> &samples, const Rule &rule, const Polygon &p) {
  for (std::size_t q = 0; q < rule.size; ++q) {
    const double s = rule.points[2 * q];
    const double t = rule.points[2 * q + 1];
    Place at;
    Place u;
    Place v;
    for (std::size_t d = 0; d < 2; ++d) {
      at[d] = (1 - t) * ((1 - s) * p[0][d] + s * p[1][d]) + t * ((1 - s) * p[3][d] + s * p[2][d]);
      u[d] = (1 - t) * (p[1][d] - p[0][d]) + t * (p[2][d] - p[3][d]);
      v[d] = (1 - s) * (p[3][d] - p[0][d]) + s * (p[2][d] - p[1][d]);
    }
    samples.push_back({at, rule.weights[q] * cross(u, v)});
  }
}

} // namespace

double area2(const Polygon &polygon) {
  double sum = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i)
    sum += cross(polygon[i], polygon[(i + 1) % polygon.size()]);
  return sum;
}

Polygon inside_cell(std::size_t count, Polygon polygon) {
  polygon = clipped(polygon, [](const Place &p) { return p[0]; });
  polygon = clipped(polygon, [](const Place &p) { return p[1]; });
  if (is_triangle(count)) {
    polygon = clipped(polygon, [](const Place &p) { return 1 - p[0] - p[1]; });
  } else {
    polygon = clipped(polygon, [](const Place &p) { return 1 - p[0]; });
    polygon = clipped(polygon, [](const Place &p) { return 1 - p[1]; });
  }
  return without_straight_vertices(std::move(polygon));
}

bool contains(const Polygon &polygon, const Place &p) {
  bool inside = false;
  for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
    const Place &a = polygon[i];
    const Place &b = polygon[j];
    if ((a[1] > p[1]) != (b[1] > p[1]) &&
        p[0] < (b[0] - a[0]) * (p[1] - a[1]) / (b[1] - a[1]) + a[0])
      inside = !inside;
  }
  return inside;
}

std::vector<Sample> samples_of(const Polygon &polygon, const Rule &square, const Rule &triangle) {
  std::vector<Sample> samples;
  if (polygon.size() == 4)
    add_quadrilateral(samples, square, polygon);
  else
    for (std::size_t i = 1; i + 1 < polygon.size(); ++i)
      add_triangle(samples, triangle, polygon[0], polygon[i], polygon[i + 1]);
  return samples;
}

} // namespace fretfe::space
