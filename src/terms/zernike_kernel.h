#pragma once
#include <cstddef>
#include <vector>

#include "aberfit/core/instruction_set.h"
#include "aberfit/terms/term_set.h"
#include "point_block.h"
#include "scratch_pool.h"

namespace aberfit::internal {

/// Where each Zernike mode of a set lives in the packed rows that the kernels walk through, and the
/// recurrence of those rows.
///
/// Row (m, k), m = |m| and k = (n - m)/2 = 0 .. top(m), stands for the monic polynomials
///     p_0 = 1,  p_{k+1} = (tau + beta_k) p_k - gamma_k p_{k-1},  tau = 4 rho^2 - 2,
/// with P_k^(0,m)(tau/2) = lambda_k p_k the Jacobi polynomial of the radial function R_n^m = rho^m
/// P_k^(0,m)(2 rho^2 - 1) (DLMF 18.9.2 with alpha = 0, beta = m, divided by its leading coefficient; gamma_k
/// -> 1, so nothing grows):
///     beta_k  = -2 m^2 / ((2k+m)(2k+m+2)),
///     gamma_k = 16 k^2 (k+m)^2 / ((2k+m)^2 (2k+m-1)(2k+m+1)),
///     lambda_{k+1} / lambda_k = (2k+m+1)(2k+m+2) / (4 (k+1)(k+m+1)).
/// Modes missing from the set below top(m) are rows with a zero coefficient.
struct ZernikeRows {
  std::vector<int> first;          ///< row of (m, 0), for m = 0 .. m_max + 1
  std::vector<double> recurrence;  ///< beta, gamma of each row
  std::vector<std::size_t> slot;   ///< per mode of the set: 2 row, plus 1 for a sine
  std::vector<double> scale;       ///< per mode of the set: norm lambda_k

  int m_max() const { return int(first.size()) - 2; }
  std::size_t rows() const { return recurrence.size() / 2; }
  int longest() const;  ///< rows of the m that has most
};

/// Throws std::invalid_argument for an (n, m) that is no mode.
ZernikeRows zernike_rows(const std::vector<ZernikeMode>& modes);

/// Adds to the block's field the sum of all rows, `packed` holding a cosine and a sine coefficient per row.
/// Coordinates in units of the radius; slopes are with respect to those. Clenshaw's recurrence (Clenshaw
/// 1955) for value and tau-derivative, downwards in k, cosine and sine sums side by side.
void zernike_forward(InstructionSet set, const ZernikeRows& rows, const double* packed, PointBlock* block);

/// `lanes`, grown to one vector of partial sums per cosine and sine row of the longest m. There must be a
/// row.
double* lane_sums(const ZernikeRows& rows, std::vector<CacheLine>* lanes);

/// Adds to `packed`, per row, the weighted sums over the block of its cosine and its sine term: the transpose
/// of zernike_forward, with the recurrence running upwards. `lanes`: scratch.
void zernike_adjoint(InstructionSet set, const ZernikeRows& rows, const PointBlock& block,
                     std::vector<CacheLine>* lanes, double* packed);

}  // namespace aberfit::internal
