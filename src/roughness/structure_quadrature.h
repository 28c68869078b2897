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

/// int S q (1 - J0(2 pi f r)) d2f of any S where it exists, panel by panel; q = 1, or a smooth function of
/// frequency such as d ln S/dp. Every octave of r has a plan: panels below the first turn of J0 come in by
/// their moments, neighbours across which J0 hardly turns (a long table has hundreds) are merged to one set
/// of nodes, on wide panels the Hankel amplitude is integrated by Filon's rule.
class StructureQuadrature {
 public:
  /// stretches: where S is a power of f; none beside a q. 0 < r_min <= r_max [m].
  StructureQuadrature(const RadialPsd& psd, std::vector<PowerStretch> stretches, double r_min, double r_max,
                      const LogSlope* slope = nullptr);
  /// r in [r_min, r_max] [m]. Makes the plan of its octave.
  double operator()(double r);

 private:
  using Powers = std::array<double, 5>;  // int S (pi f)^(2 m) d2f
  struct Plan {
    std::size_t first = 0;  // panels before this one come by moments
    std::vector<double> f, weight;
    std::vector<std::size_t> wide;  // panels for Filon's rule
    PowerWaves waves{0};            // of runs of panels of one stretch, and of nodes far out
    double wave_mass = 0;           // int S d2f of them

    void add(double node, double node_weight);
  };
  Plan plan(double k) const;
  void append_merged(std::size_t i, std::size_t end, const LegendreRule& rule, Plan* plan) const;
  void append_panel(const PsdPanel& panel, const LegendreRule& rule, Plan* plan) const;
  double far(std::size_t i, double k) const;

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

}  // namespace aberfit::internal
