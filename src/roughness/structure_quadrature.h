#pragma once
#include <array>
#include <cmath>
#include <functional>
#include <optional>
#include <vector>

#include "aberfit/core/quadrature.h"
#include "hankel_panels.h"
#include "log_slope.h"
#include "power_waves.h"

namespace aberfit::internal {

/// int S q (1 - J0(2 pi f r)) d2f of any S for which it exists, panel by panel. q is 1, or a smooth function
/// of frequency such as d ln S/dp. Every octave of r has a plan. Panels below the first oscillation of J0
/// contribute by moments. Neighbours over which J0 hardly changes (a long table has hundreds) are merged to
/// one set of nodes. On wide panels Filon's rule integrates the Hankel amplitude.
class StructureQuadrature {
 public:
  /// stretches: intervals where S is a power of f; must be empty if a q is given. 0 < r_min <= r_max [m].
  StructureQuadrature(const RadialPsd& psd, std::vector<PowerStretch> stretches, double r_min, double r_max,
                      const LogSlope* slope = nullptr);
  /// r must be in [r_min, r_max] [m]. Makes the plan of its octave.
  double operator()(double r);

 private:
  using Powers = std::array<double, 5>;  // int S (pi f)^(2 m) d2f
  struct Plan {
    std::size_t first = 0;  // panels before this one contribute by moments
    std::vector<double> f, weight;
    std::vector<std::size_t> wide;  // panels for Filon's rule
    PowerWaves waves{0};            // runs of panels of one stretch, and distant nodes
    double wave_mass = 0;           // their int S d2f

    void add(double node, double node_weight);
  };
  Plan plan(double k) const;
  void append_merged(std::size_t i, std::size_t end, const LegendreRule& rule, Plan* plan) const;
  void append_panel(const PsdPanel& panel, const LegendreRule& rule, Plan* plan) const;
  double far(std::size_t i, double k) const;

  SharedPanels shared_;
  std::vector<PowerStretch> stretches_;
  std::vector<std::size_t> stretch_;  // stretch of each panel; the number of stretches if it is in none
  std::function<double(double)> psd_;
  double r_max_;
  std::vector<double> mass_;   // int S d2f of each panel
  Powers low_{};               // sum below the panels, without the zeroth power
  std::vector<Powers> below_;  // cumulative, up to and including each panel
  std::vector<std::optional<Plan>> plans_;
  double beyond_ = 0;
};

}  // namespace aberfit::internal
