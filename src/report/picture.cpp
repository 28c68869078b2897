#include "picture.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <numeric>
#include <system_error>

#include "aberfit/core/embedded_texts.h"
#include "aberfit/core/parallel.h"
#include "aberfit/report/result.h"
#include "gnuplot.h"

namespace aberfit::internal {
namespace {

AxisUnit unit(double largest, const std::vector<AxisUnit>& ascending) {
  AxisUnit best = ascending.front();
  // The factor is 1.5, because 1200 um is easier to read than 1.2 mm.
  for (const AxisUnit& candidate : ascending)
    if (largest * candidate.per_si >= 1.5) best = candidate;
  return best;
}

std::string comments(const std::vector<std::string>& header) {
  std::string text;
  for (const std::string& line : header) text += "# " + line + "\n";
  return text;
}

// Adds rows of numbers with `digits` digits.
void add_rows(Eigen::Index rows, Eigen::Index columns, int digits, const auto& number, std::string* text) {
  for (Eigen::Index row = 0; row < rows; ++row)
    for (Eigen::Index column = 0; column < columns; ++column)
      fmt::format_to(std::back_inserter(*text), "{:.{}g}{}", number(row, column), digits,
                     column + 1 < columns ? ' ' : '\n');
}

void add_block(const PictureColumns& columns, std::string* text) {
  add_rows(
      columns.front().size(), Eigen::Index(columns.size()), 9,
      [&](Eigen::Index row, Eigen::Index column) { return columns[std::size_t(column)][row]; }, text);
}

// A constant with a decimal point or exponent, because gnuplot divides integers as C does.
std::string gnuplot_number(double value) {
  if (!std::isfinite(value)) return "NaN";
  const std::string text = fmt::format("{:.9g}", value);
  return text.find_first_of(".e") == std::string::npos ? text + ".0" : text;
}

// Text after `# key:` at the top of a script; lines that begin with "#   " continue it.
std::string said(const std::string& script, const std::string& key) {
  const std::string begin = "# " + key + ": ";
  std::size_t at = script.find(begin);
  if (at == std::string::npos) return "";
  std::string text;
  for (at += begin.size();;) {
    const std::size_t end = script.find('\n', at);
    text += script.substr(at, end - at);
    if (script.compare(end, 5, "\n#   ") != 0) return text;
    text += ' ';
    at = end + 5;
  }
}

std::string format_of(const Picture& picture, PictureFormat wanted) {
  if (wanted != PictureFormat::kAuto) return picture_format_names()[std::size_t(wanted)];
  return picture.has_cloud ? "png" : said(embedded_text(picture.script + ".gp"), "format");
}

}  // namespace

Picture::Picture(std::string picture_name, const std::string& study, const std::string& script_name)
    : name(std::move(picture_name)), script(script_name.empty() ? name : script_name) {
  set("study", study);
}

void Picture::set(const std::string& variable, double value) {
  values += fmt::format("{} = {}\n", variable, gnuplot_number(value));
}

void Picture::set(const std::string& variable, int value) {
  values += fmt::format("{} = {}\n", variable, value);
}

void Picture::set(const std::string& variable, const std::string& text) {
  values += fmt::format("{} = {}\n", variable, gnuplot_text(text));
}

void Picture::set(const std::string& variable, const std::vector<double>& numbers) {
  std::vector<std::string> texts;
  for (const double number : numbers) texts.push_back(gnuplot_number(number));
  if (!texts.empty())
    values += fmt::format("array {}[{}] = [{}]\n", variable, texts.size(), fmt::join(texts, ", "));
}

void Picture::set(const std::string& variable, const std::vector<std::string>& texts) {
  std::vector<std::string> quoted;
  for (const std::string& text : texts) quoted.push_back(gnuplot_text(text));
  if (!texts.empty())
    values += fmt::format("array {}[{}] = [{}]\n", variable, texts.size(), fmt::join(quoted, ", "));
}

void Picture::set(const std::string& axis, const AxisUnit& of) {
  set(axis + "_scale", of.per_si);
  set(axis + "_unit", of.name);
}

void Picture::set_pixels(double x_first, double x_pitch, double y_first, double y_pitch) {
  set("x_first", x_first);
  set("x_pitch", x_pitch);
  set("y_first", y_first);
  set("y_pitch", y_pitch);
}

void Picture::add_columns(const std::string& file, const std::vector<std::string>& header,
                          const PictureColumns& columns) {
  add_blocks(file, header, {columns});
}

void Picture::add_blocks(const std::string& file, const std::vector<std::string>& header,
                         const std::vector<PictureColumns>& blocks) {
  std::string text = comments(header);
  for (std::size_t k = 0; k < blocks.size(); ++k) {
    if (k > 0) text += "\n\n";
    add_block(blocks[k], &text);
  }
  data.emplace_back(file, std::move(text));
}

void Picture::add_matrix(const std::string& file, const std::vector<std::string>& header,
                         const Eigen::ArrayXXd& matrix) {
  std::string text = comments(header);
  add_rows(matrix.rows(), matrix.cols(), 6, matrix, &text);
  data.emplace_back(file, std::move(text));
}

void Picture::add_rim(const ClearRegion& clear, double dx, double dy) {
  std::vector<PictureColumns> lines;
  for (const auto& line : clear.outlines()) {
    PictureColumns points(2, Eigen::ArrayXd(Eigen::Index(line.size())));
    for (std::size_t i = 0; i < line.size(); ++i) {
      points[0][Eigen::Index(i)] = line[i][0] + dx;
      points[1][Eigen::Index(i)] = line[i][1] + dy;
    }
    lines.push_back(points);
  }
  set("rims", int(lines.size()));
  if (!lines.empty()) add_blocks(name + "_rim.dat", {"Rims of the clear aperture: x [m], y [m]"}, lines);
}

std::vector<DrawnPicture> draw(const std::vector<Picture>& pictures, const std::string& directory,
                               const PictureOptions& options, Warnings* warnings) {
  namespace fs = std::filesystem;
  if (pictures.empty() || options.format == PictureFormat::kNone) return {};
  const fs::path folder = fs::path(directory) / "plots";
  const std::string gnuplot = find_gnuplot();
  write_file((folder / "common.gp").string(), embedded_text("common.gp"));
  std::vector<std::string> files(pictures.size()), problems(pictures.size());
  // Maps take longest and come first, so that no thread draws one alone at the end.
  std::vector<std::size_t> order(pictures.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_partition(order.begin(), order.end(),
                        [&](std::size_t k) { return format_of(pictures[k], PictureFormat::kAuto) == "png"; });
  parallel_for(order.size(), options.threads, [&](std::size_t place) {
    const std::size_t k = order[place];
    const Picture& picture = pictures[k];
    const std::string format = format_of(picture, options.format);
    for (const auto& [file, text] : picture.data) write_file((folder / file).string(), text);
    write_file((folder / (picture.name + ".values")).string(),
               fmt::format("# Read by {}.gp: SI units, *_scale axis units per SI unit.\n"
                           "if (!exists('format')) format = '{}'\n{}",
                           picture.name, format, picture.values));
    write_file((folder / (picture.name + ".gp")).string(), embedded_text(picture.script + ".gp"));
    std::error_code ignored;
    for (const char* ending : {"png", "svg", "pdf"})  // a picture of an earlier run would be wrong
      fs::remove(folder / (picture.name + "." + ending), ignored);
    files[k] = picture.name + "." + format;
    problems[k] = gnuplot.empty() ? "gnuplot is not on PATH"
                                  : run_gnuplot(gnuplot, folder.string(), picture.name + ".gp");
    if (!problems[k].empty()) fs::remove(folder / files[k], ignored);  // incomplete
  });
  std::vector<DrawnPicture> drawn;
  std::string problem;
  for (std::size_t k = 0; k < pictures.size(); ++k) {
    const std::string& script = embedded_text(pictures[k].script + ".gp");
    if (problems[k].empty())
      drawn.push_back({pictures[k].name, "plots/" + files[k],
                       pictures[k].title.empty() ? said(script, "title") : pictures[k].title,
                       said(script, "caption"), said(script, "alt")});
    else if (problem.empty())
      problem = gnuplot.empty()
                    ? problems[k]
                    : fmt::format("gnuplot could not draw {} ({})", pictures[k].name, problems[k]);
  }
  if (!problem.empty() && warnings)
    warnings->push_back(
        {"no-gnuplot", problem + ", so pictures are missing. Their data and scripts are in the folder "
                                 "`plots` of the results. Install gnuplot with the terminals png, svg and "
                                 "pdf (Debian: gnuplot-nox) and run `gnuplot NAME.gp` there."});
  return drawn;
}

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
  std::string out = "\"";
  for (const char c : text) {
    if (c == '\\' || c == '"') out += '\\';
    const bool is_control = static_cast<unsigned char>(c) < ' ' || c == '\x7f';
    out += c == '`' ? '\'' : is_control ? ' ' : c;
  }
  return out + "\"";
}

namespace {

// A tic at digit 10^power. The power is a superscript if the number is long.
std::string tic(double digit, int power) {
  const std::string at = fmt::format("{:.9g}", digit * std::pow(10.0, power));
  if (power >= -3 && power <= 4) return at;
  constexpr const char* kDigits[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string text = (digit == 1 ? "10" : fmt::format("{:g}·10", digit)) + (power < 0 ? "⁻" : "");
  for (const char each : std::to_string(std::abs(power))) text += kDigits[each - '0'];
  return fmt::format("\"{}\" {}", text, at);
}

}  // namespace

std::string log_tics(double low, double high) {
  if (!(low > 0) || !std::isfinite(high)) return "autofreq";
  const std::vector<double> digits = high > 100 * low  ? std::vector<double>{1}
                                     : high > 10 * low ? std::vector<double>{1, 2, 5}
                                                       : std::vector<double>{1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 7};
  std::vector<std::string> tics;
  for (int power = int(std::floor(std::log10(low))); power <= int(std::log10(high)) + 1; ++power) {
    for (const double digit : digits) {
      const double at = digit * std::pow(10.0, power);
      if (!(at >= low && at <= high)) continue;
      tics.push_back(tic(digit, power));
    }
    if (digits.size() > 1) continue;
    for (int minor = 2; minor <= 9; ++minor) {
      const double at = minor * std::pow(10.0, power);
      if (at >= low && at <= high) tics.push_back(fmt::format("\"\" {:.9g} 1", at));
    }
  }
  return fmt::format("({})", fmt::join(tics, ", "));
}

std::string log_axis(const std::string& axis, double low, double high) {
  return fmt::format("set logscale {0}; set {0}range [{1:.9g}:{2:.9g}]; set format {0} '%g'; set {0}tics {3}",
                     axis, low, high, log_tics(low, high));
}

double largest_size(const Eigen::ArrayXXd& values) {
  double largest = 0;
  for (const double value : values.reshaped())
    if (std::isfinite(value)) largest = std::max(largest, std::abs(value));
  return largest;
}

double colour_reach(const std::vector<const Grid*>& maps) {
  constexpr double kShown = 0.999, kLeast = 1e-15;
  std::vector<double> heights;
  for (const Grid* map : maps)
    for (const double h : map->reshaped())
      if (std::isfinite(h)) heights.push_back(std::abs(h));
  if (heights.empty()) return kLeast;
  const auto at = std::ptrdiff_t(kShown * double(heights.size() - 1));
  std::nth_element(heights.begin(), heights.begin() + at, heights.end());
  return std::max(heights[std::size_t(at)], kLeast);
}

Eigen::ArrayXd array_of(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::ArrayXd>(values.data(), Eigen::Index(values.size()));
}

}  // namespace aberfit::internal
