#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <functional>
#include <iterator>
#include <map>

#include "aberfit/core/constants.h"
#include "aberfit/report/sweep_report.h"
#include "picture.h"

namespace aberfit {
using namespace internal;

namespace {

constexpr std::size_t kMostLines = 7, kMostLinesWithBands = 3;
constexpr double kLogFromRatio = 20;  // of the largest over the smallest value: shown by its logarithm
constexpr std::size_t kMostMarks = 60;
// Okabe & Ito 2008, as the common colours of all pictures.
constexpr const char* kLineColours[] = {"#0072B2", "#D55E00", "#009E73", "#CC79A7",
                                        "#E69F00", "#56B4E9", "#000000"};

// Round numbers at it, a little room at its ends.
std::string log_axis(const std::string& axis, double low, double high) {
  constexpr double kRoom = 1.08;
  return fmt::format(
      "set logscale {0}\nset format {0} '%g'\nset {0}range [{1:.9g}:{2:.9g}]\nset {0}tics {3}\n", axis,
      low / kRoom, high * kRoom, log_tics(low / kRoom, high * kRoom));
}

// An axis of a picture: words stand at 0, 1, ... in their order.
struct SweptAxis {
  std::size_t place = 0;
  std::vector<std::string> words;  // of an axis without numbers
  std::string label;
  bool is_log = false;
  double low = kNaN, high = kNaN;  // of the numbers of a logarithmic axis

  double at(const SweepRow& row) const {
    if (words.empty()) return row.number[place];
    return double(std::find(words.begin(), words.end(), row.typed[place]) - words.begin());
  }
  std::string script(const std::string& axis) const {
    std::string text = fmt::format("set {}label {}\n", axis, gnuplot_text(label));
    if (is_log) text += log_axis(axis, low, high);
    if (words.empty()) return text;
    text += fmt::format("set {}tics (", axis);
    for (std::size_t k = 0; k < words.size(); ++k)
      text += fmt::format("{}{} {}", k ? ", " : "", gnuplot_text(words[k]), k);
    return text + ")\n";
  }
};

std::string last_key(const std::string& pointer) { return pointer.substr(pointer.rfind('/') + 1); }

SweptAxis axis_of(const SweepReport& report, std::size_t place) {
  const SweepAxis& axis = report.axes[place];
  SweptAxis found;
  found.place = place;
  found.label = last_key(axis.pointer) + (axis.unit.empty() ? "" : " [" + axis.unit + "]");
  std::vector<double> numbers;
  for (const SweepRow& row : report.rows) numbers.push_back(row.number[place]);
  const SweepQuantiles q = quantiles_of(std::move(numbers));
  found.is_log = axis.is_numeric && axis.is_log && q.smallest > 0;
  found.low = q.smallest, found.high = q.largest;
  if (axis.is_numeric) return found;
  for (const SweepRow& row : report.rows)
    if (std::find(found.words.begin(), found.words.end(), row.typed[place]) == found.words.end())
      found.words.push_back(row.typed[place]);
  return found;
}

// What is drawn: a statistic in the unit that suits it.
struct SweptStatistic {
  std::size_t place = 0;
  AxisUnit unit;
  std::string name, file;
  double smallest = kNaN, largest = kNaN;
  bool is_log = false;

  double at(const SweepRow& row) const { return row.values[place] * unit.per_si; }
  std::string label() const { return unit.name.empty() ? name : unit.label(name); }
};

SweptStatistic swept_statistic(const SweepReport& report, const std::string& name) {
  SweptStatistic found;
  found.place = std::size_t(std::find(report.statistics.begin(), report.statistics.end(), name) -
                            report.statistics.begin());
  std::vector<double> values;
  for (const SweepRow& row : report.rows) values.push_back(row.values[found.place]);
  const SweepQuantiles q = quantiles_of(std::move(values));
  const double size = q.count > 0 ? std::max(std::abs(q.smallest), std::abs(q.largest)) : 0;
  const Dimension dimension = dimension_of_name(name);
  found.unit = dimension == Dimension::kLength  ? length_unit(size)
               : dimension == Dimension::kAngle ? angle_unit(size)
                                                : AxisUnit{1, ""};
  found.smallest = q.smallest * found.unit.per_si, found.largest = q.largest * found.unit.per_si;
  found.is_log = q.smallest > 0 && q.largest > kLogFromRatio * q.smallest;
  found.name = name_without_unit(name);
  for (const char c : found.name)
    found.file += std::isalnum(static_cast<unsigned char>(c)) || c == '.' || c == '-' ? c : '_';
  return found;
}

// Rows by a number of theirs, ascending.
using Groups = std::map<double, std::vector<double>>;
Groups grouped_values(const std::vector<const SweepRow*>& rows, const SweptAxis& x,
                      const SweptStatistic& statistic) {
  Groups groups;
  for (const SweepRow* row : rows) groups[x.at(*row)].push_back(statistic.at(*row));
  return groups;
}

// x, then the quantiles that bands and line go through.
void add_curve(const Groups& groups, const std::string& file, const SweptAxis& x,
               const SweptStatistic& statistic, Picture* picture) {
  std::vector<std::vector<double>> columns(6);
  for (const auto& [at, values] : groups) {
    const SweepQuantiles q = quantiles_of(values);
    if (q.count == 0) continue;
    for (const auto& [k, value] :
         {std::pair{0, at}, {1, q.q50}, {2, q.q05}, {3, q.q25}, {4, q.q75}, {5, q.q95}})
      columns[std::size_t(k)].push_back(value);
  }
  std::vector<Eigen::ArrayXd> arrays;
  for (const std::vector<double>& column : columns) arrays.push_back(array_of(column));
  picture->add_columns(
      file, {x.label + ", then of " + statistic.label() + ": median, quantiles 5, 25, 75, 95 %"}, arrays);
}

// What varies besides the first axis, in words, for the lines of a picture.
std::string line_name(const SweepReport& report, const SweepRow& row, std::size_t x) {
  std::string name;
  for (std::size_t k = 0; k < report.axes.size() - (report.has_seeds ? 1 : 0); ++k)
    if (k != x) name += (name.empty() ? "" : ", ") + last_key(report.axes[k].pointer) + " " + row.typed[k];
  return name;
}

struct SweptLine {
  std::string name;
  std::vector<const SweepRow*> rows;
};
std::vector<SweptLine> lines_of(const SweepReport& report, std::size_t x) {
  std::vector<SweptLine> lines;
  for (const SweepRow& row : report.rows) {
    const std::string name = line_name(report, row, x);
    auto at =
        std::find_if(lines.begin(), lines.end(), [&](const SweptLine& line) { return line.name == name; });
    if (at == lines.end()) {
      if (lines.size() == kMostLines) return {};
      at = lines.insert(at, SweptLine{name, {}});
    }
    at->rows.push_back(&row);
  }
  return lines;
}

std::vector<const SweepRow*> all_rows(const SweepReport& report) {
  std::vector<const SweepRow*> rows;
  for (const SweepRow& row : report.rows) rows.push_back(&row);
  return rows;
}

std::string head_of_curve(const SweepReport& report, const SweptAxis& x, const SweptStatistic& statistic,
                          const std::string& name) {
  std::string text = script_head(name, 1000, 700);
  text += fmt::format("set title {}\n{}set ylabel {}\n", picture_title(statistic.name, report.title),
                      x.script("x"), gnuplot_text(statistic.label()));
  if (statistic.is_log) text += log_axis("y", statistic.smallest, statistic.largest);
  return text;
}

Picture curve_picture(const SweepReport& report, const SweptAxis& x, const SweptStatistic& statistic) {
  Picture picture{"curve_" + statistic.file, "", {}};
  picture.script = head_of_curve(report, x, statistic, picture.name);
  if (!report.is_grid) {
    std::vector<double> at, values;
    for (const SweepRow& row : report.rows) at.push_back(x.at(row)), values.push_back(statistic.at(row));
    picture.add_columns(picture.name + ".dat", {x.label + ", " + statistic.label()},
                        {array_of(at), array_of(values)});
    picture.script += fmt::format(
        "plot '{}.dat' using 1:2 with points pointtype 7 pointsize 0.5 linecolor rgb '{}' title 'cases'\n",
        picture.name, kLineColours[0]);
    return picture;
  }
  std::vector<SweptLine> lines = lines_of(report, x.place);
  const bool together = lines.empty();  // too many
  if (together) lines = {{"median of all else that varies", all_rows(report)}};
  const bool bands = together || (report.has_seeds && lines.size() <= kMostLinesWithBands);
  std::string curves;
  const auto add = [&](const std::string& curve) { curves += (curves.empty() ? "" : kNextCurve) + curve; };
  for (std::size_t k = 0; k < lines.size(); ++k) {
    const std::string file = fmt::format("{}_{}.dat", picture.name, k + 1);
    add_curve(grouped_values(lines[k].rows, x, statistic), file, x, statistic, &picture);
    if (bands)
      for (const auto& [columns, opacity, title] :
           {std::tuple{"3:6", 0.15, "5 to 95 %"}, {"4:5", 0.3, "25 to 75 %"}})
        add(
            fmt::format("'{}' using 1:{} with filledcurves fillcolor rgb '{}' fillstyle transparent solid {} "
                        "noborder {}",
                        file, columns, kLineColours[k], opacity,
                        lines.size() == 1 ? fmt::format("title '{}'", title) : "notitle"));
  }
  for (std::size_t k = 0; k < lines.size(); ++k) {
    const std::string file = fmt::format("{}_{}.dat", picture.name, k + 1);
    const std::string title = lines[k].name.empty() ? report.has_seeds ? "median" : "" : lines[k].name;
    add(fmt::format(
        "'{}' using 1:2 with {} linecolor rgb '{}' linewidth 2.5 dashtype 1 pointtype 7 pointsize 0.7 {}",
        file, grouped_values(lines[k].rows, x, statistic).size() > kMostMarks ? "lines" : "linespoints",
        kLineColours[k], title.empty() ? "notitle" : "title " + gnuplot_text(title)));
  }
  picture.script += "plot " + curves + "\n";
  return picture;
}

// Where the cells of neighbouring numbers meet, the outer ones as wide as their inner half.
std::vector<double> cell_edges(const std::vector<double>& centres, bool is_log) {
  std::vector<double> at;
  for (const double centre : centres) at.push_back(is_log ? std::log(centre) : centre);
  std::vector<double> edges;
  for (std::size_t k = 0; k + 1 < at.size(); ++k) edges.push_back(0.5 * (at[k] + at[k + 1]));
  edges.insert(edges.begin(), at.size() > 1 ? 2 * at.front() - edges.front() : at.front() - 0.5);
  edges.push_back(at.size() > 1 ? 2 * at.back() - edges.back() : at.front() + 0.5);
  if (is_log)
    for (double& edge : edges) edge = std::exp(edge);
  return edges;
}

// Median of a statistic on a grid of two axes.
struct SweptPlane {
  std::vector<double> x, y;
  std::map<std::pair<double, double>, std::vector<double>> values;
  double median(double at_x, double at_y) const {
    const auto found = values.find({at_x, at_y});
    return found == values.end() ? kNaN : quantiles_of(found->second).q50;
  }
};
SweptPlane plane_of(const SweepReport& report, const SweptAxis& x, const SweptAxis& y,
                    const SweptStatistic& statistic) {
  SweptPlane plane;
  const auto add = [](double value, std::vector<double>* to) {
    const auto at = std::lower_bound(to->begin(), to->end(), value);
    if (at == to->end() || *at != value) to->insert(at, value);
  };
  for (const SweepRow& row : report.rows) {
    const double at_x = x.at(row), at_y = y.at(row);
    if (!std::isfinite(at_x) || !std::isfinite(at_y)) continue;
    add(at_x, &plane.x), add(at_y, &plane.y);
    plane.values[{at_x, at_y}].push_back(statistic.at(row));
  }
  return plane;
}

std::string head_of_plane(const SweepReport& report, const SweptAxis& x, const SweptAxis& y,
                          const SweptStatistic& statistic, const std::string& name) {
  const bool medians = report.axes.size() > 2 && report.is_grid;
  std::string text = script_head(name, 1000, 750);
  text += fmt::format(
      "set title {}\n{}{}set cblabel {} offset 1.5\nset palette defined (0 '#fde725', 0.25 '#5ec962', 0.5 "
      "'#21918c', "
      "0.75 '#3b528b', 1 '#440154')\n",
      picture_title(statistic.name + (medians ? ", median of all else" : ""), report.title), x.script("x"),
      y.script("y"), gnuplot_text(statistic.label()));
  if (statistic.is_log)
    text += fmt::format("set logscale cb\nset format cb '%g'\nset cbtics {}\n",
                        log_tics(statistic.smallest, statistic.largest));
  return text;
}

Picture map_picture(const SweepReport& report, const SweptAxis& x, const SweptAxis& y,
                    const SweptStatistic& statistic) {
  Picture picture{"map_" + statistic.file, "", {}};
  picture.script = head_of_plane(report, x, y, statistic, picture.name);
  const std::string file = picture.name + ".dat";
  std::vector<std::vector<double>> columns(7);
  const auto add = [&](std::initializer_list<double> row) {
    std::size_t k = 0;
    for (const double value : row) columns[k++].push_back(value);
  };
  if (report.is_grid) {
    const SweptPlane plane = plane_of(report, x, y, statistic);
    const std::vector<double> ex = cell_edges(plane.x, x.is_log), ey = cell_edges(plane.y, y.is_log);
    for (std::size_t j = 0; j < plane.y.size(); ++j)
      for (std::size_t i = 0; i < plane.x.size(); ++i)
        if (const double value = plane.median(plane.x[i], plane.y[j]); std::isfinite(value))
          add({plane.x[i], plane.y[j], ex[i], ex[i + 1], ey[j], ey[j + 1], value});
    picture.script += fmt::format(
        "set xrange [{:.9g}:{:.9g}]\nset yrange [{:.9g}:{:.9g}]\nset grid front\nset style fill solid "
        "noborder\n"
        "plot '{}' using 1:2:3:4:5:6:7 with boxxyerror linecolor palette notitle\n",
        ex.front(), ex.back(), ey.front(), ey.back(), file);
  } else {
    for (const SweepRow& row : report.rows)
      if (const double value = statistic.at(row); std::isfinite(value))
        add({x.at(row), y.at(row), 0, 0, 0, 0, value});
    picture.script += fmt::format(
        "plot '{}' using 1:2:7 with points pointtype 7 pointsize 1.2 linecolor palette notitle\n", file);
  }
  std::vector<Eigen::ArrayXd> arrays;
  for (const std::vector<double>& column : columns) arrays.push_back(array_of(column));
  picture.add_columns(file, {x.label + ", " + y.label + ", ends of the cell in both, " + statistic.label()},
                      arrays);
  return picture;
}

// Levels at round numbers: 1, 2, 5 times powers of ten where the values span decades, else even steps.
std::vector<double> contour_levels(const SweptStatistic& statistic) {
  std::vector<double> levels;
  const double low = statistic.smallest, high = statistic.largest;
  constexpr double kApart =
      1e-9;  // less is rounding: nothing to draw a line between, and steps that add nothing
  if (!(high - low > kApart * std::max(std::abs(low), std::abs(high)))) return levels;
  if (statistic.is_log) {
    for (int power = int(std::floor(std::log10(low))); power <= int(std::ceil(std::log10(high))); ++power)
      for (const double digit : {1.0, 2.0, 5.0})
        if (const double level = digit * std::pow(10.0, power); level > low && level < high)
          levels.push_back(level);
    return levels;
  }
  constexpr double kSteps = 8;
  const double rough = (high - low) / kSteps, unit = std::pow(10.0, std::floor(std::log10(rough)));
  const double step = unit * (rough / unit < 1.5 ? 1 : rough / unit < 3.5 ? 2 : rough / unit < 7.5 ? 5 : 10);
  const double first = std::ceil(low / step);
  for (int k = 0; k <= 2 * int(kSteps); ++k)
    if (const double level = (first + k) * step; level > low && level < high) levels.push_back(level);
  return levels;
}

// Lines of equal value with their numbers on them. Nothing where there is no level between the values.
Picture contour_lines_picture(const SweepReport& report, const SweptAxis& x, const SweptAxis& y,
                              const SweptStatistic& statistic) {
  const SweptPlane plane = plane_of(report, x, y, statistic);
  const std::vector<double> levels = contour_levels(statistic);
  if (plane.x.size() < 2 || plane.y.size() < 2 || levels.empty()) return {};
  Picture picture{"contour_" + statistic.file, "", {}};
  const std::string file = picture.name + ".dat";
  std::string data =
      fmt::format("# {}, {}, {}; a block for each {}\n", x.label, y.label, statistic.label(), y.label);
  for (const double at_y : plane.y) {
    for (const double at_x : plane.x)
      fmt::format_to(std::back_inserter(data), "{:.9g} {:.9g} {:.9g}\n", at_x, at_y,
                     plane.median(at_x, at_y));
    data += "\n";
  }
  picture.data.emplace_back(file, data);
  std::string list;
  for (const double level : levels) list += fmt::format("{}{:.9g}", list.empty() ? "" : ", ", level);
  picture.script = head_of_plane(report, x, y, statistic, picture.name);
  picture.script += fmt::format(
      "set title {}\nset xrange [{:.9g}:{:.9g}]\nset yrange [{:.9g}:{:.9g}]\nunset key\nunset colorbox\n"
      "set view map\nset contour base\nunset surface\nset cntrparam linear\nset cntrparam levels discrete "
      "{}\n"
      "set cntrlabel onecolor format '%g' font ',12' start 3 interval 1000\nset style textbox opaque "
      "noborder margins 0.6,0.4\n"
      "splot '{}' using 1:2:3 with lines linecolor rgb '{}' linewidth 2 dashtype 1, \\\n"
      "  '' using 1:2:3 with labels boxed\n",
      picture_title(statistic.label(), report.title), plane.x.front(), plane.x.back(), plane.y.front(),
      plane.y.back(), list, file, kTargetColour);
  return picture;
}

}  // namespace

std::vector<std::string> write_sweep_plots(const SweepReport& report, const std::string& directory,
                                           Warnings* warnings) {
  const std::size_t places = report.axes.size() - (report.has_seeds ? 1 : 0);
  std::vector<std::size_t> order;  // axes with numbers first
  for (const bool numeric : {true, false})
    for (std::size_t k = 0; k < places; ++k)
      if (report.axes[k].is_numeric == numeric) order.push_back(k);
  std::vector<Picture> pictures;
  for (const std::string& name : report.shown) {
    const SweptStatistic statistic = swept_statistic(report, name);
    if (order.empty() || !std::isfinite(statistic.smallest)) continue;
    const SweptAxis x = axis_of(report, order[0]);
    pictures.push_back(curve_picture(report, x, statistic));
    if (order.size() < 2 || !report.axes[order[1]].is_numeric) continue;
    const SweptAxis y = axis_of(report, order[1]);
    pictures.push_back(map_picture(report, x, y, statistic));
    if (!report.is_grid) continue;
    if (Picture lines = contour_lines_picture(report, x, y, statistic); !lines.name.empty())
      pictures.push_back(std::move(lines));
  }
  if (pictures.empty()) return {};
  return draw_pictures(pictures, directory, warnings);
}

}  // namespace aberfit
