#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "picture.h"

namespace aberfit::internal {
namespace {

constexpr const char* kTimeColour = "#666666";

// Points of one kind as columns; a picture of logarithms has no room for zeros.
std::vector<Eigen::ArrayXd> columns(const std::vector<FrontierPoint>& points, auto wanted) {
  std::vector<const FrontierPoint*> picked;
  for (const FrontierPoint& point : points)
    if (wanted(point)) picked.push_back(&point);
  std::vector<Eigen::ArrayXd> result(4, Eigen::ArrayXd(Eigen::Index(picked.size())));
  for (std::size_t i = 0; i < picked.size(); ++i) {
    const auto k = Eigen::Index(i);
    result[0][k] = double(picked[i]->terms);
    result[1][k] = picked[i]->fitted_mismatch;
    result[2][k] = picked[i]->held_out_mismatch;
    result[3][k] = std::max(picked[i]->seconds, 1e-3);
  }
  return result;
}

}  // namespace

// Terms against what stays between target and fit: above, the fitted statistics in tolerances; below, the
// held-out ones in percent on fresh rays, with the margin and the time of every set.
Picture frontier_picture(const PlotInput& input) {
  const Frontier& frontier = *input.result.frontier;
  const std::string name = "frontier";
  Picture picture{name, script_head(name, 1200, 900), {}};
  const std::vector<std::string> header = {
      "Sets of terms that were tried: number of terms, largest mismatch of the fitted statistics "
      "[tolerances],",
      "largest mismatch of the held-out ones on fresh rays (relative; nan: not judged), time [s]"};
  const auto kind = [&](const char* suffix, auto wanted) {
    auto data = columns(frontier.points, wanted);
    // gnuplot calls a file without a row an error.
    if (data[0].size() == 0)
      for (Eigen::ArrayXd& column : data) column = Eigen::ArrayXd::Constant(1, NAN);
    picture.add_columns(fmt::format("{}_{}.dat", name, suffix), header, data);
  };
  kind("failed", [](const FrontierPoint& p) { return !p.passes; });
  kind("passed", [](const FrontierPoint& p) { return p.passes; });
  kind("chosen", [](const FrontierPoint& p) { return p.chosen; });
  kind("all", [](const FrontierPoint&) { return true; });
  double fewest = HUGE_VAL, most = 1;
  for (const FrontierPoint& point : frontier.points) {
    fewest = std::min(fewest, double(point.terms));
    most = std::max(most, double(point.terms));
  }
  // Tics where sets are, as many as have room, the one taken first; decades alone would leave a narrow search
  // without a number.
  const double low = 0.8 * fewest, high = 1.25 * most, apart = std::pow(high / low, 1.0 / 16);
  std::vector<double> placed;
  for (const bool chosen : {true, false})
    for (const FrontierPoint& point : frontier.points) {
      const double at = double(point.terms);
      const bool free = std::none_of(placed.begin(), placed.end(),
                                     [&](double other) { return at < apart * other && other < apart * at; });
      if (point.chosen == chosen && free) placed.push_back(at);
    }
  const auto points_of = [&](const char* column, int scale) {
    return fmt::format(
        "'{0}_failed.dat' using 1:({3}*{4}) with points pointtype 2 pointsize 1.4 linecolor rgb '{1}' "
        "title 'fitted, does not pass', \\\n"
        "  '{0}_passed.dat' using 1:({3}*{4}) with points pointtype 7 pointsize 1.4 linecolor rgb '{2}' "
        "title 'passes', \\\n"
        "  '{0}_chosen.dat' using 1:({3}*{4}) with points pointtype 4 pointsize 3 linewidth 2 linecolor rgb "
        "'black' title 'taken'",
        name, kFittedColour, kTargetColour, column, scale);
  };
  picture.script += fmt::format(
      "set multiplot layout 2,1 title {0} noenhanced\n"
      "set logscale xy\nset xrange [{1:.9g}:{2:.9g}]\nset xtics ({10:.0f})\nset lmargin 10\nset rmargin 10\n"
      "set format y '%g'\nset ylabel 'worst fitted statistic [tolerances]'\nset yrange [*<0.5:2<*]\n"
      "set key outside top center horizontal maxrows 2\n"
      "plot 1 with lines linecolor rgb '{3}' linewidth 1.5 dashtype 2 title 'tolerance', \\\n  {4}\n"
      "unset key\nset xlabel 'terms'\nset ylabel 'worst held-out statistic [%]'\n"
      "unset logscale y\nset yrange [0:{5:.9g}<*]\n"
      "set y2label 'time of the set [s]' textcolor rgb '{6}'\nset logscale y2\nset y2tics textcolor rgb "
      "'{6}'\n"
      "set format y2 '%g'\n"
      "set label 1 'margin of the verdict' at graph 0.01, first {7:.9g} offset 0,0.6 textcolor rgb '{3}'\n"
      "plot {7:.9g} with lines linecolor rgb '{3}' linewidth 1.5 dashtype 2 notitle, \\\n"
      "  '{8}_all.dat' using 1:4 axes x1y2 with linespoints pointtype 1 pointsize 0.7 linecolor rgb '{6}' "
      "dashtype 3 linewidth 1 notitle, \\\n  {9}\n"
      "unset multiplot\n",
      picture_title(input, frontier.fewest ? "Fewest terms that do" : "Sets of terms that were tried"), low,
      high, "#009E73", points_of("$2", 1), 130 * frontier.margin, kTimeColour, 100 * frontier.margin, name,
      points_of("$3", 100), fmt::join(placed, ", "));
  return picture;
}

}  // namespace aberfit::internal
