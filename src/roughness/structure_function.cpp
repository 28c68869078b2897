#include <array>
#include <boost/math/special_functions/bessel.hpp>
#include <boost/math/special_functions/digamma.hpp>
#include <boost/math/special_functions/gamma.hpp>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>

#include "aberfit/core/constants.h"
#include "aberfit/core/quadrature.h"
#include "aberfit/roughness/bessel.h"
#include "aberfit/roughness/psd.h"
#include "aberfit/roughness/psd_integrals.h"
#include "hankel_panels.h"
#include "power_waves.h"
#include "square.h"

namespace aberfit {
using namespace internal;

namespace {

// 1 - 2 J1(z)/z to rounding relative to itself.
double one_minus_jinc(double z) {
  if (z > 1) return 1 - 2 * boost::math::cyl_bessel_j(1, z) / z;
  const double q = 0.25 * z * z;
  double term = 0.5 * q, sum = term;
  for (int m = 2; std::abs(term) > 1e-17 * sum; ++m) {
    term *= -q / (m * (m + 1));
    sum += term;
  }
  return sum;
}

constexpr double kEvenExponent = 1e-9;  // distance of nu from an integer below which its formula is used

// 1 - (2/Gamma(nu)) (a/2)^nu K_nu(a). Up to a = 2 from the series of K_nu without its first term:
// DLMF 10.27.4 with 10.25.2, and 10.31.1 for an integer nu.
double one_minus_matern(double nu, double a) {
  if (a > 700) return 1;
  if (a > 2)
    return 1 - 2 / boost::math::tgamma(nu) * std::pow(0.5 * a, nu) * boost::math::cyl_bessel_k(nu, a);
  const double q = 0.25 * a * a;
  const double nearest = std::round(nu);
  double sum = 0;
  if (std::abs(nu - nearest) < kEvenExponent && nearest >= 1) {
    const int n = int(nearest);
    double term = 1;  // (n-k-1)!/((n-1)! k!) (-q)^k
    for (int k = 1; k < n; ++k) {
      term *= -q / (k * double(n - k));
      sum -= term;
    }
    double power = (n % 2 == 0 ? 2 : -2) * std::exp(n * std::log(q) - std::lgamma(n) - std::lgamma(n + 1));
    double tail = 0;
    for (int k = 0; k < 30; ++k) {
      tail += power *
              (0.5 * (boost::math::digamma(k + 1.0) + boost::math::digamma(n + k + 1.0)) - 0.5 * std::log(q));
      power *= q / ((k + 1.0) * (n + k + 1.0));
    }
    return sum - tail;
  }
  double first = std::pow(q, nu) * boost::math::tgamma(1 - nu) / boost::math::tgamma(1 + nu), second = 1;
  sum = first;
  for (int k = 1; k < 200; ++k) {
    first *= q / (k * (k + nu));
    second *= q / (k * (k - nu));
    sum += first - second;
    if (std::abs(first) + std::abs(second) < 1e-18 * std::abs(sum) && k > nu) break;
  }
  return sum;
}

std::optional<double> structure_closed_form(const GaussianPsd& m, double factor, double f_min, double f_max,
                                            double r) {
  if (f_min > 0 || std::isfinite(f_max)) return std::nullopt;
  return -factor / (kPi * square(m.correlation_length)) * std::expm1(-square(r / m.correlation_length));
}

std::optional<double> structure_closed_form(const KCorrelationPsd& m, double factor, double f_min,
                                            double f_max, double r) {
  const double nu = 0.5 * m.exponent - 1;
  if (f_min > 0 || std::isfinite(f_max) || nu > 60) return std::nullopt;  // beyond, K_nu overflows
  return kPi * factor / (square(m.correlation) * nu) * one_minus_matern(nu, 2 * kPi * r / m.correlation);
}

std::optional<double> structure_closed_form(const UniformPsd&, double factor, double f_min, double f_max,
                                            double r) {
  if (f_max - f_min < 0.1 * f_max) return std::nullopt;  // the difference of the discs would lose digits
  const auto disc = [r](double f) { return kPi * f * f * one_minus_jinc(2 * kPi * r * f); };
  return factor * (disc(f_max) - disc(f_min));
}

template <class Model>
std::optional<double> structure_closed_form(const Model&, double, double, double, double) {
  return std::nullopt;
}

std::vector<PowerStretch> power_stretches(const PowerLawPsd& m, double f_min, double f_max) {
  return {PowerStretch(f_min, f_max, m.exponent)};
}
std::vector<PowerStretch> power_stretches(const UniformPsd&, double f_min, double f_max) {
  return {PowerStretch(f_min, f_max, 0)};
}
std::vector<PowerStretch> power_stretches(const TablePsd& m, double f_min, double f_max) {
  std::vector<PowerStretch> stretches;
  for (std::size_t i = 0; i + 1 < m.frequency.size(); ++i) {
    const double a = m.frequency[i], b = m.frequency[i + 1];
    if (a < f_max && b > f_min)
      stretches.emplace_back(std::max(a, f_min), std::min(b, f_max),
                             -std::log(m.psd[i + 1] / m.psd[i]) / std::log(b / a));
  }
  return stretches;
}
template <class Model>
std::vector<PowerStretch> power_stretches(const Model&, double, double) {
  return {};
}

const LegendreRule& unit_rule() {
  static const LegendreRule rule = legendre_rule(kPanelNodes);
  return rule;
}
const LegendreRule& long_rule() {
  static const LegendreRule rule = legendre_rule(2 * kPanelNodes);
  return rule;
}

// A rule for S times J0 over `turn` radians on one panel; none where Filon's rule costs less. n nodes are
// exact to degree 2 n - 1, and the Legendre coefficients of S fall to 1e-14 by degree 23: the largest product
// of one of them with the J_(2n-l)(turn/2) that it meets stays below 4e-17.
const LegendreRule* rule_for(double turn) {
  if (turn <= 24) return &unit_rule();
  if (turn <= 90) return &long_rule();
  static const LegendreRule wide = legendre_rule(96), widest = legendre_rule(192);
  if (turn <= 240) return &wide;
  return turn <= 560 ? &widest : nullptr;
}

// int S (1 - J0(2 pi f r)) d2f of any S where it exists, panel by panel. Every octave of r has
// a plan: panels below the first turn of J0 come in by their moments, neighbours across which J0 hardly turns
// (a long table has hundreds) are merged to one set of nodes, on wide panels the Hankel amplitude is
// integrated by Filon's rule.
class ByQuadrature {
 public:
  ByQuadrature(const RadialPsd& psd, std::vector<PowerStretch> stretches, double r_min, double r_max)
      : shared_(shared_panels(psd, r_min, r_max)), stretches_(std::move(stretches)), r_max_(r_max) {
    for (const PsdPanel& panel : shared_.panels) {
      std::size_t s = 0;
      if (!stretch_.empty() && stretch_.back() < stretches_.size()) s = stretch_.back();
      while (s < stretches_.size() && panel.b > stretches_[s].f_max()) ++s;
      stretch_.push_back(s < stretches_.size() && panel.a >= stretches_[s].f_min() ? s : stretches_.size());
    }
    psd_ = [psd](double f) { return psd(f); };
    // Below the panels 1 - J0 is its series: next to nothing where the height variance is finite, a good part
    // where S falls almost as fast as f^-4.
    if (psd.f_min() == 0)
      for (std::size_t m = 1; m < low_.size(); ++m)
        low_[m] = std::pow(kPi, 2.0 * double(m)) * radial_moment(psd, 2.0 * double(m), 0, shared_.low);
    Powers sum = low_;
    for (const PsdPanel& panel : shared_.panels) {
      PanelArray term = 2 * kPi * panel.weight * panel.psd * panel.f;
      mass_.push_back(term.sum());
      for (double& power : sum) {
        power += term.sum();
        term *= (kPi * panel.f).square();
      }
      below_.push_back(sum);
    }
    if (std::isinf(psd.f_max()) && !shared_.panels.empty())
      beyond_ = radial_moment(psd, 0, shared_.panels.back().b);  // where J0 has averaged out
  }

  double operator()(double r) {
    const std::size_t octave = std::size_t(std::max(0.0, std::floor(std::log2(r_max_ / r))));
    if (octave >= plans_.size()) plans_.resize(octave + 1);
    if (!plans_[octave]) plans_[octave] = plan(2 * kPi * std::ldexp(r_max_, -int(octave)));
    const Plan& now = *plans_[octave];
    const double k = 2 * kPi * r;
    double sum = beyond_;
    // Four terms of 1 - J0: the next is 1e-12 of the first.
    const Powers& p = now.first > 0 ? below_[now.first - 1] : low_;
    const double q = r * r;
    sum += q * (p[1] - q / 4 * (p[2] - q / 9 * (p[3] - q / 16 * p[4])));
    sum += one_minus_j0_sum(k, now.f.data(), now.weight.data(), int(now.f.size()));
    for (const std::size_t i : now.wide) sum += far(i, k);
    return sum + (now.wave_mass - now.waves(r));
  }

 private:
  using Powers = std::array<double, 5>;  // int S (pi f)^(2 m) d2f
  struct Plan {
    std::size_t first = 0;  // panels before this one come by moments
    std::vector<double> f, weight;
    std::vector<std::size_t> wide;  // panels for Filon's rule
    PowerWaves waves{0};            // of runs of panels of one stretch, and of nodes far out
    double wave_mass = 0;           // int S d2f of them

    void add(double node, double node_weight) {
      if (!waves.carries(node)) {
        f.push_back(node);
        weight.push_back(node_weight);
        return;
      }
      wave_mass += node_weight;
      waves.add_node(node, node_weight);
    }
  };

  // For wave numbers in [k/2, k].
  Plan plan(double k) const {
    const std::vector<PsdPanel>& panels = shared_.panels;
    Plan result;
    result.waves = PowerWaves(0.5 * k);
    while (result.first < panels.size() && k * panels[result.first].b < 0.2) ++result.first;
    std::size_t i = result.first;
    while (i < panels.size()) {
      const double a = panels[i].a;
      const double turn = k * a >= kTurnOfLong ? kTurnOfLong : kTurnOfMerged;
      std::size_t end = i + 1;
      while (end < panels.size() && k * (panels[end].b - a) <= turn && panels[end].b <= 2 * a &&
             panels[end].a == panels[end - 1].b)
        ++end;
      const std::size_t s = stretch_[i];
      const std::size_t waves = stretch_[end - 1] - s;  // that would stand for the merged panels
      if (s < stretches_.size() && 0.5 * k * a >= stretches_[s].smallest() && waves <= kWavesOfMerged) {
        for (; i < panels.size() && stretch_[i] == s; ++i) {
          result.wave_mass += mass_[i];
          end = i + 1;
        }
        const double b = panels[end - 1].b;
        result.waves.add(stretches_[s], a, psd_(a), b, psd_(b));
        continue;
      }
      if (end - i > 1) {
        append_merged(i, end, k * (panels[end - 1].b - a) > kTurnOfMerged ? long_rule() : unit_rule(),
                      &result);
      } else if (const LegendreRule* rule = rule_for(k * (panels[i].b - a))) {
        append_panel(panels[i], *rule, &result);
      } else {
        result.wide.push_back(i);
      }
      i = end;
    }
    result.waves.arrange(result.wave_mass);
    return result;
  }

  // Weights of as many nodes as the rule has that integrate S times any polynomial of their degree over
  // panels [i, end) together.
  void append_merged(std::size_t i, std::size_t end, const LegendreRule& rule, Plan* plan) const {
    const double a = shared_.panels[i].a, b = shared_.panels[end - 1].b;
    const int n = int(rule.nodes.size());
    Eigen::ArrayXd moment = Eigen::ArrayXd::Zero(n);  // of Legendre polynomials
    for (std::size_t p = i; p < end; ++p) {
      const PsdPanel& panel = shared_.panels[p];
      const PanelArray t = (2 * panel.f - (a + b)) / (b - a);
      const PanelArray weight = 2 * kPi * panel.weight * panel.psd * panel.f;
      PanelArray before = PanelArray::Zero(), here = PanelArray::Ones();
      for (int l = 0; l < n; ++l) {
        moment[l] += (l + 0.5) * (weight * here).sum();
        const double back = l / (l + 1.0);
        const PanelArray next = (1 + back) * t * here - back * before;
        before = here;
        here = next;
      }
    }
    const Eigen::ArrayXd weights = rule.weights * (rule.polynomials.matrix() * moment.matrix()).array();
    for (int j = 0; j < n; ++j) plan->add(0.5 * (a + b) + 0.5 * (b - a) * rule.nodes[j], weights[j]);
  }

  void append_panel(const PsdPanel& panel, const LegendreRule& rule, Plan* plan) const {
    const bool own = rule.nodes.size() == kPanelNodes;
    for (Eigen::Index j = 0; j < rule.nodes.size(); ++j) {
      const double f =
          own ? panel.f[j] : 0.5 * (panel.a + panel.b) + 0.5 * (panel.b - panel.a) * rule.nodes[j];
      const double psd = own ? panel.psd[j] : psd_(f);
      plan->add(f, kPi * (panel.b - panel.a) * rule.weights[j] * psd * f);
    }
  }

  double far(std::size_t i, double k) const {
    const PsdPanel& panel = shared_.panels[i];
    const auto weights = oscillatory_weights(panel.a, panel.b, k);
    const PanelArray x = k * panel.f, shape = panel.psd * panel.f;
    PanelArray p0, q0, p1, q1;
    hankel_amplitudes(x.data(), kPanelNodes, p0.data(), q0.data(), p1.data(), q1.data());
    const double real = (shape * (weights.real() * p0 - weights.imag() * q0)).sum(),
                 imaginary = (shape * (weights.real() * q0 + weights.imag() * p0)).sum();
    return mass_[i] - 2 * kPi * (real + imaginary) / std::numbers::sqrt2;
  }

  // 24 nodes carry J0 over 10 rad: J_24(5) = 4e-15; 48 over 36 rad: J_48(18) = 1e-16.
  static constexpr double kTurnOfMerged = 10, kTurnOfLong = 36;
  static constexpr std::size_t kWavesOfMerged = 40;  // that cost as much as 24 values of J0
  SharedPanels shared_;
  std::vector<PowerStretch> stretches_;
  std::vector<std::size_t> stretch_;  // of each panel; their number where it is in none
  std::function<double(double)> psd_;
  double r_max_;
  std::vector<double> mass_;   // int S d2f of each panel
  Powers low_{};               // of all below the panels, without the zeroth
  std::vector<Powers> below_;  // of that and all panels up to and with this one
  std::vector<std::optional<Plan>> plans_;
  double beyond_ = 0;
};

}  // namespace

Eigen::ArrayXd structure_function(const RadialPsd& psd, const Eigen::ArrayXd& r) {
  if (!has_finite_structure_function(psd)) return Eigen::ArrayXd::Constant(r.size(), kInfinity);
  Eigen::ArrayXd result = Eigen::ArrayXd::Zero(r.size());
  const double r_max = r.size() > 0 ? r.maxCoeff() : 0;
  if (r_max <= 0) return result;
  const double r_min = (r > 0).select(r, r_max).minCoeff();
  for (const RadialPsd::Part& part : psd.parts_) {
    std::optional<ByQuadrature> quadrature;  // made when the first r without a closed form comes
    for (Eigen::Index i = 0; i < r.size(); ++i) {
      if (!(r[i] > 0)) continue;
      const std::optional<double> closed = std::visit(
          [&](const auto& m) { return structure_closed_form(m, part.factor, part.f_min, part.f_max, r[i]); },
          part.model);
      if (!closed && !quadrature) {
        RadialPsd alone;
        alone.parts_.push_back(part);
        alone.find_band();
        quadrature.emplace(
            alone,
            std::visit([&](const auto& m) { return power_stretches(m, part.f_min, part.f_max); }, part.model),
            r_min, r_max);
      }
      result[i] += closed ? *closed : (*quadrature)(r[i]);
    }
  }
  return result;
}

}  // namespace aberfit
