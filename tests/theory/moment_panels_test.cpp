// Functions of the shear as polynomials on panels.
#include "../../src/theory/moment_panels.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "aberfit/core/errors.h"

namespace aberfit::internal {
namespace {

MomentPanels panels_of(double turns, double end) {
  return moment_panels(
      [=](double s) {
        return Eigen::ArrayXd::Constant(1, std::cos(2 * std::numbers::pi * turns * s)).eval();
      },
      {0.3, 1}, end, 1e-11);
}

TEST(MomentPanels, ResolveWhatTurnsManyTimes) {
  for (const double turns : {1.0, 100.0})
    for (const double end : {0.2, 1.0}) {
      const MomentPanels found = panels_of(turns, end);
      EXPECT_EQ(found.front().a, 0);
      EXPECT_EQ(found.back().b, end);
      for (std::size_t k = 0; k + 1 < found.size(); ++k) EXPECT_EQ(found[k].b, found[k + 1].a);
      for (const MomentPanel& panel : found)
        for (const double part : {0.1, 0.5, 0.87}) {
          const double s = panel.a + part * (panel.b - panel.a);
          EXPECT_NEAR(panel.at(s, panel.legendre())[0], std::cos(2 * std::numbers::pi * turns * s), 1e-10);
        }
    }
}

TEST(MomentPanels, OfAPartAreThoseOfTheWhole) {
  for (const MomentPanel& panel : panels_of(10, 1)) {
    const double from = 0.7 * panel.a + 0.3 * panel.b, to = 0.2 * panel.a + 0.8 * panel.b;
    const MomentPanel::Values part = panel.restricted(from, to);
    const PanelArray s = 0.5 * (from + to) + 0.5 * (to - from) * panel_rule().t;
    for (int k = 0; k < kPanelNodes; ++k) EXPECT_NEAR(part(k, 0), panel.at(s[k], panel.legendre())[0], 1e-12);
  }
}

TEST(MomentPanels, AreRefusedWhereTheyAreNotFiniteOrTooMany) {
  const auto constant = [](double value) {
    return [value](double) { return Eigen::ArrayXd::Constant(2, value).eval(); };
  };
  EXPECT_NO_THROW(moment_panels(constant(1), {1}, 1, 1e-11));
  EXPECT_THROW(moment_panels(constant(std::nan("")), {1}, 1, 1e-11), ComputationError);
  EXPECT_THROW(panels_of(1e5, 1), ComputationError);
}

}  // namespace
}  // namespace aberfit::internal
