#pragma once
#include <vector>

#include "chart_bench.h"

// The families of a chart, one function each; `seconds` is about how long it may take. Flags of the rows and
// the name of their family are left to make_chart.
namespace aberfit::internal {

/// Theories of the mean spot in focus, in light, against the aperture-exact one; its own error is what it
/// leaves out.
ChartFamily chart_theories(const ChartBench& bench, double seconds);
/// Rays by number and waves by grid, of one surface: encircled energies in light against a finer grid.
ChartFamily chart_models(const ChartBench& bench, double seconds);
/// Fits of growing orders by rays, by waves that begin on a coarse grid, and by waves on the safe grid alone:
/// what light says of the surfaces against their targets. Of terms and scatter no fit goes by rays.
ChartFamily chart_fits(const ChartBench& bench, double seconds);
/// Whole fits by where the roughness is split between terms and scatter: what light says of the mean, and how
/// far mirrors that share the terms differ.
ChartFamily chart_bands(const ChartBench& bench, double seconds);

/// Pupil layouts x ray counts: statistics against those of a four times finer pupil.
ChartFamily chart_pupils(const ChartBench& bench, double seconds);

/// Analytic normals and central differences by step: statistics, and slopes, against the analytic ones on the
/// same rays.
std::vector<ChartFamily> chart_normals(const ChartBench& bench, double seconds);
/// The law that central differences follow on this mirror and roughness; nothing without a finite slope
/// spectrum.
std::optional<StepLaw> step_law(const ChartBench& bench);

/// Ways to compute L and L^T: Zernike part and Fourier part, forward and adjoint, against the fused one.
std::vector<ChartFamily> chart_operators(const ChartBench& bench, double seconds);

/// Ways to the Jacobian of the statistics: adjoint, forward mode, differences of the smooth and of the exact
/// statistics.
ChartFamily chart_derivatives(const ChartBench& bench, double seconds);

/// Zernike orders: what draws miss when their higher orders are left out.
ChartFamily chart_orders(const ChartBench& bench, double seconds);
/// Number of plane waves that stand for the whole band: means over draws against those of very many.
ChartFamily chart_modes(const ChartBench& bench, double seconds);

/// Width of the smooth twins' kernel: smooth statistics against the exact ones on the same rays.
ChartFamily chart_smoothing(const ChartBench& bench, double seconds);

}  // namespace aberfit::internal
