#include "aberfit/method/spectrum_target.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "aberfit/core/errors.h"
#include "aberfit/core/parallel.h"
#include "aberfit/core/units.h"
#include "aberfit/method/constants.h"

namespace aberfit {
namespace {

class SelectedBins : public SurfaceSpectrum {
 public:
  SelectedBins(std::unique_ptr<SurfaceSpectrum> all, std::vector<Eigen::Index> selected)
      : all_(std::move(all)), selected_(std::move(selected)) {}
  Eigen::Index bins() const override { return Eigen::Index(selected_.size()); }
  void evaluate(const Eigen::VectorXd& coefficients, Eigen::VectorXd* values,
                Eigen::MatrixXd* jacobian) const override {
    all_->evaluate(coefficients, values, jacobian);
    *values = (*values)(selected_).eval();
    if (jacobian) *jacobian = (*jacobian)(selected_, Eigen::all).eval();
  }

 private:
  std::unique_ptr<SurfaceSpectrum> all_;
  std::vector<Eigen::Index> selected_;
};

// Expectation of a quadratic form over c = F xi with white xi: its sum over the columns of F.
Eigen::VectorXd expectation(const SurfaceSpectrum& spectrum, const CoefficientPrior& prior, int threads) {
  Eigen::MatrixXd each(spectrum.bins(), prior.size());
  parallel_for(std::size_t(prior.size()), threads, [&](std::size_t j) {
    Eigen::VectorXd values;
    spectrum.evaluate(prior.colour(Eigen::VectorXd::Unit(prior.size(), Eigen::Index(j))), &values, nullptr);
    each.col(Eigen::Index(j)) = values;
  });
  return each.rowwise().sum();
}

// The band that the terms can carry: from one wave over the diameter to their highest frequency at the rim.
std::pair<double, double> default_band(const Groundwork& ground, const TermSet& terms) {
  int n_max = 0;
  for (const ZernikeMode& mode : terms.zernike) n_max = std::max(n_max, mode.n);
  double high = terms.fourier.empty() ? zernike_cutoff(n_max, ground.radius) : ground.term_psd->f_max();
  high = std::min(high, ground.term_psd->f_max());
  return {std::max(1 / ground.radius, ground.term_psd->f_min()), high};
}

}  // namespace

SpectrumTarget make_spectrum_target(const Task& task, const Groundwork& ground, const TermSet& terms,
                                    const CoefficientPrior& prior, int threads) {
  SpectrumTarget target;
  if (!task.target.psd) return target;
  if (!ground.psd)
    throw FieldError("target.psd", "PSD bins without roughness",
                     "a roughness block, which their values come from");
  const PsdTarget& asked = *task.target.psd;
  const auto [first, last] = default_band(ground, terms);
  const double f_min = asked.f_min.value_or(first), f_max = asked.f_max.value_or(last);
  const auto band = [](double low, double high) {
    return fmt::format("{} to {}", format_quantity(low, Dimension::kSpatialFrequency),
                       format_quantity(high, Dimension::kSpatialFrequency));
  };
  if (!(f_min < f_max))
    throw FieldError("target.psd", "a band from " + band(f_min, f_max),
                     "f_min below f_max, inside what the terms carry");
  if (f_max < ground.term_psd->f_min() || f_min > ground.term_psd->f_max() || f_min > last)
    throw FieldError("target.psd", "a band from " + band(f_min, f_max),
                     "a band inside that of the roughness and of the terms, " + band(first, last));
  if (asked.method == "closed-form") {
    if (!terms.fourier.empty() || !terms.spherical.empty())
      throw FieldError("target.psd.method", "\"closed-form\" with Fourier or spherical terms",
                       "\"estimator\", because the closed form is for Zernikes");
    const int bins = std::max(1, int(std::lround(std::log10(f_max / f_min) * asked.bins_per_decade)));
    const Eigen::ArrayXd edges = Eigen::ArrayXd::LinSpaced(bins + 1, std::log(f_min), std::log(f_max)).exp();
    target.low = edges.head(bins);
    target.high = edges.tail(bins);
    target.spectrum = zernike_spectrum(terms, target.low, target.high);
  } else {
    PsdEstimatorOptions options;
    options.bins_per_decade = asked.bins_per_decade;
    options.find_lines = false;
    Eigen::ArrayXd low, high;
    std::unique_ptr<SurfaceSpectrum> all =
        estimated_spectrum(terms, options, law::kLeastCells, threads, &low, &high);
    std::vector<Eigen::Index> inside;
    for (Eigen::Index b = 0; b < low.size(); ++b)
      if (low[b] >= f_min && high[b] <= f_max) inside.push_back(b);
    if (inside.empty())
      throw FieldError("target.psd", "a band without a bin of the estimator", "a wider band");
    target.low = low(inside);
    target.high = high(inside);
    target.spectrum = std::make_unique<SelectedBins>(std::move(all), inside);
  }
  target.value = expectation(*target.spectrum, prior, threads);
  target.tolerance = Eigen::VectorXd::Constant(target.value.size(), asked.tolerance);
  if (!(target.value.array() > 0).all())
    throw FieldError("target.psd", "bins that the terms cannot fill", "a band inside what the terms carry");
  return target;
}

}  // namespace aberfit
