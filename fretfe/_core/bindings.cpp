// SPDX-License-Identifier: LGPL-3.0-or-later
// Python bindings: arrays in, arrays out. Defaults and argument checks live in Python.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <algorithm>
#include <cstdint>
#include <type_traits>
#include <vector>

#include "mortar.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace {

using Nodes = nb::ndarray<const double, nb::ndim<3>, nb::c_contig, nb::device::cpu>;
using Values = nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Numbers = nb::ndarray<const std::int64_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Pairs = std::vector<fretfe::PointPair>;

/// One member of each record as a NumPy array that owns its data.
template <class Member> auto column(const Pairs &pairs, Member member) {
  using T = std::decay_t<decltype(member(pairs.front()))>;
  T *data = new T[pairs.size()];
  for (std::size_t i = 0; i < pairs.size(); ++i)
    data[i] = member(pairs[i]);
  nb::capsule owner(data, [](void *p) noexcept { delete[] static_cast<T *>(p); });
  return nb::ndarray<nb::numpy, T, nb::ndim<1>>(data, {pairs.size()}, owner);
}

/// Normals (n, 2) of all records.
nb::ndarray<nb::numpy, double, nb::ndim<2>> normals_of(const Pairs &pairs) {
  double *data = new double[2 * pairs.size()];
  for (std::size_t i = 0; i < pairs.size(); ++i)
    std::copy(pairs[i].normal.begin(), pairs[i].normal.end(), data + 2 * i);
  nb::capsule owner(data, [](void *p) noexcept { delete[] static_cast<double *>(p); });
  return {data, {pairs.size(), 2}, owner};
}

fretfe::Facets as_facets(const Nodes &nodes) {
  return {nodes.data(), nodes.shape(0), nodes.shape(1)};
}

nb::tuple overlap_points(Nodes nodes, Nodes normals, Nodes other, Numbers starts,
                         Numbers candidates, Values points, Values weights, double max_gap) {
  const fretfe::Rule rule{points.data(), weights.data(), points.size()};
  Pairs pairs;
  {
    nb::gil_scoped_release release;
    pairs = fretfe::overlap_points(as_facets(nodes), normals.data(), as_facets(other),
                                   {starts.data(), candidates.data()}, rule, max_gap);
  }
  return nb::make_tuple(column(pairs, [](const auto &p) { return p.facet; }),
                        column(pairs, [](const auto &p) { return p.other_facet; }),
                        column(pairs, [](const auto &p) { return p.xi; }),
                        column(pairs, [](const auto &p) { return p.eta; }),
                        column(pairs, [](const auto &p) { return p.weight; }),
                        column(pairs, [](const auto &p) { return p.gap; }), normals_of(pairs));
}

} // namespace

NB_MODULE(_kernels, m) {
  m.doc() = "Compiled kernels of fretfe.";
  m.def("overlap_points", &overlap_points, "nodes"_a, "normals"_a, "other"_a, "starts"_a,
        "candidates"_a, "points"_a, "weights"_a, "max_gap"_a,
        "Integration points on the overlap segments of two facet chains: facet, other facet, "
        "reference coordinates on both, weight, gap, normal.");
}
