#pragma once
#include <cstddef>
#include <vector>

#include "aberfit/core/instruction_set.h"
#include "aberfit/terms/term_set.h"
#include "point_block.h"
#include "scratch_pool.h"

namespace aberfit::internal {

/// Position of each Zernike mode of a set in the packed rows of the kernels, and the recurrence of those
/// rows.
///
/// Row (m, k), m = |m| and k = (n - m)/2 = 0 .. top(m), represents the monic polynomial
///     p_0 = 1,  p_{k+1} = (tau + beta_k) p_k - gamma_k p_{k-1},  tau = 4 rho^2 - 2.
/// P_k^(0,m)(tau/2) = lambda_k p_k is the Jacobi polynomial of the radial function R_n^m = rho^m P_k^(0,m)(2
/// rho^2 - 1) (DLMF 18.9.2 with alpha = 0, beta = m, divided by its leading coefficient). gamma_k tends to 1,
/// so nothing grows:
///     beta_k  = -2 m^2 / ((2k+m)(2k+m+2)),
///     gamma_k = 16 k^2 (k+m)^2 / ((2k+m)^2 (2k+m-1)(2k+m+1)),
///     lambda_{k+1} / lambda_k = (2k+m+1)(2k+m+2) / (4 (k+1)(k+m+1)).
/// Modes below top(m) that are missing from the set are rows with a zero coefficient.
struct ZernikeRows {
  std::vector<int> first;          ///< row of (m, 0), for m = 0 .. m_max + 1
  std::vector<double> recurrence;  ///< beta, gamma of each row
  std::vector<std::size_t> slot;   ///< per mode of the set: 2 row, plus 1 for a sine
  std::vector<double> scale;       ///< per mode of the set: norm lambda_k

  int m_max() const { return int(first.size()) - 2; }
  std::size_t rows() const { return recurrence.size() / 2; }
  int longest() const;  ///< largest number of rows of one m
};

/// Throws std::invalid_argument for an invalid (n, m).
ZernikeRows zernike_rows(const std::vector<ZernikeMode>& modes);

/// Adds the sum of all rows to the block's field; `packed` holds a cosine and a sine coefficient per row.
/// Coordinates are in units of the radius, and slopes are derivatives with respect to them. Clenshaw's
/// recurrence (Clenshaw 1955) gives value and tau-derivative, downwards in k, with cosine and sine sums
/// together.
void zernike_forward(InstructionSet set, const ZernikeRows& rows, const double* packed, PointBlock* block);

/// Enlarges `lanes` to one vector of partial sums per cosine and sine row of the longest m; needs a row.
double* lane_sums(const ZernikeRows& rows, std::vector<CacheLine>* lanes);

/// Adds to `packed`, for each row, the weighted sums over the block of its cosine and its sine term: the
/// transpose of zernike_forward, with the recurrence upwards. `lanes`: scratch.
void zernike_adjoint(InstructionSet set, const ZernikeRows& rows, const PointBlock& block,
                     std::vector<CacheLine>* lanes, double* packed);

}  // namespace aberfit::internal
