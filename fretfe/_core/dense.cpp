// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dense.hpp"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <utility>
#include <vector>

#include "threads.hpp"

namespace fretfe::dense {
namespace {

// Columns of a block of factors: as wide as one thread is not slower for.
constexpr int panel = 192;
// Rows of a block of a product: what is read twice stays in the processor's cache.
constexpr int tile = 256;

/// Blocks of columns that are finished one after the other, each once all before it have been
/// applied to it in order.
///
/// Which thread does what is open. The first column that can go on does: the next one to be
/// finished is never kept waiting by those that follow it.
template <class Columns> class Order {
public:
  explicit Order(Columns &columns) : columns_(columns), applied_(columns.count()) {}

  void run() { on_threads(applied_.size(), std::ref(*this)); }

  void operator()() {
    std::unique_lock<std::mutex> lock(mutex_);
    while (finished_ < applied_.size()) {
      const std::size_t column = next();
      if (column == applied_.size()) {
        // `wait` would need the C++ library of GCC 12, which systems with older ones have not.
        changed_.wait_for(lock, std::chrono::seconds(1));
        continue;
      }
      const std::size_t from = applied_[column].first;
      applied_[column].second = true;
      lock.unlock();
      if (from == column)
        columns_.finish(static_cast<int>(column));
      else
        columns_.apply(static_cast<int>(from), static_cast<int>(column));
      lock.lock();
      applied_[column] = {from + 1, false};
      finished_ += from == column;
      changed_.notify_all();
    }
  }

private:
  /// The first column that nobody works on and that has something to do; their number if none has.
  std::size_t next() const {
    std::size_t column = finished_;
    while (
        column < applied_.size() &&
        (applied_[column].second || (applied_[column].first == finished_ && column != finished_)))
      ++column;
    return column;
  }

  Columns &columns_;
  std::vector<std::pair<std::size_t, bool>> applied_; // how many columns, and whether busy
  std::size_t finished_ = 0;
  std::mutex mutex_;
  std::condition_variable changed_;
};

/// A square matrix by columns, in blocks of columns.
template <class T> struct Blocks {
  T *matrix;
  int n;
  int failed = 0; // number of a row, from 1

  std::size_t count() const { return static_cast<std::size_t>((n + panel - 1) / panel); }
  int width(int block) const { return std::min(panel, n - block * panel); }
  T *at(int row, int column) const {
    return matrix + row + static_cast<std::ptrdiff_t>(column) * n;
  }
  void note(int failure, int begin) {
    if (failure && !failed)
      failed = begin + failure;
  }
};

constexpr char left = 'L', right = 'R', lower = 'L', upper = 'U', plain = 'N', transposed = 'T',
               unit = 'U', own = 'N';

/// Adds op(A) B to C, of `rows` rows, for some vectors B of `inner` rows; C counts `before` times,
/// 0 or 1.
void add_product(const char *as, int rows, int width, int inner, const double *a, int stride,
                 const double *b, int deep, double before, double *c, int high) {
  const auto &blas = routines<double>();
  const double plus = 1;
  const int one = 1, &first = *as == plain ? rows : inner, &second = *as == plain ? inner : rows;
  if (width == 1) {  // faster than a product of matrices
    if (before == 0) // by itself it leaves C alone without columns, and NaN in it at all times
      std::fill_n(c, rows, 0.0);
    blas.gemv(as, &first, &second, &plus, a, &stride, b, &one, &plus, c, &one);
  } else
    blas.gemm(as, &plain, &rows, &width, &inner, &plus, a, &stride, b, &deep, &before, c, &high);
}

template <class T> struct Factors : Blocks<T> {
  int *pivots;

  void apply(int from, int to) {
    const int begin = from * panel, column = to * panel;
    const int inner = this->width(from), width = this->width(to), rest = this->n - begin - inner;
    const T one = 1, minus = -1;
    swap(from, to);
    const auto &blas = routines<T>();
    blas.trsm(&left, &lower, &plain, &unit, &inner, &width, &one, this->at(begin, begin), &this->n,
              this->at(begin, column), &this->n);
    blas.gemm(&plain, &plain, &rest, &width, &inner, &minus, this->at(begin + inner, begin),
              &this->n, this->at(begin, column), &this->n, &one, this->at(begin + inner, column),
              &this->n);
  }

  void finish(int block) {
    const int begin = block * panel, rows = this->n - begin, width = this->width(block);
    int failure = 0;
    routines<T>().getrf(&rows, &width, this->at(begin, begin), &this->n, pivots + begin, &failure);
    this->note(failure, begin);
    for (int row = begin; row < begin + width; ++row)
      pivots[row] += begin - 1;
  }

  /// Swaps the rows of blocks that were finished before later ones swapped theirs.
  void swap_finished() {
    const auto count = static_cast<int>(this->count());
    for_each(this->count(), [this, count](std::size_t block) {
      for (int later = static_cast<int>(block) + 1; later < count; ++later)
        swap(later, static_cast<int>(block));
    });
  }

  /// Swaps rows of a block of columns as those of another one were.
  void swap(int as, int block) {
    for (int column = block * panel; column < block * panel + this->width(block); ++column) {
      T *values = this->at(0, column);
      for (int row = as * panel; row < as * panel + this->width(as); ++row)
        std::swap(values[row], values[pivots[row]]);
    }
  }
};

/// The upper triangle of factors: only columns that are finished are read beside one's own.
struct Cholesky : Blocks<double> {
  void apply(int from, int to) {
    const int begin = from * panel, column = to * panel, inner = width(from), width_to = width(to);
    const double one = 1, minus = -1;
    const auto &blas = routines<double>();
    blas.gemm(&transposed, &plain, &inner, &width_to, &begin, &minus, at(0, begin), &n,
              at(0, column), &n, &one, at(begin, column), &n);
    blas.trsm(&left, &upper, &transposed, &own, &inner, &width_to, &one, at(begin, begin), &n,
              at(begin, column), &n);
  }

  void finish(int block) {
    const int begin = block * panel, size = width(block);
    const double one = 1, minus = -1;
    const auto &blas = routines<double>();
    blas.syrk(&upper, &transposed, &size, &begin, &minus, at(0, begin), &n, &one, at(begin, begin),
              &n);
    int failure = 0;
    blas.potrf(&upper, &size, at(begin, begin), &n, &failure);
    note(failure, begin);
  }
};

/// The inverse of an upper triangle: a block of columns becomes the inverse of those before it
/// times itself, then minus that times the inverse of its corner.
struct Triangle : Blocks<double> {
  void apply(int from, int to) {
    const int begin = from * panel, column = to * panel, inner = width(from), width_to = width(to);
    const double one = 1;
    const auto &blas = routines<double>();
    blas.gemm(&plain, &plain, &begin, &width_to, &inner, &one, at(0, begin), &n, at(begin, column),
              &n, &one, at(0, column), &n);
    blas.trmm(&left, &upper, &plain, &own, &inner, &width_to, &one, at(begin, begin), &n,
              at(begin, column), &n);
  }

  void finish(int block) {
    const int begin = block * panel, size = width(block);
    const double minus = -1;
    int failure = 0;
    const auto &blas = routines<double>();
    blas.trtri(&upper, &own, &size, at(begin, begin), &n, &failure);
    blas.trmm(&right, &upper, &plain, &own, &begin, &size, &minus, at(begin, begin), &n,
              at(0, begin), &n);
  }
};

} // namespace

template <class T> int factorise(T *matrix, int n, int *pivots) {
  Factors<T> factors{{matrix, n}, pivots};
  Order(factors).run();
  factors.swap_finished();
  return factors.failed;
}

template int factorise(float *, int, int *);
template int factorise(double *, int, int *);

int invert_triangle(double *matrix, int n) {
  Cholesky factor{{matrix, n}};
  Order(factor).run();
  if (factor.failed)
    return factor.failed;
  Triangle inverse{{matrix, n}};
  Order(inverse).run();
  return 0;
}

void multiply_symmetric(const double *matrix, const double *x, double *y, std::size_t n) {
  // The triangle whose rows end at the diagonal; columns, for the BLAS.
  const std::size_t count = (n + tile - 1) / tile;
  const auto &blas = routines<double>();
  const int one = 1, stride = static_cast<int>(n);
  const double plus = 1;
  if (threads() == 1) { // each entry is read once, not once from memory and once nearby
    std::fill_n(y, n, 0.0);
    blas.symv(&upper, &stride, &plus, matrix, &stride, x, &one, &plus, y, &one);
    return;
  }
  std::vector<std::vector<double>> sums(count);
  for_each(count, [&](std::size_t number) {
    const std::size_t own_tile = count - 1 - number, begin = own_tile * tile; // the longest first
    const int width = static_cast<int>(std::min<std::size_t>(tile, n - begin));
    std::vector<double> sum(begin + width, 0.0);
    for (std::size_t row = 0; row < begin; row += tile) {
      const double *values = matrix + begin * n + row;
      add_product(&transposed, width, 1, tile, values, stride, x + row, tile, 1.0,
                  sum.data() + begin, width);
      add_product(&plain, tile, 1, width, values, stride, x + begin, width, 1.0, sum.data() + row,
                  tile);
    }
    blas.symv(&upper, &width, &plus, matrix + begin * n + begin, &stride, x + begin, &one, &plus,
              sum.data() + begin, &one);
    sums[own_tile] = std::move(sum);
  });
  std::fill(y, y + n, 0.0);
  for (const auto &sum : sums)
    for (std::size_t i = 0; i < sum.size(); ++i)
      y[i] += sum[i];
}

void multiply(const Matrix &matrix, const double *vectors, std::size_t count, double *found) {
  const int inner = static_cast<int>(matrix.columns), width = static_cast<int>(count);
  for_each((matrix.rows + tile - 1) / tile, [&](std::size_t number) {
    const std::size_t begin = number * tile;
    const int height = static_cast<int>(std::min<std::size_t>(tile, matrix.rows - begin));
    const double *values = matrix.values + begin * (matrix.by_rows ? matrix.stride : 1);
    add_product(matrix.by_rows ? &transposed : &plain, height, width, inner, values,
                static_cast<int>(matrix.stride), vectors, std::max(inner, 1), 0.0, found + begin,
                static_cast<int>(matrix.rows));
  });
}

void multiply_triangle(const Matrix &matrix, bool transpose, const double *vectors,
                       std::size_t count, double *found) {
  const std::size_t n = matrix.rows, stride = matrix.stride;
  const int width = static_cast<int>(count), apart = static_cast<int>(stride);
  const int length = static_cast<int>(n);
  const double plus = 1;
  const char *as = transpose ? &transposed : &plain;
  for_each((n + tile - 1) / tile, [&](std::size_t number) {
    const std::size_t begin = number * tile, end = std::min<std::size_t>(begin + tile, n);
    // What stands above the corner if transposed, or right of it.
    const std::size_t first = transpose ? 0 : end, last = transpose ? begin : n;
    const int height = static_cast<int>(end - begin), inner = static_cast<int>(last - first);
    const double *rest = matrix.values + (transpose ? begin * stride : begin + end * stride);
    for (std::size_t j = 0; j < count; ++j)
      std::copy(vectors + j * n + begin, vectors + j * n + end, found + j * n + begin);
    const auto &blas = routines<double>();
    blas.trmm(&left, &upper, as, &own, &height, &width, &plus,
              matrix.values + begin + begin * stride, &apart, found + begin, &length);
    add_product(as, height, width, inner, rest, apart, vectors + first, length, 1.0, found + begin,
                length);
  });
}

} // namespace fretfe::dense
