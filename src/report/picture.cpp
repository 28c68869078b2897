#include "picture.h"

#include <fmt/format.h>

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

void append_comments(std::string* text, const std::vector<std::string>& header) {
  for (const std::string& line : header) *text += "# " + line + "\n";
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

std::string columns_file(const std::vector<std::string>& header, const std::vector<Eigen::ArrayXd>& columns) {
  std::string text;
  append_comments(&text, header);
  for (Eigen::Index row = 0; row < columns.front().size(); ++row)
    for (std::size_t k = 0; k < columns.size(); ++k)
      fmt::format_to(std::back_inserter(text), "{:.9g}{}", columns[k][row],
                     k + 1 < columns.size() ? ' ' : '\n');
  return text;
}

std::string matrix_file(const std::vector<std::string>& header, const Eigen::ArrayXXd& matrix) {
  std::string text;
  append_comments(&text, header);
  for (Eigen::Index row = 0; row < matrix.rows(); ++row)
    for (Eigen::Index column = 0; column < matrix.cols(); ++column)
      fmt::format_to(std::back_inserter(text), "{:.6g}{}", matrix(row, column),
                     column + 1 < matrix.cols() ? ' ' : '\n');
  return text;
}

}  // namespace aberfit::internal
