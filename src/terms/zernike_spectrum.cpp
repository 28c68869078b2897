#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "aberfit/core/quadrature.h"
#include "aberfit/scene/zernike.h"
#include "aberfit/terms/surface_spectrum.h"
#include "bessel_orders.h"

namespace aberfit {
using namespace internal;

namespace {

// With kappa = 2 pi R f the transform of Z_n^m over the disc is, except for phases that depend only on m,
//   2 pi R^2 norm (-1)^((n - |m|)/2) J_{n+1}(kappa)/kappa times cos or sin of m phi,
// and the average of norm^2 cos^2 over directions is n + 1. So
//   S = 4 pi R^2 sum over signed m of |sum_n a_nm sqrt(n + 1) (-1)^((n - |m|)/2) J_{n+1}(kappa)/kappa|^2.
// Orders n and angular orders m separate: we use a coefficient matrix (n, m), and one table of nodes by n for
// all m.
constexpr int kNodes = 24;
// Squares of Bessel functions oscillate as exp(2 i kappa), 8 rad on half a panel: 24 nodes are exact to
// rounding.
constexpr double kSpectrumPanelWidth = 8;

class ZernikeSpectrum : public SurfaceSpectrum {
 public:
  ZernikeSpectrum(const TermSet& terms, const Eigen::ArrayXd& low, const Eigen::ArrayXd& high)
      : modes_(terms.zernike), bins_(low.size()) {
    for (const ZernikeMode& mode : modes_) {
      n_top_ = std::max(n_top_, mode.n);
      m_top_ = std::max(m_top_, std::abs(mode.m));
    }
    const double to_kappa = 2 * std::numbers::pi * terms.radius;
    std::vector<double> kappa, weight;
    first_.push_back(0);
    for (Eigen::Index b = 0; b < bins_; ++b) {
      const double from = to_kappa * low[b], to = to_kappa * high[b];
      const int panels = std::max(1, int(std::ceil((to - from) / kSpectrumPanelWidth)));
      for (int p = 0; p < panels; ++p) {
        const Quadrature rule =
            gauss_legendre(kNodes, from + (to - from) * p / panels, from + (to - from) * (p + 1) / panels);
        for (int i = 0; i < kNodes; ++i) {
          kappa.push_back(rule.nodes[i]);
          weight.push_back(4 * std::numbers::pi * terms.radius * terms.radius * rule.weights[i] *
                           rule.nodes[i] / (0.5 * (to - from) * (to + from)));
        }
      }
      first_.push_back(Eigen::Index(kappa.size()));
    }
    weight_ = Eigen::Map<const Eigen::VectorXd>(weight.data(), Eigen::Index(weight.size()));
    table_.resize(Eigen::Index(kappa.size()), n_top_ + 1);
    Eigen::VectorXd bessel(n_top_ + 2);
    for (std::size_t i = 0; i < kappa.size(); ++i) {
      bessel_j_orders(kappa[i], n_top_ + 1, bessel.data());
      for (int n = 0; n <= n_top_; ++n)
        table_(Eigen::Index(i), n) = std::sqrt(n + 1.0) * bessel[n + 1] / kappa[i];
    }
  }

  Eigen::Index bins() const override { return bins_; }

  void evaluate(const Eigen::VectorXd& coefficients, Eigen::VectorXd* values,
                Eigen::MatrixXd* jacobian) const override {
    assert(coefficients.size() == Eigen::Index(modes_.size()));
    Eigen::MatrixXd by_order = Eigen::MatrixXd::Zero(n_top_ + 1, 2 * m_top_ + 1);
    for (std::size_t j = 0; j < modes_.size(); ++j)
      by_order(modes_[j].n, modes_[j].m + m_top_) += sign(modes_[j]) * coefficients[Eigen::Index(j)];
    values->resize(bins_);
    if (jacobian) jacobian->resize(bins_, coefficients.size());
    for (Eigen::Index b = 0; b < bins_; ++b) {
      const auto table = table_.middleRows(first_[std::size_t(b)], nodes_of(b));
      const auto weight = weight_.segment(first_[std::size_t(b)], nodes_of(b));
      const Eigen::MatrixXd amplitude = table * by_order;  // nodes x m
      (*values)[b] = weight.dot(amplitude.rowwise().squaredNorm());
      if (!jacobian) continue;
      const Eigen::MatrixXd gradient = table.transpose() * (2 * weight.asDiagonal() * amplitude);
      for (std::size_t j = 0; j < modes_.size(); ++j)
        (*jacobian)(b, Eigen::Index(j)) = sign(modes_[j]) * gradient(modes_[j].n, modes_[j].m + m_top_);
    }
  }

 private:
  static double sign(ZernikeMode mode) { return (mode.n - std::abs(mode.m)) / 2 % 2 == 0 ? 1 : -1; }
  Eigen::Index nodes_of(Eigen::Index b) const { return first_[std::size_t(b) + 1] - first_[std::size_t(b)]; }

  std::vector<ZernikeMode> modes_;
  Eigen::Index bins_;
  int n_top_ = 0, m_top_ = 0;
  std::vector<Eigen::Index> first_;  // first node of each bin, and the end
  Eigen::VectorXd weight_;           // normalised so that a bin's sum is its average
  Eigen::MatrixXd table_;            // sqrt(n + 1) J_{n+1}(kappa)/kappa: nodes x n
};

}  // namespace

std::unique_ptr<SurfaceSpectrum> zernike_spectrum(const TermSet& terms, const Eigen::ArrayXd& low,
                                                  const Eigen::ArrayXd& high) {
  if (!terms.fourier.empty() || !terms.spherical.empty())
    throw std::invalid_argument("the closed form of the spectrum holds for Zernike terms only");
  if (!(terms.radius > 0)) throw std::invalid_argument("the radius of the Zernike disc must be positive");
  for (const ZernikeMode& mode : terms.zernike) require_zernike_mode(mode);
  if (low.size() != high.size() || !(low >= 0).all() || !(low < high).all() || !high.isFinite().all())
    throw std::invalid_argument("every bin needs 0 <= low < high < infinity");
  return std::make_unique<ZernikeSpectrum>(terms, low, high);
}

}  // namespace aberfit
