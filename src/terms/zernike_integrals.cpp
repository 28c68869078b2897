#include "zernike_integrals.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/special_functions/gamma.hpp>
#include <cassert>
#include <cmath>
#include <complex>
#include <vector>

#include "aberfit/core/constants.h"
#include "aberfit/core/errors.h"
#include "aberfit/roughness/psd_integrals.h"
#include "bessel_orders.h"

// With kappa = 2 pi R and x = kappa f the covariance is 8 pi/kappa^2 sqrt(ab) s_a s_b int S J_a J_b df/f, a =
// n + 1, b = n' + 1, s_a = (-1)^floor(a/2). The integral has four ranges of f:
//   head   S is a sum of powers and J_a J_b its first two terms: closed form;
//   direct Gauss-Legendre panels with at most 2.5 oscillations of J;
//   tail   J_a = sqrt(2/(pi x)) Re(h_a e^(i(x - a pi/2 - pi/4))), so J_a J_b = (s_a s_b/(pi x)) [Re(h_a conj
//   h_b) + (-1)^a Im(h_a h_b e^(2ix))]:
//          smooth amplitudes on octaves, plain weights for the average and Filon weights for the oscillation;
//   beyond h = 1 and S a sum of powers: closed form, because the oscillation averages out.

namespace aberfit::internal {
namespace {

// The width is in x; J_a J_b oscillates 5 times on 24 nodes, error below 1e-15 (j_48(16)).
constexpr double kPanelWidth = 16;
constexpr double kHankelFrom = 30;  // in x
constexpr double kTailOrders =
    6;  // the tail starts at order^2/6, where the phase of h_a h_b changes by 3 rad over an octave
constexpr double kHeadArgument = 1e-4;

using PanelMatrix = Eigen::Matrix<double, kPanelNodes, Eigen::Dynamic>;

// The orders a = n + 1 of one parity among n_min..n_max.
struct Orders {
  int first = 0;  // smallest a
  int count = 0;
  int parity() const { return first % 2; }
  int order(int i) const { return first + 2 * i; }
};
Orders orders_from(int first, int last) { return {first, last < first ? 0 : (last - first) / 2 + 1}; }

// The boundaries of the four ranges of f.
struct Stretches {
  double low, turn, high;
};
Stretches stretches_of(const RadialPsd& psd, double kappa, int top) {
  const PowerLawLimits limits = power_law_limits(psd);
  Stretches s{limits.low, std::max(kHankelFrom, double(top) * top / kTailOrders) / kappa, limits.high};
  if (psd.f_min() == 0) s.low = std::min(s.low, kHeadArgument / kappa);
  if (std::isinf(psd.f_max())) s.high = std::max(s.high, 1e6 * double(top) * top / kappa);
  return s;
}

// Adds s_a s_b int S J_a J_b df/f to `sum`, for all pairs of one parity.
class FullSum {
 public:
  explicit FullSum(Orders orders) : orders_(orders), sum(Eigen::MatrixXd::Zero(orders.count, orders.count)) {}
  void add_direct(const PanelArray& weight, const PanelMatrix& j) {
    sum.noalias() += (j.array().colwise() * weight).matrix().transpose() * j;
  }
  void add_tail(const PanelArray& mean, const PanelArray& re, const PanelArray& im, const PanelMatrix& p,
                const PanelMatrix& q) {
    sum.noalias() += (p.array().colwise() * (mean + im)).matrix().transpose() * p;
    sum.noalias() += (q.array().colwise() * (mean - im)).matrix().transpose() * q;
    const Eigen::MatrixXd cross = (p.array().colwise() * re).matrix().transpose() * q;
    sum += cross + cross.transpose();
  }
  template <class Term>
  void add_closed(const Term& term) {
    for (int i = 0; i < orders_.count; ++i)
      for (int k = 0; k < orders_.count; ++k) sum(i, k) += term(orders_.order(i), orders_.order(k));
  }

 private:
  Orders orders_;

 public:
  Eigen::MatrixXd sum;
};

// The same for a = b only.
class DiagonalSum {
 public:
  explicit DiagonalSum(Orders orders) : orders_(orders), sum(Eigen::ArrayXd::Zero(orders.count)) {}
  void add_direct(const PanelArray& weight, const PanelMatrix& j) {
    sum += (j.array().square().colwise() * weight).colwise().sum().transpose();
  }
  void add_tail(const PanelArray& mean, const PanelArray& re, const PanelArray& im, const PanelMatrix& p,
                const PanelMatrix& q) {
    sum += (p.array().square().colwise() * (mean + im) + q.array().square().colwise() * (mean - im) +
            (2 * p.array() * q.array()).colwise() * re)
               .colwise()
               .sum()
               .transpose();
  }
  template <class Term>
  void add_closed(const Term& term) {
    for (int i = 0; i < orders_.count; ++i) sum[i] += term(orders_.order(i), orders_.order(i));
  }

 private:
  Orders orders_;

 public:
  Eigen::ArrayXd sum;
};

template <class Sum>
void add_head(const RadialPsd& psd, double kappa, double f, int first_order, Sum* sum) {
  for (const PowerTerm& term : psd.low_frequency_terms()) {
    if (!(2 * first_order - term.exponent > 0))
      throw ComputationError(
          fmt::format("the variance of the Zernike terms n = {} diverges, because the PSD goes as f^-{:g} "
                      "down to f = 0; give it an f_min or leave these terms out",
                      first_order - 1, term.exponent));
    sum->add_closed([&](int a, int b) {
      const double p = a + b - term.exponent, x = kappa * f;
      const double sign = (a / 2 + b / 2) % 2 == 0 ? 1 : -1;
      const double lead =
          std::exp((a + b) * std::log(0.5 * x) - boost::math::lgamma(a + 1.0) - boost::math::lgamma(b + 1.0));
      const double next = 0.25 * x * x * (1.0 / (a + 1) + 1.0 / (b + 1));
      return sign * term(f) * lead * (1 / p - next / (p + 2));
    });
  }
}

template <class Sum>
void add_beyond(const RadialPsd& psd, double kappa, double f, Sum* sum) {
  for (const PowerTerm& term : psd.high_frequency_terms()) {
    if (!(term.exponent > -1))
      throw ComputationError(fmt::format(
          "Zernike variances diverge, because the PSD goes as f^{:g} up to f = infinity; give it an f_max",
          -term.exponent));
    sum->add_closed([&](int, int) { return term(f) / (kPi * kappa * f * (term.exponent + 1)); });
  }
}

// Sums for the two parities; `sums[i]` belongs to orders[i].
template <class Sum>
void integrate(const RadialPsd& psd, double kappa, const std::vector<Orders>& orders,
               std::vector<Sum>* sums) {
  int top = 1;
  for (const Orders& set : orders) top = std::max(top, set.order(set.count - 1));
  const Stretches at = stretches_of(psd, kappa, top);

  if (psd.f_min() == 0)
    for (std::size_t i = 0; i < orders.size(); ++i)
      add_head(psd, kappa, at.low, orders[i].first, &(*sums)[i]);

  std::vector<double> values(std::size_t(top) + 1);
  std::vector<PanelMatrix> j, p, q;
  for (const Orders& set : orders) {
    j.emplace_back(kPanelNodes, set.count);
    p.emplace_back(kPanelNodes, set.count);
    q.emplace_back(kPanelNodes, set.count);
  }
  for (const PsdPanel& panel :
       resolved_panels(psd, at.low, std::min(at.turn, at.high), 1.5, kPanelWidth / kappa)) {
    for (int node = 0; node < kPanelNodes; ++node) {
      bessel_j_orders(kappa * panel.f[node], top, values.data());
      for (std::size_t i = 0; i < orders.size(); ++i)
        for (int k = 0; k < orders[i].count; ++k) {
          const int a = orders[i].order(k);
          j[i](node, k) = (a / 2) % 2 == 0 ? values[std::size_t(a)] : -values[std::size_t(a)];
        }
    }
    const PanelArray weight = panel.weight * panel.psd / panel.f;
    for (std::size_t i = 0; i < orders.size(); ++i) (*sums)[i].add_direct(weight, j[i]);
  }

  std::vector<std::complex<double>> h(std::size_t(top) + 1);
  for (const PsdPanel& panel : resolved_panels(psd, std::max(at.low, at.turn), at.high)) {
    for (int node = 0; node < kPanelNodes; ++node) {
      const double x = kappa * panel.f[node];
      const HankelAmplitudes start = hankel_amplitudes(x);
      h[0] = start.h0;
      h[1] = start.h1;
      for (int nu = 1; nu < top; ++nu)
        h[std::size_t(nu) + 1] =
            h[std::size_t(nu) - 1] +
            std::complex<double>(-h[std::size_t(nu)].imag(), h[std::size_t(nu)].real()) * (2 * nu / x);
      for (std::size_t i = 0; i < orders.size(); ++i)
        for (int k = 0; k < orders[i].count; ++k) {
          p[i](node, k) = h[std::size_t(orders[i].order(k))].real();
          q[i](node, k) = h[std::size_t(orders[i].order(k))].imag();
        }
    }
    const auto filon = oscillatory_weights(panel.a, panel.b, 2 * kappa);
    const PanelArray envelope = panel.psd / (kPi * kappa * panel.f.square());
    for (std::size_t i = 0; i < orders.size(); ++i) {
      const double sign = orders[i].parity() == 0 ? 1 : -1;
      (*sums)[i].add_tail(panel.weight * envelope, sign * filon.real() * envelope,
                          sign * filon.imag() * envelope, p[i], q[i]);
    }
  }

  if (std::isinf(psd.f_max()))
    for (Sum& sum : *sums) add_beyond(psd, kappa, at.high, &sum);
}

std::vector<Orders> both_parities(int n_min, int n_max) {
  assert(0 <= n_min && n_min <= n_max);
  std::vector<Orders> orders = {orders_from(n_min + 1, n_max + 1)};
  if (n_max > n_min) orders.push_back(orders_from(n_min + 2, n_max + 1));
  return orders;
}

template <class Sum>
std::vector<Sum> sums_for(const RadialPsd& psd, double kappa, const std::vector<Orders>& orders) {
  std::vector<Sum> sums;
  for (const Orders& set : orders) sums.emplace_back(set);
  integrate(psd, kappa, orders, &sums);
  return sums;
}

}  // namespace

Eigen::MatrixXd zernike_covariance_table(const RadialPsd& psd, double radius, int n_min, int n_max) {
  const double kappa = 2 * kPi * radius;
  const std::vector<Orders> orders = both_parities(n_min, n_max);
  const std::vector<FullSum> sums = sums_for<FullSum>(psd, kappa, orders);
  Eigen::MatrixXd table = Eigen::MatrixXd::Zero(n_max - n_min + 1, n_max - n_min + 1);
  for (std::size_t i = 0; i < orders.size(); ++i)
    for (int k = 0; k < orders[i].count; ++k)
      for (int l = 0; l < orders[i].count; ++l) {
        const int a = orders[i].order(k), b = orders[i].order(l);
        table(a - 1 - n_min, b - 1 - n_min) = 8 * kPi / (kappa * kappa) * std::sqrt(double(a) * b) * 0.5 *
                                              (sums[i].sum(k, l) + sums[i].sum(l, k));
      }
  return table;
}

Eigen::ArrayXd zernike_variances(const RadialPsd& psd, double radius, int n_min, int n_max) {
  const double kappa = 2 * kPi * radius;
  const std::vector<Orders> orders = both_parities(n_min, n_max);
  const std::vector<DiagonalSum> sums = sums_for<DiagonalSum>(psd, kappa, orders);
  Eigen::ArrayXd variances(n_max - n_min + 1);
  for (std::size_t i = 0; i < orders.size(); ++i)
    for (int k = 0; k < orders[i].count; ++k)
      variances[orders[i].order(k) - 1 - n_min] =
          8 * kPi / (kappa * kappa) * orders[i].order(k) * sums[i].sum[k];
  return variances;
}

}  // namespace aberfit::internal
