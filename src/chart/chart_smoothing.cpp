#include <fmt/format.h>

#include "chart_families.h"

namespace aberfit::internal {
namespace {

constexpr double kWidths[] = {0.2, 0.1, 0.05, 0.02, 0.01, 0.005, 0.002};  // of focal_sigma

// Share of the rays that the gradient of an encircled-energy radius touches, mean over those statistics.
double touched_share(const ChartTrace& at, const std::vector<Statistic>& statistics) {
  double sum = 0;
  int counted = 0;
  for (std::size_t k = 0; k < statistics.size(); ++k) {
    if (!std::holds_alternative<EncircledEnergyRadius>(statistics[k])) continue;
    sum += double(at.gradients()[k].rays.rays.size()) / double(at.pupil().size());
    ++counted;
  }
  return counted > 0 ? sum / counted : 1.0;
}

}  // namespace

ChartFamily chart_smoothing(const ChartBench& bench, double seconds) {
  ChartFamily family = family_of("smoothing", "Width of the smooth twins' kernel",
                                 "largest relative difference of smooth and exact statistics",
                                 "values and full Jacobian by adjoints", bench.least_tolerance());
  // As many of the study's rays as leave time for all widths.
  constexpr std::int64_t kProbe = 8192;
  Eigen::VectorXd values;
  Eigen::MatrixXd jacobian;
  ChartTrace probe(bench, pupil_of_at_most(bench.task, kProbe));
  const double once =
      measure_time(0, [&] {
        probe.smooth(bench.coefficients, bench.statistics, bench.smoothing, &values, &jacobian);
      }).median;
  const double rays = double(kProbe) * seconds / (2 * std::size(kWidths) * std::max(once, 1e-6));
  ChartTrace at(bench, pupil_of_at_most(bench.task, std::int64_t(std::max(double(kProbe), rays))));
  const Eigen::VectorXd exact = at.exact();
  for (const double width : kWidths) {
    bench.say(fmt::format("chart: smoothing width {:g}", width));
    ChartRow row = row_of("smooth", "width", width, "focal sigma");
    at.set_sizes(&row);
    row.is_default = width == FitOptions().smoothing.back();
    bool exists = false;
    const ChartTime time = measure_time(seconds / std::size(kWidths), [&] {
      exists = at.smooth(bench.coefficients, bench.statistics, width * bench.ground.focal_sigma, &values,
                         &jacobian);
    });
    set_errors(exists ? statistic_errors(values, exact, bench.statistics) : StatisticErrors(),
               "exact statistics on the same rays", 0, &row);
    if (exists) {
      row.note = fmt::format("a radius's gradient touches {:.3g} % of the rays",
                             100 * touched_share(at, bench.statistics));
      set_time(time, &row);
    } else {
      row.note = "a statistic has no smooth value: the kernel is too wide or too narrow for the rays";
    }
    family.rows.push_back(std::move(row));
  }
  family.remark = "A fit through a kernel that holds few rays follows single rays.";
  return family;
}

}  // namespace aberfit::internal
