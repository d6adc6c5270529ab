// SPDX-License-Identifier: LGPL-3.0-or-later
// Python bindings of the algebra of large matrices.
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <vector>

#include "arrays.hpp"
#include "dense.hpp"
#include "threads.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace {

using fretfe::Numbers, fretfe::Table, fretfe::Values;

// Rows that are gathered at a time.
constexpr std::size_t some = 32;
// Parts of rows that are shorter are read slowly.
constexpr std::size_t shortest = 512;

template <class Number>
void combine_blocks(Table matrix, Numbers row_nodes, Table tested, Numbers column_nodes,
                    Table trial, nb::ndarray<Number, nb::ndim<2>, nb::device::cpu> out) {
  const std::size_t width = matrix.shape(1), count = row_nodes.shape(0),
                    size = column_nodes.shape(0);
  if (tested.shape(1) != 3 || trial.shape(1) != 3 || tested.shape(0) != count ||
      trial.shape(0) != size || out.shape(0) != count || out.shape(1) != size)
    throw nb::value_error("the arrays do not fit one another");
  nb::gil_scoped_release release;
  fretfe::for_each((count + some - 1) / some, [&](std::size_t part) {
    std::vector<double> row(width);
    for (std::size_t i = part * some; i < std::min(count, (part + 1) * some); ++i) {
      std::fill(row.begin(), row.end(), 0.0);
      for (std::size_t a = 0; a < 3; ++a) {
        const double weight = tested.data()[3 * i + a];
        const double *values = matrix.data() + (3 * row_nodes.data()[i] + a) * width;
        if (weight != 0.0)
          for (std::size_t k = 0; k < width; ++k)
            row[k] += weight * values[k];
      }
      for (std::size_t j = 0; j < size; ++j) {
        const double *values = row.data() + 3 * column_nodes.data()[j], *by = trial.data() + 3 * j;
        out(i, j) = static_cast<Number>(values[0] * by[0] + values[1] * by[1] + values[2] * by[2]);
      }
    }
  });
}

/// Rows and columns of a matrix, `some` rows at a time: they stay in the processor's cache.
void gather(Table matrix, Numbers rows, Numbers columns,
            nb::ndarray<double, nb::ndim<2>, nb::device::cpu> out) {
  const std::size_t count = rows.shape(0), size = columns.shape(0), width = matrix.shape(1);
  if (out.shape(0) != count || out.shape(1) != size ||
      (count > 0 && size > 1 && out.stride(1) != 1))
    throw nb::value_error("the arrays do not fit one another");
  nb::gil_scoped_release release;
  fretfe::for_each((count + some - 1) / some, [&](std::size_t part) {
    for (std::size_t i = part * some; i < std::min(count, (part + 1) * some); ++i) {
      const double *values = matrix.data() + rows.data()[i] * width;
      double *to = out.data() + static_cast<std::ptrdiff_t>(i) * out.stride(0);
      for (std::size_t j = 0; j < size; ++j)
        to[j] = values[columns.data()[j]];
    }
  });
}

/// Adds rows times weights to some columns of their sum, four rows at a time: each is read once,
/// the sum for each four of them.
void add_rows(const double *matrix, std::size_t width, const Numbers &rows, const double *weights,
              double *sum, std::size_t length) {
  const std::size_t count = rows.shape(0);
  const std::int64_t *row = rows.data();
  std::size_t i = 0;
  for (; i + 4 <= count; i += 4) {
    const double *a = matrix + row[i] * width, *b = matrix + row[i + 1] * width,
                 *c = matrix + row[i + 2] * width, *d = matrix + row[i + 3] * width;
    const double *by = weights + i;
    for (std::size_t k = 0; k < length; ++k)
      sum[k] += by[0] * a[k] + by[1] * b[k] + by[2] * c[k] + by[3] * d[k];
  }
  for (; i < count; ++i)
    for (std::size_t k = 0; k < length; ++k)
      sum[k] += weights[i] * matrix[row[i] * width + k];
}

void combine_rows(Table matrix, Numbers rows,
                  nb::ndarray<const double, nb::ndim<2>, nb::f_contig, nb::device::cpu> weights,
                  nb::ndarray<double, nb::ndim<2>, nb::f_contig, nb::device::cpu> out) {
  const std::size_t count = rows.shape(0), size = out.shape(0), width = matrix.shape(1);
  if (weights.shape(0) != count || weights.shape(1) != out.shape(1) || size > width)
    throw nb::value_error("the arrays do not fit one another");
  nb::gil_scoped_release release;
  const std::size_t parts = std::max<std::size_t>(1, std::min(fretfe::threads(), size / shortest));
  fretfe::for_each(parts, [&](std::size_t part) {
    const std::size_t begin = part * size / parts, length = (part + 1) * size / parts - begin;
    for (std::size_t j = 0; j < out.shape(1); ++j)
      add_rows(matrix.data() + begin, width, rows, weights.data() + j * count,
               out.data() + j * size + begin, length);
  });
}

/// Tells routines of BLAS and LAPACK by their addresses, in the order of their table.
template <class T> void use_routines(const std::vector<std::uintptr_t> &addresses) {
  auto &known = fretfe::dense::routines<T>();
  static_assert(sizeof(known) == 9 * sizeof(std::uintptr_t));
  if (addresses.size() != 9)
    throw nb::value_error("the table has 9 routines");
  std::memcpy(&known, addresses.data(), sizeof(known));
}

template <class T> using ByColumns = nb::ndarray<T, nb::ndim<2>, nb::f_contig, nb::device::cpu>;
using Pivots = nb::ndarray<std::int32_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

template <class T> int factorise(ByColumns<T> matrix, Pivots pivots) {
  if (matrix.shape(0) != matrix.shape(1) || pivots.shape(0) != matrix.shape(0))
    throw nb::value_error("the arrays do not fit one another");
  nb::gil_scoped_release release;
  return fretfe::dense::factorise(matrix.data(), static_cast<int>(matrix.shape(0)), pivots.data());
}

int invert_triangle(ByColumns<double> matrix) {
  if (matrix.shape(0) != matrix.shape(1))
    throw nb::value_error("the matrix is not square");
  nb::gil_scoped_release release;
  return fretfe::dense::invert_triangle(matrix.data(), static_cast<int>(matrix.shape(0)));
}

void multiply_symmetric(Table matrix, Values vector,
                        nb::ndarray<double, nb::ndim<1>, nb::c_contig, nb::device::cpu> out) {
  const std::size_t n = matrix.shape(0);
  if (matrix.shape(1) != n || vector.shape(0) != n || out.shape(0) != n)
    throw nb::value_error("the arrays do not fit one another");
  nb::gil_scoped_release release;
  fretfe::dense::multiply_symmetric(matrix.data(), vector.data(), out.data(), n);
}

void multiply(nb::ndarray<const double, nb::ndim<2>, nb::device::cpu> matrix,
              nb::ndarray<const double, nb::ndim<2>, nb::f_contig, nb::device::cpu> vectors,
              ByColumns<double> out) {
  const std::size_t rows = matrix.shape(0), columns = matrix.shape(1);
  const bool by_rows = matrix.stride(1) == 1 || columns <= 1;
  if (!(by_rows || matrix.stride(0) == 1 || rows <= 1) || columns != vectors.shape(0) ||
      out.shape(0) != rows || out.shape(1) != vectors.shape(1))
    throw nb::value_error("the arrays do not fit one another");
  const auto apart = static_cast<std::size_t>(matrix.stride(by_rows ? 0 : 1));
  const std::size_t stride = std::max({apart, by_rows ? columns : rows, std::size_t{1}});
  nb::gil_scoped_release release;
  fretfe::dense::multiply({matrix.data(), rows, columns, stride, by_rows}, vectors.data(),
                          vectors.shape(1), out.data());
}

void multiply_triangle(
    nb::ndarray<const double, nb::ndim<2>, nb::device::cpu> matrix, bool transpose,
    nb::ndarray<const double, nb::ndim<2>, nb::f_contig, nb::device::cpu> vectors,
    ByColumns<double> out) {
  const std::size_t n = matrix.shape(0), count = vectors.shape(1);
  if ((n > 1 && matrix.stride(0) != 1) || matrix.shape(1) != n || vectors.shape(0) != n ||
      out.shape(0) != n || out.shape(1) != count)
    throw nb::value_error("the arrays do not fit one another");
  const std::size_t stride = std::max<std::size_t>(matrix.stride(1), n);
  nb::gil_scoped_release release;
  fretfe::dense::multiply_triangle({matrix.data(), n, n, stride, false}, transpose, vectors.data(),
                                   count, out.data());
}

} // namespace

namespace fretfe {

void bind_dense(nb::module_ &m) {
  const char *factorises = "Put LU factors in the place of a matrix (n, n) by columns, and the row "
                           "(from 0) that each was swapped with in `pivots` (n,). Returns the "
                           "first row that depends on those before it, from 1, or 0.";
  using Addresses = std::vector<std::uintptr_t>;
  m.def(
      "use_routines",
      [](const Addresses &single, const Addresses &twice) {
        use_routines<float>(single);
        use_routines<double>(twice);
      },
      "single"_a, "double"_a,
      "Tell the addresses of gemm, gemv, syrk, trsm, trmm, symv, getrf, potrf, trtri of both "
      "precisions.");
  m.def("use_threads", &use_threads, "count"_a,
        "Set how many threads work on large matrices; results differ by round-off at most.");
  m.def("factorise", &factorise<float>, nb::arg("matrix").noconvert(),
        nb::arg("pivots").noconvert(), factorises);
  m.def("factorise", &factorise<double>, nb::arg("matrix").noconvert(),
        nb::arg("pivots").noconvert(), factorises);
  m.def(
      "invert_triangle", &invert_triangle, nb::arg("matrix").noconvert(),
      "Put the inverse of the upper triangle U of A = U^T U in the place of that of A (n, n) by "
      "columns; the lower one is left alone. Returns the first row that is not positive definite, "
      "from 1, or 0.");
  m.def("multiply_symmetric", &multiply_symmetric, "matrix"_a, "vector"_a,
        nb::arg("out").noconvert(), "Write to `out` (n,) a symmetric matrix (n, n) times (n,).");
  m.def("multiply", &multiply, nb::arg("matrix").noconvert(), "vectors"_a,
        nb::arg("out").noconvert(),
        "Write to `out` (r, J) by columns a matrix (r, n) by rows or columns times (n, J).");
  m.def(
      "multiply_triangle", &multiply_triangle, nb::arg("matrix").noconvert(), "transpose"_a,
      "vectors"_a, nb::arg("out").noconvert(),
      "Write to `out` (n, J) by columns the upper triangle of a matrix (n, n) by columns, or that "
      "transposed, times (n, J).");
  m.def("gather", &gather, nb::arg("matrix").noconvert(), "rows"_a, "columns"_a,
        nb::arg("out").noconvert(), "Write to `out` (r, c) some rows and columns of a matrix.");
  m.def("combine_rows", &combine_rows, "matrix"_a, "rows"_a, "weights"_a,
        nb::arg("out").noconvert(),
        "Add to `out` (n, J) by columns some rows (k,) of a matrix times weights (k, J).");
  const char *combines = "Write to `out` (r, c) for nodes of rows and columns t . B . s with the "
                         "3 x 3 blocks B of a matrix (3 N, 3 N), and vectors t of rows (r, 3) and "
                         "s of columns (c, 3).";
  m.def("combine_blocks", &combine_blocks<float>, "matrix"_a, "row_nodes"_a, "tested"_a,
        "column_nodes"_a, "trial"_a, nb::arg("out").noconvert(), combines);
  m.def("combine_blocks", &combine_blocks<double>, "matrix"_a, "row_nodes"_a, "tested"_a,
        "column_nodes"_a, "trial"_a, nb::arg("out").noconvert(), combines);
}

} // namespace fretfe
