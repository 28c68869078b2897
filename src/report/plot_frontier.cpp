#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "fit_pictures.h"

namespace aberfit::internal {
namespace {

// Points of one kind as columns. A logarithmic axis cannot show zeros.
PictureColumns columns(const std::vector<FrontierPoint>& points, auto wanted) {
  std::vector<const FrontierPoint*> picked;
  for (const FrontierPoint& point : points)
    if (wanted(point)) picked.push_back(&point);
  PictureColumns result(4, Eigen::ArrayXd(Eigen::Index(picked.size())));
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

Picture frontier_picture(const FitPictures& fit) {
  const Frontier& frontier = *fit.result.choices.frontier;
  Picture picture("frontier", fit.result.title);
  const auto add = [&](const char* suffix, auto wanted) {
    PictureColumns data = columns(frontier.points, wanted);
    // A file without rows is an error for gnuplot.
    if (data[0].size() == 0)
      for (Eigen::ArrayXd& column : data) column = Eigen::ArrayXd::Constant(1, NAN);
    picture.add_columns(
        fmt::format("frontier_{}.dat", suffix),
        {"Sets of terms that were tried: number of terms, largest mismatch of the fitted statistics "
         "[tolerances],",
         "largest mismatch of the held-out ones on fresh rays (relative; nan: not judged), time [s]"},
        data);
  };
  add("failed", [](const FrontierPoint& p) { return !p.passes; });
  add("passed", [](const FrontierPoint& p) { return p.passes; });
  add("chosen", [](const FrontierPoint& p) { return p.chosen; });
  add("all", [](const FrontierPoint&) { return true; });
  const Eigen::ArrayXd terms = columns(frontier.points, [](const FrontierPoint&) { return true; })[0];
  const double low = 0.8 * terms.minCoeff(), high = 1.25 * std::max(1.0, terms.maxCoeff());
  // Tics are at the sets, as many as fit, the chosen set first. Decades alone would leave a narrow search
  // without a number.
  const double apart = std::pow(high / low, 1.0 / 16);
  std::vector<double> placed;
  for (const bool chosen : {true, false})
    for (const FrontierPoint& point : frontier.points) {
      const double at = double(point.terms);
      const bool free = std::none_of(placed.begin(), placed.end(),
                                     [&](double other) { return at < apart * other && other < apart * at; });
      if (point.chosen == chosen && free) placed.push_back(at);
    }
  picture.set("low", low);
  picture.set("high", high);
  picture.set("term_tics", fmt::format("({:.0f})", fmt::join(placed, ", ")));
  picture.set("margin", frontier.margin);
  picture.set("fewest", int(frontier.fewest));
  return picture;
}

}  // namespace aberfit::internal
