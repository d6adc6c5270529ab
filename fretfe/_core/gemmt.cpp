// SPDX-License-Identifier: LGPL-3.0-or-later
// dgemmt of the BLAS at the speed of dgemm.
//
// MUMPS updates symmetric fronts with dgemmt, which OpenBLAS (0.3.32) does column by column with
// dgemv, at a third of the speed of dgemm (https://github.com/OpenMathLib/OpenBLAS/issues/4921). In
// a process that loads this library before its BLAS, for all to see, MUMPS finds this routine.

#include <atomic>
#include <cstddef>
#include <cstdio>
#include <cstdlib>

extern "C" {

// The hidden arguments at the end are the lengths of the texts, which a BLAS in Fortran expects.
using Dgemm = void(const char *transa, const char *transb, const int *m, const int *n, const int *k,
                   const double *alpha, const double *a, const int *lda, const double *b,
                   const int *ldb, const double *beta, double *c, const int *ldc, std::size_t,
                   std::size_t);

/// dgemm of the BLAS that MUMPS calls; whoever loads this library says where it is.
Dgemm *fretfe_dgemm = nullptr;

/// Number of calls of dgemmt_ that had something to do.
std::atomic<long> fretfe_dgemmt_calls{0};

} // extern "C"

namespace {

// Triangles of up to this size are computed as squares, twice the work.
constexpr int smallest = 48;

/// The arguments of dgemmt that are the same for all parts of C.
struct Update {
  bool lower;
  const char *transa, *transb;
  int k;
  double alpha;
  const double *a;
  int lda;
  const double *b;
  int ldb;
  double beta;
  int ldc;

  /// C := alpha op(A) op(B) + factor C for m rows of op(A) from `row` and n columns of op(B) from
  /// `column`.
  void rectangle(int row, int column, int m, int n, double factor, double *c, int stride) const {
    const double *rows = a + (plain(*transa) ? row : static_cast<std::ptrdiff_t>(row) * lda);
    const double *columns =
        b + (plain(*transb) ? static_cast<std::ptrdiff_t>(column) * ldb : column);
    fretfe_dgemm(transa, transb, &m, &n, &k, &alpha, rows, &lda, columns, &ldb, &factor, c, &stride,
                 1, 1);
  }

  /// A triangle of n rows from `first` on, which C points to: two of half the size, and the square
  /// between them.
  void triangle(int first, int n, double *c) const {
    if (n <= smallest)
      return small_triangle(first, n, c);
    const int half = n / 2;
    double *rest = c + half + static_cast<std::ptrdiff_t>(half) * ldc;
    triangle(first, half, c);
    if (lower)
      rectangle(first + half, first, n - half, half, beta, c + half, ldc);
    else
      rectangle(first, first + half, half, n - half, beta,
                c + static_cast<std::ptrdiff_t>(half) * ldc, ldc);
    triangle(first + half, n - half, rest);
  }

private:
  static bool plain(char trans) { return trans == 'N' || trans == 'n'; }

  void small_triangle(int first, int n, double *c) const {
    double square[smallest * smallest];
    rectangle(first, first, n, n, 0.0, square, n);
    for (int column = 0; column < n; ++column) {
      const double *from = square + static_cast<std::ptrdiff_t>(column) * n;
      double *to = c + static_cast<std::ptrdiff_t>(column) * ldc;
      const int begin = lower ? column : 0, end = lower ? n : column + 1;
      for (int row = begin; row < end; ++row) // what C held before may be no number if beta is 0
        to[row] = beta == 0.0 ? from[row] : from[row] + beta * to[row];
    }
  }
};

} // namespace

/// C := alpha op(A) op(B) + beta C, one triangle of an n by n matrix, for op(A) with k columns.
extern "C" void dgemmt_(const char *uplo, const char *transa, const char *transb, const int *n,
                        const int *k, const double *alpha, const double *a, const int *lda,
                        const double *b, const int *ldb, const double *beta, double *c,
                        const int *ldc) {
  if (*n <= 0)
    return;
  if (!fretfe_dgemm) {
    std::fputs("fretfe: dgemmt was called before it was told where dgemm is\n", stderr);
    std::abort();
  }
  ++fretfe_dgemmt_calls;
  const bool lower = *uplo == 'L' || *uplo == 'l';
  Update{lower, transa, transb, *k, *alpha, a, *lda, b, *ldb, *beta, *ldc}.triangle(0, *n, c);
}
