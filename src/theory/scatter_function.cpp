#include "aberfit/theory/scatter_function.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "aberfit/core/constants.h"
#include "aberfit/core/errors.h"
#include "aberfit/roughness/psd_integrals.h"
#include "aberfit/theory/scattering_band.h"
#include "higher_orders.h"

namespace aberfit {
using namespace internal;

namespace {

constexpr double kBelowTheBand = 1e-2;   // lowest frequency at which the higher orders are shown, in f_min
constexpr double kBelowTheLags = 1e-3;   // the same in 1/(2 pi x), x the lag of deciding_lag
constexpr double kHighestLowest = 1e-3;  // upper bound of the lowest sine
constexpr double kJump = 1e-3;           // relative step of S that counts as a jump
constexpr double kBesideJump = 1e-6;
constexpr double kInterpolation = 1e-3;  // between rows, above kWorthRefining times the maximum
constexpr double kWorthRefining = 1e-4;
constexpr double kLightOfInterval = 3e-6;  // allowed error of the energy between two rows, over the TIS
constexpr int kMostHalvings = 8;
constexpr std::size_t kMostBreakpoints = 3000;  // number of breakpoints that still get a row each

// Lag [m] at which E(x) reaches half of min(g^2, 1), or the longest one; it decides the scatter angle.
double deciding_lag(const RadialPsd& psd, double wavelength, double g) {
  constexpr int kCount = 180;
  Eigen::ArrayXd x(kCount);
  for (int i = 0; i < kCount; ++i) x[i] = wavelength * std::pow(10, -2 + 12.0 * i / (kCount - 1));
  const Eigen::ArrayXd e = std::pow(4 * kPi / wavelength, 2) * structure_function(psd, x);
  const double wanted = 0.5 * std::min(g * g, 1.0);
  for (int i = 0; i < kCount; ++i)
    if (e[i] >= wanted) return x[i];
  return x[kCount - 1];
}

bool is_jump(const RadialPsd& psd, double f) {
  const double below = psd(f * (1 - 1e-9)), above = psd(f * (1 + 1e-9));
  return std::abs(above - below) > kJump * std::max(above, below);
}

struct Row {
  double sine = 0, bsdf = 0, within = 0;
};

Row row_at(const ScatterFunction& scatter, double sine) {
  const double theta = std::asin(sine);
  return {sine, scatter.bsdf(theta), scatter.within(theta)};
}

// 2 pi int BSDF s ds between two rows, for a BSDF that is a power of the sine.
double light_of_chord(const Row& one, const Row& two) {
  const double first = one.bsdf * one.sine * one.sine, second = two.bsdf * two.sine * two.sine;
  if (!(first > 0 && second > 0)) return 0;
  const double log_ratio = std::log(second / first), width = std::log(two.sine / one.sine);
  return kTwoPi * first * width * (log_ratio == 0 ? 1 : std::expm1(log_ratio) / log_ratio);
}

// Appends rows after `one` up to and including `two`, halved until log-log interpolation is close enough.
void append_rows(const ScatterFunction& scatter, const Row& one, const Row& two, double least, int halvings,
                 std::vector<Row>* rows) {
  if (halvings < kMostHalvings && two.sine > one.sine * (1 + 4 * kBesideJump)) {
    const Row middle = row_at(scatter, std::sqrt(one.sine * two.sine));
    const bool high = std::max(one.bsdf, two.bsdf) > least;
    const double off = std::abs(std::sqrt(one.bsdf * two.bsdf) - middle.bsdf);
    const double light_off = std::abs(light_of_chord(one, two) - (two.within - one.within));
    if ((high && !(off <= kInterpolation * middle.bsdf)) || light_off > kLightOfInterval * scatter.tis()) {
      append_rows(scatter, one, middle, least, halvings + 1, rows);
      append_rows(scatter, middle, two, least, halvings + 1, rows);
      return;
    }
  }
  rows->push_back(two);
}

std::vector<Row> rows_of(const ScatterFunction& scatter, int rows_per_decade) {
  const double lowest = scatter.lowest_sine();
  const int count = std::max(1, int(std::ceil(-std::log10(lowest) * rows_per_decade)));
  std::vector<double> sines;
  for (int i = 0; i <= count; ++i) sines.push_back(std::pow(lowest, 1 - double(i) / count));
  const std::vector<double>& bends = scatter.psd().breakpoints();
  for (const double f : bends) {
    const bool jump = is_jump(scatter.psd(), f);
    if (!jump && bends.size() > kMostBreakpoints) continue;
    for (const double side : {-1.0, 1.0}) {
      const double sine = scatter.wavelength() * f * (1 + (jump ? side * kBesideJump : 0));
      if (sine < 1 && sine > lowest) sines.push_back(sine);
    }
  }
  std::sort(sines.begin(), sines.end());
  sines.back() = 1;
  std::vector<Row> coarse, rows;
  double largest = 0;
  for (const double sine : sines) {
    if (!coarse.empty() && sine <= coarse.back().sine * (1 + 0.5 * kBesideJump)) continue;
    coarse.push_back(row_at(scatter, sine));
    largest = std::max(largest, coarse.back().bsdf);
  }
  const Row middle = row_at(scatter, 0);
  if (std::isfinite(middle.bsdf)) rows.push_back(middle);
  rows.push_back(coarse.front());
  for (std::size_t i = 0; i + 1 < coarse.size(); ++i)
    append_rows(scatter, coarse[i], coarse[i + 1], kWorthRefining * largest, 0, &rows);
  return rows;
}

}  // namespace

ScatterFunction::ScatterFunction(const RadialPsd& rest, double wavelength)
    : psd_(rest), wavelength_(wavelength) {
  assert(wavelength > 0);
  if (!std::isfinite(structure_function(rest, Eigen::ArrayXd::Constant(1, wavelength))[0]))
    throw ComputationError(
        "the structure function of this PSD is infinite, so there is no scatter function; give the PSD a "
        "lowest frequency");
  const ScatteringBand band = scattering_band(rest, wavelength);
  psd_ = band.psd;
  rms_height_ = band.rms_height;
  cut_share_ = band.cut_share;
  rms_slope_ = psd_moments(psd_).rms_slope_per_axis();
  g_ = 4 * kPi * rms_height_ / wavelength;
  core_ = std::exp(-g_ * g_);
  tis_ = -std::expm1(-g_ * g_);
  lowest_sine_ = kHighestLowest;
  if (!(tis_ > 0)) return;
  const double lowest =
      psd_.f_min() > 0 ? psd_.f_min() : kBelowTheLags / (kTwoPi * deciding_lag(psd_, wavelength, g_));
  lowest_sine_ = std::min(kHighestLowest, wavelength * lowest * (psd_.f_min() > 0 ? kBelowTheBand : 1));
  higher_ = std::make_shared<const HigherOrders>(psd_, wavelength, g_, std::min(lowest, 0.5 / wavelength));
  if (core_ > 0) {
    knots_ = {0};
    knots_.insert(knots_.end(), psd_.breakpoints().begin(), psd_.breakpoints().end());
    variance_below_ = {0};
    for (std::size_t i = 1; i < knots_.size(); ++i)
      variance_below_.push_back(variance_below_.back() + radial_moment(psd_, 0, knots_[i - 1], knots_[i]));
  }
  const double leaves = (core_ > 0 ? core_ * g_ * g_ : 0) + higher_->within(1 / wavelength);
  renorm_ = tis_ / leaves;
}

double ScatterFunction::bracket(double f) const {
  const double k = 4 * kPi / wavelength_;
  return (core_ > 0 ? core_ * k * k * psd_(f) : 0) + higher_->density(f);
}

double ScatterFunction::bsdf(double theta) const {
  if (!higher_) return 0;
  return renorm_ / (wavelength_ * wavelength_) * bracket(std::abs(std::sin(theta)) / wavelength_);
}

double ScatterFunction::within(double theta) const {
  if (!higher_) return 0;
  const double f = std::abs(std::sin(theta)) / wavelength_;
  double first = 0;
  if (core_ > 0) {
    const std::size_t knot =
        std::size_t(std::upper_bound(knots_.begin(), knots_.end(), f) - knots_.begin()) - 1;
    first = core_ * std::pow(4 * kPi / wavelength_, 2) *
            (variance_below_[knot] + radial_moment(psd_, 0, knots_[knot], f));
  }
  return std::min(tis_, renorm_ * (first + higher_->within(f)));
}

double ScatterFunction::unresolved() const { return higher_ ? higher_->unresolved() : 0; }

ScatterTable scatter_table(const ScatterFunction& scatter, int rows_per_decade) {
  assert(rows_per_decade >= 1);
  const std::vector<Row> all = rows_of(scatter, rows_per_decade);
  const Eigen::Index rows = Eigen::Index(all.size());
  ScatterTable table;
  table.wavelength = scatter.wavelength();
  table.tis = scatter.tis();
  table.rms_height = scatter.rms_height();
  table.rms_slope = scatter.rms_slope();
  table.g = scatter.g();
  table.f_min = scatter.psd().f_min();
  table.f_max = std::min(scatter.psd().f_max(), 1 / scatter.wavelength());
  table.cut_share = scatter.cut_share();
  table.renormalisation = scatter.renormalisation();
  for (Eigen::ArrayXd* column : {&table.theta, &table.asf_per_sr, &table.bsdf_per_sr, &table.tis_within})
    column->resize(rows);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const double theta = std::asin(all[std::size_t(i)].sine);
    table.theta[i] = theta;
    table.bsdf_per_sr[i] = all[std::size_t(i)].bsdf;
    table.asf_per_sr[i] = i + 1 == rows ? 0 : std::cos(theta) * table.bsdf_per_sr[i];
    const double within = i + 1 == rows ? scatter.tis() : all[std::size_t(i)].within;
    table.tis_within[i] = i > 0 ? std::max(within, table.tis_within[i - 1]) : within;
  }
  return table;
}

}  // namespace aberfit
