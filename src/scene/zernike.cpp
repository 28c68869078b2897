#include "aberfit/scene/zernike.h"

#include <fmt/core.h>

#include <stdexcept>

namespace aberfit {
namespace {

void require_index(int j, int first, const char* scheme) {
  if (j < first)
    throw std::invalid_argument(
        fmt::format("{} index {} is out of range; it starts at {}", scheme, j, first));
}

/// Largest r with r (r + 1) / 2 <= j: the row of entry j of a triangle. Integers correct the rounded root.
int triangle_row(long long j) {
  auto row = static_cast<long long>((std::sqrt(8.0 * double(j) + 1.0) - 1.0) / 2.0);
  while (row * (row + 1) / 2 > j) --row;
  while ((row + 1) * (row + 2) / 2 <= j) ++row;
  return int(row);
}

}  // namespace

bool is_zernike_mode(ZernikeMode mode) {
  return mode.n >= 0 && mode.m >= -mode.n && mode.m <= mode.n && (mode.n - std::abs(mode.m)) % 2 == 0;
}

double zernike_norm(ZernikeMode mode) { return std::sqrt((mode.m == 0 ? 1.0 : 2.0) * (mode.n + 1.0)); }

void require_zernike_mode(ZernikeMode mode) {
  if (!is_zernike_mode(mode))
    throw std::invalid_argument(fmt::format(
        "Zernike mode n = {}, m = {} does not exist: n >= 0, |m| <= n and n - |m| even are needed", mode.n,
        mode.m));
}

ZernikeValue zernike(ZernikeMode mode, double x, double y) { return zernike_at<double>(mode, x, y); }

int noll_index(ZernikeMode mode) {
  require_zernike_mode(mode);
  const int before = mode.n * (mode.n + 1) / 2, m = std::abs(mode.m);
  if (m == 0) return before + 1;
  // The modes +-m have the places m and m + 1 in their row. Even indices are cosines.
  const bool first_is_even = (before + m) % 2 == 0;
  return before + m + (first_is_even == (mode.m > 0) ? 0 : 1);
}

ZernikeMode zernike_from_noll(int j) {
  require_index(j, 1, "Noll");
  const int n = triangle_row(j - 1), place = j - n * (n + 1) / 2;  // place in the row, from 1
  const int m = (place % 2 == n % 2) ? place : place - 1;
  return {n, j % 2 == 0 ? m : -m};
}

int osa_index(ZernikeMode mode) {
  require_zernike_mode(mode);
  return (mode.n * (mode.n + 2) + mode.m) / 2;
}

ZernikeMode zernike_from_osa(int j) {
  require_index(j, 0, "OSA");
  const int n = triangle_row(j);
  return {n, 2 * j - n * (n + 2)};
}

int fringe_index(ZernikeMode mode) {
  require_zernike_mode(mode);
  const int m = std::abs(mode.m), group = (mode.n + m) / 2;
  return (group + 1) * (group + 1) - 2 * m + (mode.m < 0 ? 1 : 0);
}

ZernikeMode zernike_from_fringe(int j) {
  require_index(j, 1, "Fringe");
  int group = int(std::sqrt(double(j)));
  while ((long long)group * group >= j) --group;  // group^2 < j <= (group + 1)^2
  while ((long long)(group + 1) * (group + 1) < j) ++group;
  const int from_end =
      (group + 1) * (group + 1) - j;  // 0 for m = 0, then 1 (sine), 2 (cosine) for m = 1, ...
  const int m = (from_end + 1) / 2;
  return {2 * group - m, from_end % 2 == 1 ? -m : m};
}

}  // namespace aberfit
