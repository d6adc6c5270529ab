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
// Of foot points further than this (in reference length) from their cell the side matters only.
constexpr double farthest_foot = 1.0;
// Newton's method does not come back from this far (in reference length) outside a facet.
constexpr double leaves_for_good = 3;
// Polygons have straight edges where curved facets have curved ones: points may be hit this far
// (in reference length) outside a facet, whose shape continues there.
constexpr double farthest_hit = 0.1;
// Edges that leave the line between their ends by less than this fraction of it are straight.
constexpr double straight_edge = 1e-4;
// Edges do not leave the line between their ends by more than this fraction of their facet.
constexpr double largest_bulge = 0.25;
// Polygons smaller than this (in reference area) come from round-off at facet edges.
constexpr double smallest_area = 1e-10;
// Facets that hide another one are nearer by this fraction of its size; neighbours are not.
constexpr double layer_distance = 0.1;
// An edge is never cut into more pieces than this.
constexpr double most_pieces = 8;

struct Near { // geometry and normals of one facet of the near side
  const double *nodes;
  const double *normals;
  std::size_t count;
  double size; // largest distance of two corners

  Field position(const Place &at, const Vector &origin = {0, 0, 0}) const {
    return interpolate(nodes, count, at, origin);
  }
  Vector normal(const Place &at) const {
    const Vector n = interpolate(normals, count, at).value;
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
    const Field p = interpolate(near.nodes, near.count, at, x);
    const Field n = interpolate(near.normals, near.count, at);
    const auto step = solve(p.along_xi + along * n.along_xi, p.along_eta + along * n.along_eta,
                            n.value, -1 * (p.value + along * n.value));
    if (!step)
      break;
    at = {at[0] + (*step)[0], at[1] + (*step)[1]};
    along += (*step)[2];
    if (!seen_from_centre)
      seen_from_centre = at;
    if (!(outside(near.count, at) < leaves_for_good))
      break;
    if (std::max(std::abs((*step)[0]), std::abs((*step)[1])) < parameter_tolerance)
      return outside(near.count, at) < farthest_foot ? at : seen_from_centre;
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
    const Field p = interpolate(nodes, count, at, x);
    const auto step = solve(p.along_xi, p.along_eta, -1 * n, -1 * p.value);
    if (!step)
      return std::nullopt;
    at = {at[0] + (*step)[0], at[1] + (*step)[1]};
    if (!(outside(count, at) < leaves_for_good))
      return std::nullopt;
    if (std::max(std::abs((*step)[0]), std::abs((*step)[1])) < parameter_tolerance) {
      const Field found = interpolate(nodes, count, at, x);
      const bool faces = dot(cross(found.along_xi, found.along_eta), n) < 0;
      if (outside(count, at) > farthest_hit)
        return std::nullopt;
      return Hit{at, dot(found.value, n), faces};
    }
  }
  return std::nullopt;
}

/// Feet of the points that cut an edge between the nodes (from, to[, middle]) into pieces.
///
/// How an edge is cut depends on nothing but the edge: neighbours cut it alike. Those much longer
/// than the near facet are cut more often. Straight edges too may be curved as seen by the near
/// facet; none of the feet count if all are on the line between `ends`.
std::optional<Polygon> inner_feet(const Near &near, const std::array<Vector, 3> &edge, bool linear,
                                  const std::array<Place, 2> &ends) {
  const double ratio = std::round(norm(edge[1] - edge[0]) / near.size);
  const int pieces = 2 * static_cast<int>(std::clamp(ratio, 1.0, most_pieces));
  const Place line = minus(ends[1], ends[0]);
  const double allowed = straight_edge * dot(line, line);
  Polygon feet;
  bool straight = true;
  for (int k = 1; k < pieces; ++k) {
    const auto s = line_values(linear, static_cast<double>(k) / pieces);
    const auto at = foot(near, s[0] * edge[0] + s[1] * edge[1] + s[2] * edge[2]);
    if (!at)
      return std::nullopt;
    feet.push_back(*at);
    straight = straight && std::abs(cross(line, minus(*at, ends[0]))) <= allowed;
  }
  return straight ? Polygon{} : feet;
}

/// All corners of a polygon are so far beyond a side of the cell that the rest is there too.
bool beyond(std::size_t count, const Polygon &corner_feet) {
  double size = 0;
  for (const Place &p : corner_feet)
    size = std::max(size, norm(minus(p, corner_feet[0])));
  const auto all = [&](auto distance) {
    return std::all_of(corner_feet.begin(), corner_feet.end(),
                       [&](const Place &p) { return distance(p) < -largest_bulge * size; });
  };
  if (all([](const Place &p) { return p[0]; }) || all([](const Place &p) { return p[1]; }))
    return true;
  if (is_triangle(count))
    return all([](const Place &p) { return 1 - p[0] - p[1]; });
  return all([](const Place &p) { return 1 - p[0]; }) ||
         all([](const Place &p) { return 1 - p[1]; });
}

/// Outline of a facet of the other side as seen by a near one, clockwise seen from outside its
/// body; none where no normal line of the near facet meets it.
std::optional<Polygon> outline(const Near &near, const double *nodes, std::size_t count) {
  const std::size_t sides = corners(count);
  const bool linear = count == sides;
  Polygon corner_feet;
  for (std::size_t i = 0; i < sides; ++i) {
    const auto at = foot(near, node(nodes, i));
    if (!at)
      return std::nullopt;
    corner_feet.push_back(*at);
  }
  if (beyond(near.count, corner_feet))
    return std::nullopt;
  Polygon polygon;
  for (std::size_t i = sides; i-- > 0;) {
    const std::size_t from = (i + 1) % sides;
    const Vector middle = linear ? Vector{} : node(nodes, sides + i);
    const auto inner = inner_feet(near, {node(nodes, from), node(nodes, i), middle}, linear,
                                  {corner_feet[from], corner_feet[i]});
    if (!inner)
      return std::nullopt;
    polygon.push_back(corner_feet[from]);
    polygon.insert(polygon.end(), inner->begin(), inner->end());
  }
  return polygon;
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
  auto seen = outline(near, nodes, count);
  if (!seen)
    return std::nullopt;
  Polygon polygon = inside_cell(near.count, std::move(*seen));
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
