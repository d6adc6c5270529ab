// SPDX-License-Identifier: LGPL-3.0-or-later
#include "mortar.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace fretfe {
namespace {

constexpr int max_newton = 30;
// Newton converges quadratically: after a step this small the error is round-off.
constexpr double parameter_tolerance = 1e-10;
// Facet ends are shared by two facets: a hit this far outside [0, 1] still counts as on the facet.
constexpr double end_tolerance = 1e-9;
// Segments shorter than this (in reference length) come from round-off at facet ends.
constexpr double shortest_segment = 1e-10;

struct Curve { // position and derivative at one reference coordinate
  Point value;
  Point derivative;
};

double cross(const Point &a, const Point &b) { return a[0] * b[1] - a[1] * b[0]; }
double dot(const Point &a, const Point &b) { return a[0] * b[0] + a[1] * b[1]; }
Point minus(const Point &a, const Point &b) { return {a[0] - b[0], a[1] - b[1]}; }

/// Lagrange interpolation of nodal vectors (end, end[, middle]) on [0, 1].
Curve interpolate(const double *nodal, std::size_t count, double t) {
  std::array<double, 3> shape{1 - t, t, 0};
  std::array<double, 3> slope{-1, 1, 0};
  if (count == 3) {
    shape = {(1 - t) * (1 - 2 * t), t * (2 * t - 1), 4 * t * (1 - t)};
    slope = {4 * t - 3, 4 * t - 1, 4 - 8 * t};
  }
  Curve c{};
  for (std::size_t k = 0; k < count; ++k)
    for (std::size_t d = 0; d < 2; ++d) {
      c.value[d] += shape[k] * nodal[2 * k + d];
      c.derivative[d] += slope[k] * nodal[2 * k + d];
    }
  return c;
}

/// Nodes of a facet relative to a point. Differences of neighbouring coordinates are exact, so that
/// equations solved with them are as accurate far from the origin as close to it.
std::array<double, 6> seen_from(const Point &x, const double *nodal, std::size_t count) {
  std::array<double, 6> seen{};
  for (std::size_t k = 0; k < count; ++k)
    for (std::size_t d = 0; d < 2; ++d)
      seen[2 * k + d] = nodal[2 * k + d] - x[d];
  return seen;
}

const double *facet_data(const double *data, const Facets &f, std::size_t i) {
  return data + i * f.nodes_per_facet * 2;
}

struct Surface { // near side: geometry and normals of one facet
  const double *nodes;
  const double *normals;
  std::size_t count;

  Curve position(double xi) const { return interpolate(nodes, count, xi); }
  Curve direction(double xi) const { return interpolate(normals, count, xi); }
  Point normal(double xi) const {
    const Point n = direction(xi).value;
    const double length = std::sqrt(dot(n, n));
    return {n[0] / length, n[1] / length};
  }
};

/// Newton's method for a scalar equation; `residual` returns value and derivative.
template <class F> std::optional<double> solve(F residual, double start) {
  double t = start;
  for (int i = 0; i < max_newton; ++i) {
    const auto [value, slope] = residual(t);
    if (slope == 0)
      return std::nullopt;
    const double step = std::clamp(-value / slope, -1.0, 1.0);
    t += step;
    if (t < -2 || t > 3) // leaves the facet for good
      return std::nullopt;
    if (std::abs(step) < parameter_tolerance)
      return t;
  }
  return std::nullopt;
}

/// Reference coordinate at which the normal line of the surface passes through `x`.
std::optional<double> foot(const Surface &s, const Point &x) {
  const auto seen = seen_from(x, s.nodes, s.count);
  auto residual = [&](double xi) {
    const Curve p = interpolate(seen.data(), s.count, xi);
    const Curve n = s.direction(xi);
    return std::array<double, 2>{cross(p.value, n.value),
                                 cross(p.value, n.derivative) + cross(p.derivative, n.value)};
  };
  const Point chord = minus(s.position(1).value, s.position(0).value);
  const double start = dot(minus(x, s.position(0).value), chord) / dot(chord, chord);
  if (start < -1 || start > 2)
    return std::nullopt;
  return solve(residual, start);
}

struct Hit {
  double eta;
  double gap;
};

/// Where the line through `x` along `n` meets a facet of the other side, if it faces `n`.
std::optional<Hit> meet(const Facets &other, std::size_t i, const Point &x, const Point &n) {
  const std::size_t count = other.nodes_per_facet;
  const auto seen = seen_from(x, facet_data(other.nodes, other, i), count);
  auto residual = [&](double eta) {
    const Curve p = interpolate(seen.data(), count, eta);
    return std::array<double, 2>{cross(p.value, n), cross(p.derivative, n)};
  };
  const double at_start = residual(0)[0];
  const double rise = residual(1)[0] - at_start;
  // No rise: the facet is parallel to the line, they never meet.
  const auto eta = rise == 0 ? std::nullopt : solve(residual, -at_start / rise);
  if (!eta)
    return std::nullopt;
  return Hit{*eta, dot(interpolate(seen.data(), count, *eta).value, n)};
}

bool on_facet(double t) { return t > -end_tolerance && t < 1 + end_tolerance; }

/// Facets of the other side are ordered with their body on the left, so their outward normal is the
/// tangent turned clockwise; they face `n` when the two normals oppose each other.
bool faces(const Facets &other, std::size_t i, double eta, const Point &n) {
  const Point t =
      interpolate(facet_data(other.nodes, other, i), other.nodes_per_facet, eta).derivative;
  return dot({t[1], -t[0]}, n) < 0;
}

/// Facet of the other side hit by the normal line from `x`: the nearest one that faces it.
std::optional<std::size_t> partner(const Facets &other, const FacetList &candidates, const Point &x,
                                   const Point &n, double max_gap) {
  std::optional<std::size_t> best;
  double nearest = max_gap;
  for (const std::int64_t number : candidates) {
    const auto i = static_cast<std::size_t>(number);
    const auto hit = meet(other, i, x, n);
    if (hit && on_facet(hit->eta) && std::abs(hit->gap) <= nearest &&
        faces(other, i, hit->eta, n)) {
      nearest = std::abs(hit->gap);
      best = i;
    }
  }
  return best;
}

/// Reference coordinates at which a facet is cut: its ends and the feet of the other side's ends.
std::vector<double> cuts(const Surface &s, const Facets &other, const FacetList &candidates,
                         double max_gap) {
  std::vector<double> at{0, 1};
  for (const std::int64_t i : candidates) {
    const double *nodes = facet_data(other.nodes, other, static_cast<std::size_t>(i));
    for (std::size_t end = 0; end < 2; ++end) {
      const Point x{nodes[2 * end], nodes[2 * end + 1]};
      const auto xi = foot(s, x);
      if (xi && *xi > 0 && *xi < 1 &&
          std::abs(dot(minus(x, s.position(*xi).value), s.normal(*xi))) <= max_gap)
        at.push_back(*xi);
    }
  }
  std::sort(at.begin(), at.end());
  return at;
}

} // namespace

std::vector<PointPair> overlap_points(const Facets &facets, const double *normals,
                                      const Facets &other, const Candidates &candidates,
                                      const Rule &rule, double max_gap) {
  std::vector<PointPair> pairs;
  for (std::size_t f = 0; f < facets.count; ++f) {
    const Surface s{facet_data(facets.nodes, facets, f), facet_data(normals, facets, f),
                    facets.nodes_per_facet};
    const FacetList met = candidates.of(f);
    const std::vector<double> at = cuts(s, other, met, max_gap);
    for (std::size_t k = 0; k + 1 < at.size(); ++k) {
      const double length = at[k + 1] - at[k];
      if (length < shortest_segment)
        continue;
      const double middle = at[k] + length / 2;
      const auto g = partner(other, met, s.position(middle).value, s.normal(middle), max_gap);
      if (!g)
        continue;
      for (std::size_t q = 0; q < rule.size; ++q) {
        const double xi = at[k] + length * rule.points[q];
        const Curve p = s.position(xi);
        const Point n = s.normal(xi);
        const auto hit = meet(other, *g, p.value, n);
        if (!hit)
          continue;
        const double arc = std::sqrt(dot(p.derivative, p.derivative));
        pairs.push_back({static_cast<std::int64_t>(f), static_cast<std::int64_t>(*g), xi, hit->eta,
                         rule.weights[q] * length * arc, hit->gap, n});
      }
    }
  }
  return pairs;
}

} // namespace fretfe
