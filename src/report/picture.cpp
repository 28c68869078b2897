#include "picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace aberfit::internal {
namespace {

AxisUnit unit(double largest, const std::vector<AxisUnit>& ascending) {
  AxisUnit best = ascending.front();
  // 1.5: a picture of 1.2 mm reads better as 1200 um.
  for (const AxisUnit& candidate : ascending)
    if (largest * candidate.per_si >= 1.5) best = candidate;
  return best;
}

// The sentences of `header` as comments, then rows of numbers with so many digits.
std::string data_text(const std::vector<std::string>& header, Eigen::Index rows, Eigen::Index columns,
                      int digits, const auto& number) {
  std::string text;
  for (const std::string& line : header) text += "# " + line + "\n";
  for (Eigen::Index row = 0; row < rows; ++row)
    for (Eigen::Index column = 0; column < columns; ++column)
      fmt::format_to(std::back_inserter(text), "{:.{}g}{}", number(row, column), digits,
                     column + 1 < columns ? ' ' : '\n');
  return text;
}

}  // namespace

AxisUnit length_unit(double largest) {
  return unit(largest, {{1e12, "pm"}, {1e9, "nm"}, {1e6, "µm"}, {1e3, "mm"}, {1.0, "m"}});
}

AxisUnit angle_unit(double largest) {
  return unit(largest, {{1e9, "nrad"}, {1e6, "µrad"}, {1e3, "mrad"}, {1.0, "rad"}});
}

std::string display(double value, Dimension dimension) {
  std::string text = format_quantity(value, dimension);
  if (const std::size_t at = text.find(" u"); at != std::string::npos) text.replace(at, 2, " µ");
  return text;
}

std::string gnuplot_text(const std::string& text) {
  std::string out = "'";
  for (const char c : text) {
    if (c == '\'') out += '\'';
    out += static_cast<unsigned char>(c) < ' ' || c == '\x7f' ? ' ' : c;
  }
  return out + "'";
}

std::string script_head(const std::string& name, int width, int height) {
  return fmt::format(
      "# Draws {0}.png from the data files beside it: run `gnuplot {0}.gp` in this folder.\n"
      "set terminal pngcairo noenhanced size {1},{2} font 'DejaVu Sans,14' linewidth 1.5 background rgb "
      "'white'\n"
      "set encoding utf8\n"
      "set output '{0}.png'\n"
      "set border linewidth 1.2\n"
      "set tics nomirror\n"
      "set grid linecolor rgb '#dddddd' linetype 1 linewidth 0.7\n"
      "set linetype 1 linecolor rgb '{3}' linewidth 2 dashtype 3\n"
      "set linetype 2 linecolor rgb '{4}' linewidth 2.5 dashtype 1\n"
      "set linetype 3 linecolor rgb '{5}' linewidth 2.5 dashtype (12,5)\n"
      "set key tmargin center horizontal Left reverse\n",
      name, width, height, kIdealColour, kTargetColour, kFittedColour);
}

std::string picture_title(const PlotInput& input, const std::string& text) {
  return picture_title(text, input.result.title);
}

std::string picture_title(const std::string& text, const std::string& of) {
  std::string title = of.empty() ? text : text + " - " + of;
  constexpr std::size_t kWidest = 105;  // bytes at the title's font over 1200 pixels
  if (title.size() > kWidest) {
    std::size_t end = kWidest;
    while (end > 0 && (static_cast<unsigned char>(title[end]) & 0xC0) == 0x80)
      --end;  // not inside a UTF-8 character
    title = title.substr(0, end) + "...";
  }
  return gnuplot_text(title);
}

std::string signed_palette() {
  return "set palette defined (-1 '#053061', -0.75 '#2166ac', -0.5 '#4393c3', -0.25 '#b0d2e6', 0 '#f7f7f7', "
         "0.25 '#f6bfa6', 0.5 '#d6604d', 0.75 '#b2182b', 1 '#67001f')\n";
}

void Picture::add_columns(const std::string& file, const std::vector<std::string>& header,
                          const std::vector<Eigen::ArrayXd>& columns) {
  const auto number = [&](Eigen::Index row, Eigen::Index column) {
    return columns[std::size_t(column)][row];
  };
  data.emplace_back(file, data_text(header, columns.front().size(), Eigen::Index(columns.size()), 9, number));
}

void Picture::add_matrix(const std::string& file, const std::vector<std::string>& header,
                         const Eigen::ArrayXXd& matrix) {
  data.emplace_back(file, data_text(header, matrix.rows(), matrix.cols(), 6, matrix));
}

std::string rim_curves(Picture* picture, const ClearRegion& clear, double dx, double dy, double scale) {
  std::string curves;
  for (const auto& line : clear.outlines()) {
    Eigen::ArrayXd x(Eigen::Index(line.size())), y(x.size());
    for (Eigen::Index i = 0; i < x.size(); ++i)
      x[i] = line[std::size_t(i)][0] + dx, y[i] = line[std::size_t(i)][1] + dy;
    const std::string file = fmt::format("{}_rim{}.dat", picture->name, curves.empty() ? "" : "_inner");
    picture->add_columns(file, {"Rim of the clear aperture: x [m], y [m]"}, {x, y});
    curves += fmt::format(
        "{}'{}' using ($1*{:.9g}):($2*{:.9g}) with lines linecolor rgb 'black' linewidth 1.5 "
        "dashtype 2",
        kNextCurve, file, scale, scale);
  }
  return curves;
}

std::string log_tics(double low, double high) {
  if (!(low > 0) || !std::isfinite(high)) return "autofreq";
  const std::vector<double> digits = high > 100 * low  ? std::vector<double>{1}
                                     : high > 10 * low ? std::vector<double>{1, 2, 5}
                                                       : std::vector<double>{1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 7};
  std::string tics;
  for (int power = int(std::floor(std::log10(low))); power <= int(std::log10(high)) + 1; ++power)
    for (const double digit : digits) {
      const double at = digit * std::pow(10.0, power);
      if (at >= low && at <= high) tics += fmt::format("{}{:.9g}", tics.empty() ? "" : ", ", at);
    }
  return "(" + tics + ")";
}

std::string symmetric_range(const std::string& axis, double reach) {
  return fmt::format("set {}range [{:.9g}:{:.9g}]\n", axis, -reach, reach);
}

double largest_size(const Eigen::ArrayXXd& values) {
  double largest = 0;
  for (const double value : values.reshaped())
    if (std::isfinite(value)) largest = std::max(largest, std::abs(value));
  return largest;
}

Eigen::ArrayXd array_of(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::ArrayXd>(values.data(), Eigen::Index(values.size()));
}

}  // namespace aberfit::internal
