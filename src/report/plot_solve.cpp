#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "aberfit/report/solve_report.h"
#include "picture.h"

namespace aberfit {
using namespace internal;

namespace {

// Numbers on an axis of logarithms in the unit that suits their largest.
AxisUnit axis_unit(const SolveUnknown& unknown, double largest) {
  if (unknown.dimension == Dimension::kLength) return length_unit(largest);
  if (unknown.dimension == Dimension::kSpatialFrequency)
    return largest < 1000 ? AxisUnit{1, "1/m"} : AxisUnit{1e-3, "1/mm"};
  return {1, unknown.dimension == Dimension::kPsd2d ? "m^4" : "1"};
}

}  // namespace

// The second unknown across, the first up; below or above the curve the budgets hold.
std::vector<std::string> write_solve_plots(const Specification& spec, const std::string& directory,
                                           Warnings* warnings) {
  if (spec.contour.points.empty()) return {};
  const auto count = Eigen::Index(spec.contour.points.size());
  Eigen::ArrayXd x(count), y(count);
  for (Eigen::Index k = 0; k < count; ++k) {
    x[k] = spec.contour.points[std::size_t(k)].at[1];
    y[k] = spec.contour.points[std::size_t(k)].at[0];
  }
  const AxisUnit across = axis_unit(spec.unknowns[1], x.maxCoeff()),
                 up = axis_unit(spec.unknowns[0], y.maxCoeff());
  Picture picture{"contour", script_head("contour", 1000, 750), {}};
  const std::string first = spec.unknowns[0].pointer, second = spec.unknowns[1].pointer;
  picture.add_columns("contour.dat",
                      {"Where the strictest budget is met exactly: " + second + ", " + first + ", SI units"},
                      {x, y});
  std::string budgets;
  for (const Budget& budget : spec.budgets)
    budgets += (budgets.empty() ? "" : ", ") + budget.key + " " + budget.bound;
  struct Axis {
    std::string range, tics;
  };
  const auto axis = [](const Eigen::ArrayXd& of, const AxisUnit& unit) {
    const double low = of.minCoeff() * unit.per_si / 1.3, high = of.maxCoeff() * unit.per_si * 1.3;
    return Axis{fmt::format("[{:.9g}:{:.9g}]", low, high), log_tics(low, high)};
  };
  const Axis x_axis = axis(x, across), y_axis = axis(y, up);
  const bool below = spec.solutions.front().holds_below;
  const auto& start = spec.unknowns;
  picture.script += fmt::format(
      "set title {0}\nset logscale xy\nset xrange {1}\nset yrange {2}\nset xlabel {3}\nset ylabel {4}\n"
      "set format xy '%g'\nset xtics {12}\nset ytics {13}\n"
      "plot 'contour.dat' using ($1*{5:.9g}):($2*{6:.9g}) with lines linetype 2 title {7}, \\\n"
      "  'contour.dat' using ($1*{5:.9g}):($2*{6:.9g}) with points pointtype 7 pointsize 0.7 linecolor rgb "
      "'{8}' "
      "notitle, \\\n"
      "  '+' using ({9:.9g}):({10:.9g}) every ::0::0 with points pointtype 2 pointsize 1.8 linecolor rgb "
      "'{11}' "
      "title 'the study'\n",
      picture_title("Budget met exactly", spec.title), x_axis.range, y_axis.range,
      gnuplot_text(across.label(second)), gnuplot_text(up.label(first)), across.per_si, up.per_si,
      gnuplot_text(budgets + (spec.contour.is_closed ? ""
                              : below                ? " holds below"
                                                     : " holds above")),
      kTargetColour, start[1].start * across.per_si, start[0].start * up.per_si, kFittedColour, x_axis.tics,
      y_axis.tics);
  return draw_pictures({picture}, directory, warnings);
}

}  // namespace aberfit
