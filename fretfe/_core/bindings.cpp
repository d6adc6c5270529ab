// SPDX-License-Identifier: LGPL-3.0-or-later
// Python bindings: arrays in, arrays out. Defaults and argument checks live in Python.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <cstdint>
#include <vector>

#include "mortar.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace {

using Nodes = nb::ndarray<const double, nb::ndim<3>, nb::c_contig, nb::device::cpu>;
using Values = nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

/// One member of each record as a NumPy array that owns its data.
template <class T, class Member>
nb::ndarray<nb::numpy, T, nb::ndim<1>> column(const std::vector<fretfe::PointPair> &pairs,
                                              Member member) {
  T *data = new T[pairs.size()];
  for (std::size_t i = 0; i < pairs.size(); ++i)
    data[i] = member(pairs[i]);
  nb::capsule owner(data, [](void *p) noexcept { delete[] static_cast<T *>(p); });
  return {data, {pairs.size()}, owner};
}

fretfe::Facets as_facets(const Nodes &nodes) {
  return {nodes.data(), nodes.shape(0), nodes.shape(1)};
}

nb::dict overlap_points(Nodes nodes, Nodes normals, Nodes other, Values points, Values weights,
                        double max_gap) {
  const fretfe::Rule rule{points.data(), weights.data(), points.size()};
  std::vector<fretfe::PointPair> pairs;
  {
    nb::gil_scoped_release release;
    pairs =
        fretfe::overlap_points(as_facets(nodes), normals.data(), as_facets(other), rule, max_gap);
  }
  nb::dict columns;
  columns["facet"] = column<std::int64_t>(pairs, [](const auto &p) { return p.facet; });
  columns["other_facet"] = column<std::int64_t>(pairs, [](const auto &p) { return p.other_facet; });
  columns["xi"] = column<double>(pairs, [](const auto &p) { return p.xi; });
  columns["eta"] = column<double>(pairs, [](const auto &p) { return p.eta; });
  columns["weight"] = column<double>(pairs, [](const auto &p) { return p.weight; });
  columns["gap"] = column<double>(pairs, [](const auto &p) { return p.gap; });
  columns["normal_x"] = column<double>(pairs, [](const auto &p) { return p.normal[0]; });
  columns["normal_y"] = column<double>(pairs, [](const auto &p) { return p.normal[1]; });
  return columns;
}

} // namespace

NB_MODULE(_kernels, m) {
  m.doc() = "Compiled kernels of fretfe.";
  m.def("overlap_points", &overlap_points, "nodes"_a, "normals"_a, "other"_a, "points"_a,
        "weights"_a, "max_gap"_a,
        "Integration points on the overlap segments of two facet chains: a dict of columns.");
}
