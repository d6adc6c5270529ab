// SPDX-License-Identifier: LGPL-3.0-or-later
// Python bindings: arrays in, arrays out. Defaults and argument checks live in Python.
#include <algorithm>
#include <array>
#include <cstdint>
#include <type_traits>
#include <vector>

#include "arrays.hpp"
#include "edge_memory.hpp"
#include "moments.hpp"
#include "mortar.hpp"
#include "mortar_space.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace {

using Nodes = nb::ndarray<const double, nb::ndim<3>, nb::c_contig, nb::device::cpu>;
using Tables = nb::ndarray<const double, nb::ndim<5>, nb::c_contig, nb::device::cpu>;
using Sides = nb::ndarray<const std::int32_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using fretfe::Numbers, fretfe::Table, fretfe::Values;

/// One member of each record as a NumPy array that owns its data.
template <class Pair, class Member> auto column(const std::vector<Pair> &pairs, Member member) {
  using T = std::decay_t<decltype(member(pairs.front()))>;
  T *data = new T[pairs.size()];
  for (std::size_t i = 0; i < pairs.size(); ++i)
    data[i] = member(pairs[i]);
  nb::capsule owner(data, [](void *p) noexcept { delete[] static_cast<T *>(p); });
  return nb::ndarray<nb::numpy, T, nb::ndim<1>>(data, {pairs.size()}, owner);
}

/// One member with several components of each record, (n, components).
template <class Pair, class Member> auto rows(const std::vector<Pair> &pairs, Member member) {
  constexpr std::size_t size = std::tuple_size_v<std::decay_t<decltype(member(pairs.front()))>>;
  double *data = new double[size * pairs.size()];
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto &row = member(pairs[i]);
    std::copy(row.begin(), row.end(), data + size * i);
  }
  nb::capsule owner(data, [](void *p) noexcept { delete[] static_cast<double *>(p); });
  return nb::ndarray<nb::numpy, double, nb::ndim<2>>(data, {pairs.size(), size}, owner);
}

nb::tuple overlap_points(Nodes nodes, Nodes normals, Nodes other, Numbers starts,
                         Numbers candidates, Values points, Values weights, double max_gap) {
  const fretfe::Rule rule{points.data(), weights.data(), points.size()};
  std::vector<fretfe::PointPair> pairs;
  {
    nb::gil_scoped_release release;
    pairs = fretfe::overlap_points({nodes.data(), nodes.shape(0), nodes.shape(1)}, normals.data(),
                                   {other.data(), other.shape(0), other.shape(1)},
                                   {starts.data(), candidates.data()}, rule, max_gap);
  }
  return nb::make_tuple(column(pairs, [](const auto &p) { return p.facet; }),
                        column(pairs, [](const auto &p) { return p.other_facet; }),
                        column(pairs, [](const auto &p) { return p.xi; }),
                        column(pairs, [](const auto &p) { return p.eta; }),
                        column(pairs, [](const auto &p) { return p.weight; }),
                        column(pairs, [](const auto &p) { return p.gap; }),
                        rows(pairs, [](const auto &p) { return p.normal; }));
}

nb::tuple overlap_points_in_space(Nodes nodes, Nodes normals, Nodes other, Numbers starts,
                                  Numbers candidates, Table square, Values square_weights,
                                  Table triangle, Values triangle_weights, double max_gap) {
  const fretfe::space::Rule on_square{square.data(), square_weights.data(), square.shape(0)};
  const fretfe::space::Rule on_triangle{triangle.data(), triangle_weights.data(),
                                        triangle.shape(0)};
  std::vector<fretfe::space::PointPair> pairs;
  {
    nb::gil_scoped_release release;
    pairs = fretfe::space::overlap_points(
        {nodes.data(), nodes.shape(0), nodes.shape(1)}, normals.data(),
        {other.data(), other.shape(0), other.shape(1)}, {starts.data(), candidates.data()},
        on_square, on_triangle, max_gap);
  }
  return nb::make_tuple(column(pairs, [](const auto &p) { return p.facet; }),
                        column(pairs, [](const auto &p) { return p.other_facet; }),
                        rows(pairs, [](const auto &p) { return p.at; }),
                        rows(pairs, [](const auto &p) { return p.other_at; }),
                        column(pairs, [](const auto &p) { return p.weight; }),
                        column(pairs, [](const auto &p) { return p.gap; }),
                        rows(pairs, [](const auto &p) { return p.normal; }));
}

/// `tabulate_tensor` of UFCx, and its argument for further data, which older versions lack and no
/// calling convention minds.
using Kernel = void (*)(double *, const double *, const double *, const double *, const int *,
                        const std::uint8_t *, void *);

auto tabulate(std::uintptr_t kernel, Values constants, Table coefficients, Nodes coordinates,
              Sides sides, std::size_t size) {
  const std::size_t count = coordinates.shape(0), width = coefficients.shape(1);
  const std::size_t places = coordinates.shape(1) * coordinates.shape(2);
  double *data = new double[count * size]();
  nb::capsule owner(data, [](void *p) noexcept { delete[] static_cast<double *>(p); });
  {
    nb::gil_scoped_release release;
    const auto function = reinterpret_cast<Kernel>(kernel);
    for (std::size_t i = 0; i < count; ++i) {
      const int side = sides.data()[i];
      function(data + size * i, coefficients.data() + width * i, constants.data(),
               coordinates.data() + places * i, &side, nullptr, nullptr);
    }
  }
  return nb::ndarray<nb::numpy, double, nb::ndim<2>>(data, {count, size}, owner);
}

auto fit_moments(Tables tables, double first, double step, Table shares, Table moments, Table sigma,
                 Values bends, std::size_t terms, double farthest, int corrections) {
  namespace own = fretfe::moments;
  const std::size_t count = moments.shape(1), size = moments.shape(0);
  if (count > own::most_bumps || terms + 2 > own::most_unknowns || terms + 2 > tables.shape(4) ||
      count > tables.shape(3))
    throw nb::value_error("there are more bumps or terms than the tables have");
  const own::Tables known{
      tables.data(), tables.shape(0), tables.shape(2), tables.shape(3), tables.shape(4), first,
      step};
  std::vector<own::Fit> fits(size);
  {
    nb::gil_scoped_release release;
    for (std::size_t i = 0; i < size; ++i)
      fits[i] = own::fit(known, shares.data() + i * shares.shape(1),
                         {moments.data() + i * count, sigma.data() + i * count, count},
                         bends.data()[i], terms, {farthest, corrections});
  }
  return rows(fits, [](const own::Fit &each) {
    return std::array<double, 6>{each.place,       each.factor,       each.slope,
                                 each.place_error, each.factor_error, each.rest};
  });
}

nb::tuple follow_edge(Values hold, Values shear, Values friction, Values slid, std::size_t first,
                      bool at_once) {
  namespace own = fretfe::edge_memory;
  const std::size_t count = hold.shape(0);
  if (shear.shape(0) != count || friction.shape(0) != count || slid.shape(0) != count ||
      first >= count)
    throw nb::value_error("the arrays do not fit one another");
  own::Followed found;
  {
    nb::gil_scoped_release release;
    found = own::follow({hold.data(), shear.data(), friction.data(), slid.data(), count}, first,
                        at_once);
  }
  const auto same = [](double value) { return value; };
  return nb::make_tuple(
      column(found.way, same), column(found.front, same),
      column(found.slices, [](const auto &each) { return each.state; }),
      rows(found.slices,
           [](const auto &each) { return std::array<double, 3>{each.low, each.high, each.taken}; }),
      rows(found.locked,
           [](const auto &each) { return std::array<double, 2>{each.low, each.share}; }));
}

} // namespace

NB_MODULE(_kernels, m) {
  m.doc() = "Compiled kernels of fretfe.";
  fretfe::bind_dense(m);
  m.def("overlap_points", &overlap_points, "nodes"_a, "normals"_a, "other"_a, "starts"_a,
        "candidates"_a, "points"_a, "weights"_a, "max_gap"_a,
        "Integration points on the overlap segments of two facet chains: facet, other facet, "
        "reference coordinates on both, weight, gap, normal.");
  m.def("overlap_points_in_space", &overlap_points_in_space, "nodes"_a, "normals"_a, "other"_a,
        "starts"_a, "candidates"_a, "square"_a, "square_weights"_a, "triangle"_a,
        "triangle_weights"_a, "max_gap"_a,
        "Integration points on the overlap of two surfaces in space: facet, other facet, "
        "reference coordinates on both, weight, gap, normal.");
  m.def("tabulate", &tabulate, "kernel"_a, "constants"_a, "coefficients"_a, "coordinates"_a,
        "sides"_a, "size"_a,
        "Element vectors (n, size) by a compiled UFCx kernel at an address, of n elements with "
        "their coefficients (n, w), nodes (n, k, 3) and local numbers of a facet (n,).");
  m.def("fit_moments", &fit_moments, "tables"_a, "first"_a, "step"_a, "shares"_a, "moments"_a,
        "sigma"_a, "bends"_a, "terms"_a, "farthest"_a, "corrections"_a,
        "Series behind fronts by least squares to moments (m, bumps): place, first factor, second "
        "over first, errors of place and first factor, sum of squares left, (m, 6). Tables "
        "(exponents, 4, pieces, bumps, columns) are cubic between places, shares (m, exponents).");
  m.def("follow_edge", &follow_edge, "hold"_a, "shear"_a, "friction"_a, "slid"_a, "first"_a,
        "at_once"_a,
        "Follow what an edge remembers through states (n,) from one on: way and front of the slip "
        "in the step to each, states (m,) and lowest and highest hold and shear taken (m, 3) of "
        "all slices, and lowest hold and share (k, 2) of what is locked in at the end.");
}
