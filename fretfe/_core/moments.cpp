// SPDX-License-Identifier: LGPL-3.0-or-later
#include "moments.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace fretfe::moments {
namespace {

using Row = std::array<double, most_unknowns>;

struct Model { // rows of the bumps, a column for each unknown but the place; and their derivatives
  std::array<Row, most_bumps> values{}, rates{};
};

/// Columns of terms and spread over the standard deviations, for a front at a place.
Model model(const Tables &t, const double *shares, const Measured &measured, double bend,
            std::size_t terms, double place) {
  const double along = (place - t.first) / t.step;
  const auto last = static_cast<double>(t.pieces - 1);
  const auto piece = static_cast<std::size_t>(std::clamp(std::floor(along), 0.0, last));
  const double s = place - t.first - static_cast<double>(piece) * t.step;
  const std::size_t size = t.bumps * t.columns, power = t.pieces * size;
  Model found;
  for (std::size_t bump = 0; bump < measured.count; ++bump) {
    Row flat{}, rate{};
    for (std::size_t e = 0; e < t.exponents; ++e) {
      const double *c = t.values + 4 * e * power + piece * size + bump * t.columns;
      // The spread, the last of all columns, follows the powers that are read.
      for (std::size_t k = 0; k < terms + 2; ++k) {
        const double *p = c + (k <= terms ? k : t.columns - 1);
        flat[k] += shares[e] * (((p[0] * s + p[power]) * s + p[2 * power]) * s + p[3 * power]);
        rate[k] += shares[e] * ((3 * p[0] * s + 2 * p[power]) * s + p[2 * power]);
      }
    }
    // Areas are those between curved lines: (1 - bend s) ds, s = place + distance.
    const double left = 1 - bend * place, sigma = measured.sigma[bump];
    for (std::size_t k = 0; k < terms; ++k) {
      found.values[bump][k] = (left * flat[k] - bend * flat[k + 1]) / sigma;
      found.rates[bump][k] = (left * rate[k] - bend * rate[k + 1]) / sigma;
    }
    found.values[bump][terms] = flat[terms + 1] / sigma;
    found.rates[bump][terms] = rate[terms + 1] / sigma;
  }
  return found;
}

struct Solved { // least squares, and the triangle R of the columns
  Row solution{};
  std::array<Row, most_unknowns> triangle{};
};

/// Least squares of (count, unknowns) columns by Householder's reflections; both are overwritten.
Solved least_squares(std::array<Row, most_bumps> &a, std::array<double, most_bumps> &b,
                     std::size_t count, std::size_t unknowns) {
  Solved found;
  for (std::size_t j = 0; j < unknowns; ++j) {
    double norm = 0;
    for (std::size_t i = j; i < count; ++i)
      norm += a[i][j] * a[i][j];
    norm = std::copysign(std::sqrt(norm), a[j][j]);
    // The reflection takes this column, v, to its first entry: 1 - v v^T/(norm v_j).
    a[j][j] += norm;
    const double scale = 1 / (norm * a[j][j]);
    const auto reflect = [&](auto &&entry) {
      double product = 0;
      for (std::size_t i = j; i < count; ++i)
        product += a[i][j] * entry(i);
      for (std::size_t i = j; i < count; ++i)
        entry(i) -= product * scale * a[i][j];
    };
    for (std::size_t k = j + 1; k < unknowns; ++k)
      reflect([&](std::size_t i) -> double & { return a[i][k]; });
    reflect([&](std::size_t i) -> double & { return b[i]; });
    for (std::size_t k = j + 1; k < unknowns; ++k)
      found.triangle[j][k] = a[j][k];
    found.triangle[j][j] = -norm;
  }
  for (std::size_t j = unknowns; j-- > 0;) {
    double left = b[j];
    for (std::size_t k = j + 1; k < unknowns; ++k)
      left -= found.triangle[j][k] * found.solution[k];
    found.solution[j] = left / found.triangle[j][j];
  }
  return found;
}

/// Standard error of an unknown for measurements of unit variance: norm of a row of R^-1.
double error_of(const Solved &solved, std::size_t unknowns, std::size_t number) {
  Row row{};
  double sum = 0;
  for (std::size_t k = number; k < unknowns; ++k) {
    double left = k == number ? 1.0 : 0.0;
    for (std::size_t i = number; i < k; ++i)
      left -= row[i] * solved.triangle[i][k];
    row[k] = left / solved.triangle[k][k];
    sum += row[k] * row[k];
  }
  return std::sqrt(sum);
}

} // namespace

Fit fit(const Tables &tables, const double *shares, const Measured &measured, double bend,
        std::size_t terms, const Search &search) {
  const std::size_t count = measured.count, place_number = terms + 1;
  std::array<double, most_bumps> target{};
  for (std::size_t i = 0; i < count; ++i)
    target[i] = measured.moments[i] / measured.sigma[i];
  double place = 0;
  Model now = model(tables, shares, measured, bend, terms, place);
  auto columns = now.values;
  auto side = target;
  Solved solved = least_squares(columns, side, count, place_number);
  for (int correction = 0; correction < search.corrections; ++correction) {
    columns = now.values;
    side = target;
    for (std::size_t i = 0; i < count; ++i) {
      columns[i][place_number] = 0;
      for (std::size_t k = 0; k < place_number; ++k)
        columns[i][place_number] += now.rates[i][k] * solved.solution[k];
    }
    solved = least_squares(columns, side, count, place_number + 1);
    if (!std::isfinite(solved.solution[place_number])) {
      const double none = std::numeric_limits<double>::quiet_NaN();
      return {none, none, none, none, none, none};
    }
    place = std::clamp(place + solved.solution[place_number], -search.farthest, search.farthest);
    now = model(tables, shares, measured, bend, terms, place);
  }
  double rest = 0;
  for (std::size_t i = 0; i < count; ++i) {
    double left = target[i];
    for (std::size_t k = 0; k < place_number; ++k)
      left -= now.values[i][k] * solved.solution[k];
    rest += left * left;
  }
  return {place,
          solved.solution[0],
          solved.solution[1] / solved.solution[0],
          error_of(solved, place_number + 1, place_number),
          error_of(solved, place_number + 1, 0),
          rest};
}

} // namespace fretfe::moments
