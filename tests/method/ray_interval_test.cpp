#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "aberfit/forward/statistics_with_error.h"
#include "aberfit/method/tost.h"
#include "aberfit/terms/modal_covariance.h"

namespace aberfit {
namespace {

constexpr double kDiameter = 0.4;
const Mirror kParabola{2.8, -1, {}};
const Aperture kCircle = CircleAperture{kDiameter};

struct Surface {
  TermSet terms;
  Eigen::VectorXd coefficients;
};

Surface draw(double rms, int n_max, std::uint64_t seed) {
  Surface surface;
  surface.terms.radius = kDiameter / 2;
  surface.terms.zernike = zernike_modes(2, n_max);
  const CoefficientPrior prior =
      make_prior(surface.terms, RadialPsd(UniformPsd{rms, 2.5, 13}), CovarianceKind::kFull);
  surface.coefficients = prior.colour(draw_white(prior.size(), seed));
  return surface;
}

struct Coverage {
  double share = 0;
  double error = 0;  // standard error from groups, because the statistics of one group are correlated
};

// Returns the fraction of 90 % intervals from fresh rays that contain the truth. The truth comes from a
// hundred times as many rays. A group is a seed and a surface; groups are independent.
Coverage coverage(int groups_per_surface, std::int64_t rays) {
  const std::vector<Statistic> statistics{EncircledEnergyRadius{0.3, 0},     EncircledEnergyRadius{0.5, 0},
                                          EncircledEnergyRadius{0.9, 0},     EncircledEnergyRadius{0.8, 1e-3},
                                          EncircledEnergyRadius{0.5, -2e-3}, RingFwhm{0.9, {}},
                                          RingThrough{1e-4, -1e-3},          SpotFwhm{2e-5}};
  double sum = 0, squares = 0;
  int groups = 0;
  for (const auto& [rms, n_max] :
       std::vector<std::pair<double, int>>{{200e-9, 16}, {100e-9, 10}, {60e-9, 22}}) {
    const Surface surface = draw(rms, n_max, 7);
    const auto seen = [&](std::int64_t count, std::uint64_t seed) {
      return statistics_with_error({kParabola, kCircle, 632.8e-9, Centre::kNominal},
                                   {FocusModel::kRays, count, seed, 0}, surface.terms, surface.coefficients,
                                   statistics, 2, nullptr);
    };
    const FreshStatistics truth = seen(128 * rays, 1000000);
    for (int g = 1; g <= groups_per_surface; ++g, ++groups) {
      const FreshStatistics fresh = seen(rays, std::uint64_t(g));
      double hits = 0;
      for (Eigen::Index k = 0; k < fresh.value.size(); ++k) {
        const EquivalenceMetric metric =
            tost("", false, truth.value[k], 0, fresh.value[k], fresh.standard_error[k], 0.01, 0.95,
                 {HUGE_VAL, fresh.degrees_of_freedom});
        if (metric.interval[0] <= 0 && metric.interval[1] >= 0) hits += 1;
      }
      const double share = hits / double(fresh.value.size());
      sum += share;
      squares += share * share;
    }
  }
  const double mean = sum / groups;
  return {mean, std::sqrt((squares / groups - mean * mean) / (groups - 1))};
}

// The normal quantile covers 85.6 % of t_7, so a "90 %" interval from 8 scrambles needs Student's t.
TEST(RayIntervals, HoldTheTruthAsOftenAsTheySay) {
  const Coverage found = coverage(60, 4096);
  RecordProperty("per_mille", int(1000 * found.share));
  RecordProperty("error_per_mille", int(1000 * found.error));
  EXPECT_LT(found.error, 0.015);
  EXPECT_NEAR(found.share, 0.9, 0.02 + 2 * found.error);
}

TEST(FullStatistics, RayIntervalsCover88To92Percent) {
  const Coverage found = coverage(700, 4096);
  RecordProperty("per_mille", int(1000 * found.share));
  RecordProperty("error_per_ten_thousand", int(10000 * found.error));
  EXPECT_LT(found.error, 0.005);
  EXPECT_GT(found.share - found.error, 0.88);
  EXPECT_LT(found.share + found.error, 0.92);
}

}  // namespace
}  // namespace aberfit
