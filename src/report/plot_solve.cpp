#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "aberfit/report/solve_report.h"
#include "picture.h"
#include "unknown_text.h"

namespace aberfit {
using namespace internal;

namespace {

// Unit of a logarithmic axis that suits the largest number.
AxisUnit axis_unit(const SolveUnknown& unknown, double largest) {
  if (unknown.dimension == Dimension::kLength) return length_unit(largest);
  if (unknown.dimension == Dimension::kSpatialFrequency)
    return largest < 1000 ? AxisUnit{1, "1/m"} : AxisUnit{1e-3, "1/mm"};
  return {1, unknown.dimension == Dimension::kPsd2d ? "m^4" : "1"};
}

// The second unknown is on the horizontal axis, the first on the vertical one.
Picture contour_picture(const Specification& spec) {
  const auto count = Eigen::Index(spec.contour.points.size());
  Eigen::ArrayXd x(count), y(count);
  for (Eigen::Index k = 0; k < count; ++k) {
    x[k] = spec.contour.points[std::size_t(k)].at[1];
    y[k] = spec.contour.points[std::size_t(k)].at[0];
  }
  Picture picture("contour", spec.title);
  picture.add_columns("contour.dat",
                      {"Where the strictest budget is met exactly: " + spec.unknowns[1].pointer + ", " +
                       spec.unknowns[0].pointer + ", SI units"},
                      {x, y});
  const auto place = [](double at_x, double at_y) {
    return PictureColumns{Eigen::ArrayXd::Constant(1, at_x), Eigen::ArrayXd::Constant(1, at_y)};
  };
  std::vector<PictureColumns> marks = {place(spec.unknowns[1].start, spec.unknowns[0].start)};
  for (const SolvePoint& solution : spec.solutions) marks.push_back(place(solution.at[1], solution.at[0]));
  picture.add_blocks("contour_marks.dat", {"The study, then its solutions, on the same axes"}, marks);
  const auto set_axis = [&](const std::string& axis, Eigen::ArrayXd all, const SolveUnknown& unknown) {
    all.conservativeResize(count + 1);
    all[count] = unknown.start;
    const AxisUnit unit = axis_unit(unknown, all.maxCoeff());
    const double low = all.minCoeff() * unit.per_si / 1.3, high = all.maxCoeff() * unit.per_si * 1.3;
    picture.set(axis, unit);
    picture.set(axis + "_name", name_of(unknown));
    picture.set(axis + "_axis", log_axis(axis, low, high));
  };
  set_axis("x", x, spec.unknowns[1]);
  set_axis("y", y, spec.unknowns[0]);
  std::string budgets;
  for (const Budget& budget : spec.budgets)
    budgets += (budgets.empty() ? "" : ", ") + budget.key + " " + budget.bound;
  if (!spec.contour.is_closed)
    budgets += spec.solutions.front().holds_below ? " holds below" : " holds above";
  picture.set("budgets", budgets);
  picture.set("solved", int(marks.size() > 1));
  return picture;
}

Picture light_picture(const Specification& spec, const BudgetLight& light) {
  Picture picture("budget_light", spec.title);
  const bool solved = light.solution.size() > 0;
  picture.add_columns("budget_light.dat",
                      {"Encircled energy in the focus by theory",
                       "columns: radius_m without_roughness study solution (nan: none)"},
                      {light.radius, light.perfect, light.study,
                       solved ? light.solution : Eigen::ArrayXd::Constant(light.radius.size(), NAN)});
  std::vector<double> radius, fraction;
  std::vector<std::string> texts;
  for (const Budget& budget : spec.budgets)
    if (const double limit = budgeted_radius(budget, spec.focal_length); std::isfinite(limit)) {
      radius.push_back(limit);
      fraction.push_back(std::get<EncircledEnergyRadius>(budget.statistic).fraction);
      texts.push_back(budget.key + " " + budget.bound);
    }
  const double low = light.radius[0], high = light.radius[light.radius.size() - 1];
  const AxisUnit unit = length_unit(high);
  picture.set("r", unit);
  picture.set("r_axis", log_axis("x", low * unit.per_si, high * unit.per_si));
  picture.set("solved", int(solved));
  picture.set("marks", int(radius.size()));
  picture.set("radius", radius);
  picture.set("fraction", fraction);
  picture.set("budget", texts);
  return picture;
}

// Bars of all budgets and unknowns, the longest first.
std::vector<Picture> sensitivities_picture(const Specification& spec) {
  constexpr int kMargins = 150, kBar = 46;  // [pixels]
  if (spec.solutions.empty()) return {};
  std::vector<std::pair<double, std::string>> bars;
  const SolvePoint& solution = spec.solutions.front();
  for (std::size_t k = 0; k < solution.budgets.size(); ++k)
    for (std::size_t u = 0; u < solution.budgets[k].sensitivity.size(); ++u)
      if (const double slope = solution.budgets[k].sensitivity[u]; std::isfinite(slope))
        bars.emplace_back(slope, fmt::format("{} over {}", spec.budgets[k].key, name_of(spec.unknowns[u])));
  if (bars.empty()) return {};
  std::stable_sort(bars.begin(), bars.end(),
                   [](const auto& a, const auto& b) { return std::abs(a.first) > std::abs(b.first); });
  std::vector<double> place, slope;
  std::vector<std::string> names;
  for (const auto& [value, name] : bars) {
    place.push_back(double(place.size() + 1)), slope.push_back(value);
    names.push_back(name);
  }
  Picture picture("sensitivities", spec.title);
  picture.add_columns(
      "sensitivities.dat",
      {"Sensitivities d ln(value)/d ln(unknown) at the solution: place of the bar, sensitivity"},
      {array_of(place), array_of(slope)});
  picture.set("height", kMargins + kBar * int(bars.size()));
  picture.set("bars", int(bars.size()));
  picture.set("bar", names);
  picture.set("longest", std::abs(slope.front()));
  return {picture};
}

}  // namespace

std::vector<DrawnPicture> draw_pictures(const Specification& spec, const BudgetLight& light,
                                        const std::string& directory, const PictureOptions& options,
                                        Warnings* warnings) {
  std::vector<Picture> pictures = sensitivities_picture(spec);
  if (light.radius.size() > 0) pictures.insert(pictures.begin(), light_picture(spec, light));
  if (!spec.contour.points.empty()) pictures.push_back(contour_picture(spec));
  return draw(pictures, directory, options, warnings);
}

}  // namespace aberfit
