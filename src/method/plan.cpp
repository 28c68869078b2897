#include "aberfit/method/plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "aberfit/core/constants.h"
#include "aberfit/core/errors.h"
#include "aberfit/method/constants.h"
#include "aberfit/method/groundwork.h"
#include "aberfit/roughness/psd_integrals.h"
#include "aberfit/scene/segments.h"

namespace aberfit {
namespace {

// Fraction of the height variance over the aperture that terms from n_min on can carry. Piston has no effect.
double movable_share(const Groundwork& ground, int n_min) {
  return 1.0 - captured_fraction(*ground.term_psd, ground.radius, 0, n_min >= 2 ? 1 : 0);
}

double spherical_rms(const Task& task, const Groundwork& ground) {
  if (task.fit.spherical_rms) return *task.fit.spherical_rms;
  return ground.use.model == FocusModel::kWaves && ground.term_psd
             ? psd_moments(*ground.term_psd).rms_height()
             : law::kUnspecifiedRms;
}

CoefficientPrior make_term_prior(const Task& task, const Groundwork& ground, const TermSet& terms,
                                 CovarianceKind covariance) {
  std::vector<CoefficientPrior::Block> blocks;
  if (ground.prior_psd) {
    TermSet rough = terms;
    rough.spherical.clear();
    rough.segments.reset();
    if (rough.size() > 0) blocks = make_prior(rough, *ground.prior_psd, covariance).blocks();
  } else if (!terms.zernike.empty()) {
    CoefficientPrior::Block block;
    for (Eigen::Index j = 0; j < Eigen::Index(terms.zernike.size()); ++j) block.index.push_back(j);
    block.factor =
        spherical_rms(task, ground) * Eigen::MatrixXd::Identity(block.index.size(), block.index.size());
    blocks.push_back(std::move(block));
  }
  if (!terms.spherical.empty()) blocks.push_back(spherical_prior_block(terms, spherical_rms(task, ground)));
  for (CoefficientPrior::Block& block : segment_prior_blocks(terms)) blocks.push_back(std::move(block));
  return CoefficientPrior(terms.size(), std::move(blocks));
}

}  // namespace

int order_to_carry(double radius, double frequency) {
  return std::max(2, int(std::ceil(law::kOrderBeyondCut * kTwoPi * radius * frequency)));
}

double band_end(const RadialPsd& band) {
  if (std::isfinite(band.f_max())) return band.f_max();
  const double variance = (1 - law::kSlopeBeyondTerms) * radial_moment(band, 2);
  double low = std::max(band.f_min(), 1e-9), high = 2 * low;
  while (radial_moment(band, 2, 0, high) < variance) low = high, high *= 2;
  while (high > 1.001 * low) {
    const double middle = std::sqrt(low * high);
    (radial_moment(band, 2, 0, middle) < variance ? low : high) = middle;
  }
  return high;
}

TermSet make_terms(const Task& task, const Groundwork& ground, const TermsSpec& asked, double* captured) {
  TermSet terms;
  terms.radius = ground.radius;
  *captured = 0;
  terms.segments = erring_segments(task.aperture);
  if (ground.split && !ground.split->has_low()) return terms;
  double covered_to = 0;  // frequency up to which the Zernikes represent the PSD
  if (const std::optional<ZernikeSpec> zernikes = asked.zernikes()) {
    const ZernikeSpec& spec = *zernikes;
    int n_max = 0;
    if (spec.n_max) {
      n_max = *spec.n_max;
    } else if (ground.term_psd) {
      n_max = std::min(order_to_carry(ground.radius, band_end(*ground.term_psd)), law::kLargestOrder);
    } else {
      throw FieldError("terms.zernike.n_max", "nothing",
                       "a radial order, which has no default without roughness");
    }
    terms.zernike = zernike_modes(spec.n_min, n_max);
    covered_to = zernike_cutoff(n_max, ground.radius);
    if (ground.term_psd)
      *captured = captured_fraction(*ground.term_psd, ground.radius, spec.n_min, n_max) /
                  (spec.n_min >= 1 ? movable_share(ground, spec.n_min) : 1.0);
  }
  if (asked.fourier) {
    if (!ground.term_psd)
      throw FieldError("terms.fourier", "Fourier terms without roughness",
                       "a roughness block, whose band places them");
    const double low = std::max(covered_to, ground.term_psd->f_min());
    if (!(low < ground.term_psd->f_max()))
      throw FieldError("terms.fourier",
                       fmt::format("no band above the end of the Zernikes at {:.4g} /m", covered_to),
                       "a smaller n_max, or no Fourier terms");
    const RadialPsd band = ground.term_psd->band(low, ground.term_psd->f_max());
    if (asked.fourier->sampling == FourierSampling::kGrid) {
      terms.fourier_pitch = 1 / (2 * ground.radius);
      try {
        terms.fourier = fourier_lattice(band, terms.fourier_pitch);
      } catch (const ComputationError& e) {
        throw FieldError("terms.fourier.sampling", e.what(), "\"log\", or a terms.band that ends below");
      }
    } else {
      terms.fourier = fourier_modes(band, asked.fourier->count.value_or(law::kUsualWaves), task.fit.seed);
    }
    *captured = 1;
  }
  terms.spherical = asked.spherical;
  return terms;
}

TermPlan plan_terms(const Task& task, const Groundwork& ground, const TermsSpec& asked) {
  TermPlan plan;
  plan.asked = asked;
  plan.terms = make_terms(task, ground, asked, &plan.captured);
  plan.prior = make_term_prior(task, ground, plan.terms, asked.covariance);
  return plan;
}

FitPlan make_plan(const Task& task, std::shared_ptr<const TermPlan> terms) {
  FitPlan plan;
  plan.terms = std::move(terms);
  plan.pupil = task.trace.pupil;
  plan.automatic_rays = !task.trace.pupil.rays;
  plan.most_iterations = task.fit.max_iterations;
  return plan;
}

}  // namespace aberfit
