// The quadrature of the pupil's overlap: what its budget does not suffice for is refused, not returned.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "../../src/theory/pupil_overlap.h"
#include "aberfit/core/errors.h"

namespace aberfit::internal {
namespace {

// cos(turns 2 pi s), a point of work for each `per_value`-th part of the budget.
MomentPanels panels(double turns, double per_value) {
  const auto moments = [=](double s, std::size_t* points) {
    *points += std::size_t(per_value * double(kMostMomentPoints));
    return Eigen::ArrayXd::Constant(1, std::cos(2 * std::numbers::pi * turns * s)).eval();
  };
  return moment_panels(moments, 1, {1}, 1, 1e-11, true);
}

double error_of(const MomentPanels& found, double turns) {
  double worst = 0;
  for (const MomentPanel& panel : found.panels)
    for (const double s : {0.9 * panel.a + 0.1 * panel.b, 0.5 * (panel.a + panel.b)})
      worst = std::max(
          worst, std::abs(panel.at(s, panel.legendre())[0] - std::cos(2 * std::numbers::pi * turns * s)));
  return worst;
}

TEST(MomentPanels, AreRefusedWhereTheirWorkLeavesMoreThanPromised) {
  // 64 panels of 24 nodes resolve 100 turns; a tenth of that work does not.
  const MomentPanels whole = panels(100, 1e-6);
  EXPECT_EQ(whole.unresolved, 0);
  EXPECT_LT(error_of(whole, 100), 1e-10);
  EXPECT_THROW(panels(100, 1.0 / 200), ComputationError);
}

// Coarse panels come first, so that what is left open at the end is small everywhere: 32 panels of 6 turns
// each are good to 1e-6 where 1e-11 was asked for.
TEST(MomentPanels, ReturnedWithinTheBudgetKeepThePromise) {
  for (const double panels_of_work : {20.0, 40.0, 63.0, 70.0, 90.0, 130.0}) {
    try {
      const MomentPanels found = panels(100, 1 / (24 * panels_of_work));
      EXPECT_LE(error_of(found, 100), kMostUnresolved) << panels_of_work;
    } catch (const ComputationError&) {
      EXPECT_LT(panels_of_work, 100);
    }
  }
}

}  // namespace
}  // namespace aberfit::internal
