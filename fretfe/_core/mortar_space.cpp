// SPDX-License-Identifier: LGPL-3.0-or-later
#include "mortar_space.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace fretfe::space {
namespace {

constexpr int max_newton = 30;
// Newton converges quadratically: after a step this small the error is round-off.
constexpr double parameter_tolerance = 1e-10;
// Foot points further than this (in reference length) from their cell need no more than a side.
constexpr double farthest_foot = 1.0;
// Polygons have straight edges where curved facets have curved ones: points may be hit this far
// (in reference length) outside a facet, whose shape continues there.
constexpr double farthest_hit = 0.1;
// Vertices this close (in reference length) to a line are on it.
constexpr double on_line = 1e-10;
// Polygons smaller than this (in reference area) come from round-off at facet edges.
constexpr double smallest_area = 1e-10;
// Facets that hide another one are nearer by this fraction of its size; neighbours are not.
constexpr double layer_distance = 0.1;
// An edge is never cut into more pieces than this.
constexpr double most_pieces = 8;

Vector operator+(const Vector &a, const Vector &b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
Vector operator-(const Vector &a, const Vector &b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
Vector operator*(double c, const Vector &a) { return {c * a[0], c * a[1], c * a[2]}; }
double dot(const Vector &a, const Vector &b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
double norm(const Vector &a) { return std::sqrt(dot(a, a)); }
Vector cross(const Vector &a, const Vector &b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Place minus(const Place &a, const Place &b) { return {a[0] - b[0], a[1] - b[1]}; }
double cross(const Place &a, const Place &b) { return a[0] * b[1] - a[1] * b[0]; }
double norm(const Place &a) { return std::hypot(a[0], a[1]); }

/// Solution of x a + y b + z c = r; none if the columns lie in a plane.
std::optional<Vector> solve(const Vector &a, const Vector &b, const Vector &c, const Vector &r) {
  const Vector bc = cross(b, c);
  const double det = dot(a, bc);
  if (det == 0)
    return std::nullopt;
  return Vector{dot(r, bc) / det, dot(a, cross(r, c)) / det, dot(a, cross(b, r)) / det};
}

bool is_triangle(std::size_t count) { return count == 3 || count == 6; }

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

/// Functions (end, end, middle) of an interval.
std::array<double, 3> line_values(bool linear, double t) {
  if (linear)
    return {1 - t, t, 0};
  return {(1 - t) * (1 - 2 * t), t * (2 * t - 1), 4 * t * (1 - t)};
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

struct Field { // interpolated nodal vectors and their derivatives at one place
  Vector value{};
  Vector along_xi{};
  Vector along_eta{};
};

/// Interpolation of nodal vectors seen from `origin`. Differences of neighbouring coordinates are
/// exact, so that equations solved with them are as accurate far from the origin as close to it.
Field interpolate(const Shape &s, const double *nodal, std::size_t count, const Vector &origin) {
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

constexpr Vector no_origin{0, 0, 0};

Place centre_of(std::size_t count) {
  return is_triangle(count) ? Place{1. / 3, 1. / 3} : Place{0.5, 0.5};
}

/// Largest distance (in reference length) of a place from a half-plane that holds the cell.
double outside(std::size_t count, const Place &at) {
  const double low = std::max(-at[0], -at[1]);
  if (is_triangle(count))
    return std::max(low, at[0] + at[1] - 1);
  return std::max({low, at[0] - 1, at[1] - 1});
}

struct Near { // geometry and normals of one facet of the near side
  const double *nodes;
  const double *normals;
  std::size_t count;
  double size; // largest distance of two corners

  Field position(const Place &at, const Vector &origin = no_origin) const {
    return interpolate(shape_at(count, at), nodes, count, origin);
  }
  Vector normal(const Place &at) const {
    const Vector n = interpolate(shape_at(count, at), normals, count, no_origin).value;
    return (1 / norm(n)) * n;
  }
};

/// Reference coordinates at which the normal line of a facet passes through `x`.
///
/// Newton's method from the centre; where that leads far away, the place as seen from the centre.
std::optional<Place> foot(const Near &near, const Vector &x) {
  Place at = centre_of(near.count);
  std::optional<Place> seen_from_centre;
  double along = 0;
  for (int i = 0; i < max_newton; ++i) {
    const Shape s = shape_at(near.count, at);
    const Field p = interpolate(s, near.nodes, near.count, x);
    const Field n = interpolate(s, near.normals, near.count, no_origin);
    const auto step = solve(p.along_xi + along * n.along_xi, p.along_eta + along * n.along_eta,
                            n.value, -1 * (p.value + along * n.value));
    if (!step)
      break;
    at = {at[0] + (*step)[0], at[1] + (*step)[1]};
    along += (*step)[2];
    if (!seen_from_centre)
      seen_from_centre = at;
    if (!(outside(near.count, at) < farthest_foot))
      break;
    if (std::max(std::abs((*step)[0]), std::abs((*step)[1])) < parameter_tolerance)
      return at;
  }
  return seen_from_centre;
}

struct Hit {
  Place at;
  double gap;
  bool faces; // the normals of both sides oppose each other
};

/// Where the line through `x` along `n` meets a facet of the other side.
std::optional<Hit> meet(const double *nodes, std::size_t count, const Vector &x, const Vector &n,
                        Place at) {
  for (int i = 0; i < max_newton; ++i) {
    const Field p = interpolate(shape_at(count, at), nodes, count, x);
    const auto step = solve(p.along_xi, p.along_eta, -1 * n, -1 * p.value);
    if (!step)
      return std::nullopt;
    at = {at[0] + (*step)[0], at[1] + (*step)[1]};
    if (!(outside(count, at) < 2)) // leaves the facet for good
      return std::nullopt;
    if (std::max(std::abs((*step)[0]), std::abs((*step)[1])) < parameter_tolerance) {
      const Field found = interpolate(shape_at(count, at), nodes, count, x);
      const bool faces = dot(cross(found.along_xi, found.along_eta), n) < 0;
      if (outside(count, at) > farthest_hit)
        return std::nullopt;
      return Hit{at, dot(found.value, n), faces};
    }
  }
  return std::nullopt;
}

using Polygon = std::vector<Place>;

/// Twice the signed area.
double area2(const Polygon &polygon) {
  double sum = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i)
    sum += cross(polygon[i], polygon[(i + 1) % polygon.size()]);
  return sum;
}

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

std::size_t corners(std::size_t count) { return is_triangle(count) ? 3 : 4; }

double largest_diameter(const double *nodes, std::size_t count) {
  double largest = 0;
  for (std::size_t i = 0; i < corners(count); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      const Vector a{nodes[3 * i], nodes[3 * i + 1], nodes[3 * i + 2]};
      const Vector b{nodes[3 * j], nodes[3 * j + 1], nodes[3 * j + 2]};
      largest = std::max(largest, norm(a - b));
    }
  return largest;
}

/// Points along the edges of a facet, clockwise seen from outside its body.
///
/// Edges are cut in two, and those much longer than `size` more often: straight edges too may be
/// curved in the reference cell of another facet. How an edge
/// is cut depends on nothing but the edge: neighbours cut it alike.
std::vector<Vector> rim(const double *nodes, std::size_t count, double size) {
  std::vector<Vector> points;
  const std::size_t sides = corners(count);
  const bool linear = count == sides;
  const auto node = [&](std::size_t k) {
    return Vector{nodes[3 * k], nodes[3 * k + 1], nodes[3 * k + 2]};
  };
  for (std::size_t i = sides; i-- > 0;) {
    const Vector from = node((i + 1) % sides);
    const Vector to = node(i);
    const double ratio = std::clamp(std::round(norm(to - from) / size), 1.0, most_pieces);
    const int pieces = 2 * static_cast<int>(ratio);
    for (int k = 0; k < pieces; ++k) {
      const auto s = line_values(linear, static_cast<double>(k) / pieces);
      Vector x = s[0] * from + s[1] * to;
      if (!linear)
        x = x + s[2] * node(sides + i);
      points.push_back(x);
    }
  }
  return points;
}

struct Piece { // part of a near facet's cell that lies opposite one facet of the other side
  std::size_t other;
  const double *nodes;
  Polygon polygon;
  Place start;  // place on the other facet from which to look for others
  double layer; // distance between facets behind each other
};

std::optional<Piece> piece(const Near &near, const Facets &other, std::size_t number,
                           double max_gap) {
  const std::size_t count = other.nodes_per_facet;
  const double *nodes = other.nodes + number * count * 3;
  Polygon polygon;
  for (const Vector &x : rim(nodes, count, near.size)) {
    const auto at = foot(near, x);
    if (!at)
      return std::nullopt;
    polygon.push_back(*at);
  }
  polygon = inside_cell(near.count, std::move(polygon));
  if (polygon.size() < 3 || area2(polygon) < 2 * smallest_area)
    return std::nullopt;
  Place middle{0, 0};
  for (const Place &p : polygon)
    for (std::size_t d = 0; d < 2; ++d)
      middle[d] += p[d] / static_cast<double>(polygon.size());
  const auto hit =
      meet(nodes, count, near.position(middle).value, near.normal(middle), centre_of(count));
  if (!hit || !hit->faces || std::abs(hit->gap) > max_gap)
    return std::nullopt;
  return Piece{number, nodes, std::move(polygon), hit->at,
               layer_distance * largest_diameter(nodes, count)};
}

/// Another piece of the same near facet covers a point and is nearer.
bool hidden(const std::vector<Piece> &pieces, const Piece &own, const Place &at, const Vector &x,
            const Vector &n, std::size_t count, double gap) {
  return std::any_of(pieces.begin(), pieces.end(), [&](const Piece &piece) {
    if (piece.other == own.other || !contains(piece.polygon, at))
      return false;
    const auto hit = meet(piece.nodes, count, x, n, piece.start);
    return hit && hit->faces && std::abs(hit->gap) + own.layer < std::abs(gap);
  });
}

struct Sample { // place in a cell and its share of the cell's area
  Place at;
  double weight;
};

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

/// Quadrature of a polygon; triangles of a fan count with the sign of their area.
std::vector<Sample> samples_of(const Polygon &polygon, const Rule &square, const Rule &triangle) {
  std::vector<Sample> samples;
  if (polygon.size() == 4)
    add_quadrilateral(samples, square, polygon);
  else
    for (std::size_t i = 1; i + 1 < polygon.size(); ++i)
      add_triangle(samples, triangle, polygon[0], polygon[i], polygon[i + 1]);
  return samples;
}

} // namespace

std::vector<PointPair> overlap_points(const Facets &facets, const double *normals,
                                      const Facets &other, const Candidates &candidates,
                                      const Rule &square, const Rule &triangle, double max_gap) {
  std::vector<PointPair> pairs;
  const std::size_t stride = facets.nodes_per_facet * 3;
  for (std::size_t f = 0; f < facets.count; ++f) {
    const double *nodes = facets.nodes + f * stride;
    const Near near{nodes, normals + f * stride, facets.nodes_per_facet,
                    largest_diameter(nodes, facets.nodes_per_facet)};
    std::vector<Piece> pieces;
    for (const std::int64_t number : candidates.of(f))
      if (auto found = piece(near, other, static_cast<std::size_t>(number), max_gap))
        pieces.push_back(std::move(*found));
    for (const Piece &own : pieces)
      for (const Sample &sample : samples_of(own.polygon, square, triangle)) {
        const Field p = near.position(sample.at);
        const Vector n = near.normal(sample.at);
        const auto hit = meet(own.nodes, other.nodes_per_facet, p.value, n, own.start);
        if (!hit || hidden(pieces, own, sample.at, p.value, n, other.nodes_per_facet, hit->gap))
          continue;
        pairs.push_back({static_cast<std::int64_t>(f), static_cast<std::int64_t>(own.other),
                         sample.at, hit->at, sample.weight * norm(cross(p.along_xi, p.along_eta)),
                         hit->gap, n});
      }
  }
  return pairs;
}

} // namespace fretfe::space
