// SPDX-License-Identifier: LGPL-3.0-or-later
// Factors and products of large dense matrices on several threads.
//
// A matrix is worked on by blocks whose bounds and order of operations do not depend on the number
// of threads, so that results do not either, but for the round-off of symmetric products. Each
// block is left to one thread of the BLAS. Threads take the next block once they have one done, and
// sleep while there is none: where other processes want the same cores, threads that wait for one
// another in the middle of a product lose far more.
#pragma once

#include <cstddef>
#include <cstdint>

namespace fretfe::dense {

/// Routines of BLAS and LAPACK in Fortran's convention.
template <class T> struct Routines {
  void (*gemm)(const char *, const char *, const int *, const int *, const int *, const T *,
               const T *, const int *, const T *, const int *, const T *, T *, const int *);
  void (*gemv)(const char *, const int *, const int *, const T *, const T *, const int *, const T *,
               const int *, const T *, T *, const int *);
  void (*syrk)(const char *, const char *, const int *, const int *, const T *, const T *,
               const int *, const T *, T *, const int *);
  void (*trsm)(const char *, const char *, const char *, const char *, const int *, const int *,
               const T *, const T *, const int *, T *, const int *);
  void (*trmm)(const char *, const char *, const char *, const char *, const int *, const int *,
               const T *, const T *, const int *, T *, const int *);
  void (*symv)(const char *, const int *, const T *, const T *, const int *, const T *, const int *,
               const T *, T *, const int *);
  void (*getrf)(const int *, const int *, T *, const int *, int *, int *);
  void (*potrf)(const char *, const int *, T *, const int *, int *);
  void (*trtri)(const char *, const char *, const int *, T *, const int *, int *);
};

/// Null until Python has told them.
template <class T> Routines<T> &routines() {
  static Routines<T> found{};
  return found;
}

/// LU factors of a matrix (n, n) by columns, in its place, and the row that each row was swapped
/// with. Returns the number of the first row that depends on those before it, counted from 1, or 0.
template <class T> int factorise(T *matrix, int n, int *pivots);

/// Inverse of the upper triangle U of A = Uᵀ U in the place of that of A, a symmetric matrix (n, n)
/// by columns, whose lower triangle is left alone. Returns the number of the first row that is not
/// positive definite, counted from 1, or 0.
int invert_triangle(double *matrix, int n);

/// y = A x for a symmetric matrix (n, n); half of it is read.
void multiply_symmetric(const double *matrix, const double *x, double *y, std::size_t n);

/// A matrix of rows and columns that lie `stride` apart: columns, or rows if it is `by_rows`.
struct Matrix {
  const double *values;
  std::size_t rows, columns, stride;
  bool by_rows;
};

/// Product of a matrix with some vectors, the columns of `vectors` and of `found`.
void multiply(const Matrix &matrix, const double *vectors, std::size_t count, double *found);

/// The same of the upper triangle of a square matrix by columns, or of that transposed.
void multiply_triangle(const Matrix &matrix, bool transpose, const double *vectors,
                       std::size_t count, double *found);

} // namespace fretfe::dense
