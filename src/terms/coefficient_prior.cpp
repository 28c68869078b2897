#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>

#include "aberfit/core/linear_algebra.h"
#include "aberfit/core/random.h"
#include "aberfit/terms/modal_covariance.h"
#include "fourier_shares.h"
#include "zernike_integrals.h"

namespace aberfit {
using namespace internal;

namespace {

// Eigenvalues of a correlation matrix below this many eps are rounding errors of the quadrature. The factor
// contains the square roots of the others.
constexpr double kRankEps = 64;

// F with F F^T = C to rounding: D V sqrt(L) V^T, where D are the standard deviations and V L V^T the
// correlations. This scaling keeps full relative accuracy for coefficients many orders of magnitude apart.
// The symmetric root, unlike V sqrt(L) or a pivoted Cholesky factor, is a continuous function of C and tends
// to D for independent coefficients. So a seeded realisation does not jump with small changes of the PSD.
Eigen::MatrixXd covariance_factor(const Eigen::MatrixXd& covariance) {
  const Eigen::VectorXd deviation = covariance.diagonal().cwiseMax(0).cwiseSqrt();
  const Eigen::VectorXd inverse = deviation.unaryExpr([](double d) { return d > 0 ? 1 / d : 0.0; });
  const Eigen::MatrixXd correlation = inverse.asDiagonal() * covariance * inverse.asDiagonal();
  const SymmetricEigen eigen = symmetric_eigen(correlation);
  const double noise =
      kRankEps * double(covariance.rows()) * 2.2e-16 * std::max(eigen.values.maxCoeff(), 0.0);
  const Eigen::VectorXd root =
      eigen.values.unaryExpr([noise](double l) { return l > noise ? std::sqrt(l) : 0.0; });
  return deviation.asDiagonal() * eigen.vectors * root.asDiagonal() * eigen.vectors.transpose();
}

// Maps each signed m to its coefficients, by ascending n.
std::map<int, std::vector<Eigen::Index>> indices_by_m(const TermSet& terms) {
  std::map<int, std::vector<Eigen::Index>> by_m;
  for (std::size_t i = 0; i < terms.zernike.size(); ++i) by_m[terms.zernike[i].m].push_back(Eigen::Index(i));
  for (auto& [m, indices] : by_m)
    std::sort(indices.begin(), indices.end(), [&](Eigen::Index a, Eigen::Index b) {
      return terms.zernike[std::size_t(a)].n < terms.zernike[std::size_t(b)].n;
    });
  return by_m;
}

void append_zernike_blocks(const TermSet& terms, const RadialPsd& psd, CovarianceKind kind,
                           std::vector<CoefficientPrior::Block>* blocks) {
  const auto [lowest, highest] = std::minmax_element(terms.zernike.begin(), terms.zernike.end(),
                                                     [](const auto& a, const auto& b) { return a.n < b.n; });
  const int n_min = lowest->n;
  if (kind == CovarianceKind::kDiagonal) {
    const Eigen::ArrayXd variance = zernike_variances(psd, terms.radius, n_min, highest->n);
    for (std::size_t i = 0; i < terms.zernike.size(); ++i)
      blocks->push_back(
          {{Eigen::Index(i)},
           Eigen::MatrixXd::Constant(1, 1, std::sqrt(std::max(0.0, variance[terms.zernike[i].n - n_min])))});
    return;
  }
  const Eigen::MatrixXd table = zernike_covariance_table(psd, terms.radius, n_min, highest->n);
  std::map<std::vector<int>, Eigen::MatrixXd> known;  // +m and -m have the same orders, so the same factor
  for (const auto& [m, indices] : indices_by_m(terms)) {
    std::vector<int> places;  // rows of the orders in the table
    for (const Eigen::Index i : indices) places.push_back(terms.zernike[std::size_t(i)].n - n_min);
    Eigen::MatrixXd& factor = known[places];
    if (factor.size() == 0) factor = covariance_factor(table(places, places));
    blocks->push_back({indices, factor});
  }
}

}  // namespace

CoefficientPrior::CoefficientPrior(Eigen::Index size, std::vector<Block> blocks)
    : size_(size), blocks_(std::move(blocks)) {
#ifndef NDEBUG
  std::vector<int> covered(std::size_t(size), 0);
  for (const Block& block : blocks_) {
    assert(block.factor.rows() == Eigen::Index(block.index.size()) &&
           block.factor.cols() == block.factor.rows());
    for (const Eigen::Index i : block.index) ++covered[std::size_t(i)];
  }
  assert(std::all_of(covered.begin(), covered.end(), [](int times) { return times == 1; }));
#endif
}

namespace {

// y = factor(block) x, block by block; blocks of one coefficient (thousands) need no temporaries.
template <class Factor>
Eigen::VectorXd apply_blocks(const CoefficientPrior& prior, const Eigen::VectorXd& x, const Factor& factor) {
  assert(x.size() == prior.size());
  Eigen::VectorXd y(prior.size());
  for (const CoefficientPrior::Block& block : prior.blocks()) {
    if (block.index.size() == 1) {
      y[block.index[0]] = block.factor(0, 0) * x[block.index[0]];
      continue;
    }
    const Eigen::VectorXd in = x(block.index), out = factor(block) * in;
    y(block.index) = out;
  }
  return y;
}

}  // namespace

Eigen::VectorXd CoefficientPrior::colour(const Eigen::VectorXd& white) const {
  return apply_blocks(*this, white,
                      [](const Block& block) -> const Eigen::MatrixXd& { return block.factor; });
}

Eigen::VectorXd CoefficientPrior::colour_transpose(const Eigen::VectorXd& gradient) const {
  return apply_blocks(*this, gradient, [](const Block& block) { return block.factor.transpose(); });
}

CoefficientPrior make_prior(const TermSet& terms, const RadialPsd& psd, CovarianceKind kind) {
  std::vector<CoefficientPrior::Block> blocks;
  RadialPsd zernike_psd = psd, fourier_psd = psd;
  if (!terms.zernike.empty() && !terms.fourier.empty()) {
    int n_max = 0;
    for (const ZernikeMode& mode : terms.zernike) n_max = std::max(n_max, mode.n);
    const double split = zernike_cutoff(n_max, terms.radius);
    zernike_psd = psd.band(0, split);
    fourier_psd = psd.band(split, std::numeric_limits<double>::infinity());
  }
  if (!terms.zernike.empty()) append_zernike_blocks(terms, zernike_psd, kind, &blocks);
  if (!terms.fourier.empty()) {
    const std::vector<double> variance =
        terms.fourier_pitch > 0 ? lattice_variances(fourier_psd, terms.fourier, terms.fourier_pitch)
                                : fourier_variances(fourier_psd, terms.fourier);
    for (std::size_t k = 0; k < terms.fourier.size(); ++k)
      for (int part = 0; part < 2; ++part)
        blocks.push_back({{terms.fourier_begin() + 2 * Eigen::Index(k) + part},
                          Eigen::MatrixXd::Constant(1, 1, std::sqrt(variance[k]))});
  }
  return CoefficientPrior(terms.spherical_begin(), std::move(blocks));
}

CoefficientPrior::Block spherical_prior_block(const TermSet& terms, double rms) {
  const Eigen::Index size = Eigen::Index(terms.spherical.size());
  Eigen::MatrixXd gram(size, size);
  CoefficientPrior::Block block;
  for (Eigen::Index i = 0; i < size; ++i) {
    block.index.push_back(terms.spherical_begin() + i);
    for (Eigen::Index k = 0; k < size; ++k)
      gram(i, k) = 1 / (0.5 * (terms.spherical[std::size_t(i)] + terms.spherical[std::size_t(k)]) + 1);
  }
  // Orthonormal combinations psi = L^-1 phi, gram = L L^T (Gram-Schmidt in order): d . psi = (L^-T d) . phi.
  const Eigen::MatrixXd unit = Eigen::MatrixXd::Identity(size, size);
  block.factor = rms * Cholesky(gram).solve_lower(unit).transpose();
  return block;
}

std::vector<CoefficientPrior::Block> segment_prior_blocks(const TermSet& terms) {
  std::vector<CoefficientPrior::Block> blocks;
  if (!terms.segments) return blocks;
  Eigen::Index at = terms.segments_begin();
  const auto add = [&](double deviation) {
    blocks.push_back({{at++}, Eigen::MatrixXd::Constant(1, 1, deviation)});
  };
  for (const Segments::Segment& segment : terms.segments->all()) {
    if (terms.segments->piston() > 0) add(terms.segments->piston());
    for (int axis = 0; terms.segments->tip_tilt() > 0 && axis < 2; ++axis)
      add(terms.segments->tip_tilt() * segment.radius);
  }
  return blocks;
}

Eigen::VectorXd draw_white(Eigen::Index size, std::uint64_t seed) {
  const RandomStream stream(seed, "coefficient-draw");
  Eigen::VectorXd white(size);
  for (Eigen::Index i = 0; i < size; i += 2) {
    const auto [first, second] = stream.normal_pair(std::uint64_t(i / 2));
    white[i] = first;
    if (i + 1 < size) white[i + 1] = second;
  }
  return white;
}

}  // namespace aberfit
