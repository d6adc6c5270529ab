// SPDX-License-Identifier: LGPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>

namespace fretfe::moments {

/// Bumps, and unknowns of a fit, at most.
constexpr std::size_t most_bumps = 16, most_unknowns = 8;

/// Moments of powers of the distance from a front, and of a spread, by the place of the front:
/// cubic polynomials between equally spaced places, a table of them for each exponent.
struct Tables {
  const double *values; // (exponents, 4, pieces, bumps, columns), highest power of the place first
  std::size_t exponents, pieces, bumps, columns;
  double first, step; // of the places
};

/// What a fit may do: the place stays within `farthest`, and is corrected so many times.
struct Search {
  double farthest;
  int corrections;
};

/// Measured moments (count,), and their standard deviations.
struct Measured {
  const double *moments, *sigma;
  std::size_t count;
};

/// Place of the front, factor of the first power, c_1 over it, errors of the first two, and the
/// sum of the squares that are left.
struct Fit {
  double place, factor, slope, place_error, factor_error, rest;
};

/// Fit a series of `terms` powers, a spread, and the place of a front that is bent, by least
/// squares (Gauss and Newton); not a number where that has no solution.
Fit fit(const Tables &tables, const double *shares, const Measured &measured, double bend,
        std::size_t terms, const Search &search);

} // namespace fretfe::moments
