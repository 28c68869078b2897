#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <iterator>
#include <map>
#include <optional>

#include "aberfit/core/constants.h"
#include "aberfit/report/sweep_report.h"
#include "label_places.h"
#include "picture.h"

namespace aberfit {
using namespace internal;

namespace {

constexpr std::size_t kMostLines = 7, kMostLinesWithBands = 3;
constexpr double kLogFromRatio = 20;  // largest over smallest value, for a logarithmic axis
constexpr std::size_t kMostMarks = 60;

// Leaves a little room at the ends.
std::string roomy_log_axis(const std::string& axis, double low, double high) {
  constexpr double kRoom = 1.08;
  return log_axis(axis, low / kRoom, high * kRoom);
}

// An axis of a picture. Words are at 0, 1, ... in their order.
struct SweptAxis {
  std::size_t place = 0;
  std::vector<std::string> words;  // for an axis without numbers
  std::string label;
  bool is_log = false;
  double low = kNaN, high = kNaN;  // range of a logarithmic axis

  double at(const SweepRow& row) const {
    if (words.empty()) return row.number[place];
    return double(std::find(words.begin(), words.end(), row.typed[place]) - words.begin());
  }
  // Sets `axis`_label, and the gnuplot commands `axis`_axis.
  void set(const std::string& axis, Picture* picture) const {
    picture->set(axis + "_label", label);
    std::string tics;
    for (std::size_t k = 0; k < words.size(); ++k)
      tics += fmt::format("{}{} {}", k ? ", " : "", gnuplot_text(words[k]), k);
    picture->set(axis + "_axis", is_log         ? roomy_log_axis(axis, low, high)
                                 : tics.empty() ? std::string()
                                                : fmt::format("set {}tics ({})", axis, tics));
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

// A statistic to draw, in a suitable unit.
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

// Values by a number of their rows, ascending.
using Groups = std::map<double, std::vector<double>>;
Groups grouped_values(const std::vector<const SweepRow*>& rows, const SweptAxis& x,
                      const SweptStatistic& statistic) {
  Groups groups;
  for (const SweepRow* row : rows) groups[x.at(*row)].push_back(statistic.at(*row));
  return groups;
}

// Columns: x, then the quantiles of bands and line.
PictureColumns quantile_curve(const Groups& groups) {
  std::vector<std::vector<double>> columns(6);
  for (const auto& [at, values] : groups) {
    const SweepQuantiles q = quantiles_of(values);
    if (q.count == 0) continue;
    for (const auto& [k, value] :
         {std::pair{0, at}, {1, q.q50}, {2, q.q05}, {3, q.q25}, {4, q.q75}, {5, q.q95}})
      columns[std::size_t(k)].push_back(value);
  }
  PictureColumns arrays;
  for (const std::vector<double>& column : columns) arrays.push_back(array_of(column));
  return arrays;
}

// Name of a line in a picture: the values of the axes other than x.
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

Picture curve_picture(const SweepReport& report, const SweptAxis& x, const SweptStatistic& statistic) {
  constexpr std::size_t kManyPoints = 1500;
  Picture picture("curve_" + statistic.file, report.title, "sweep_curve");
  picture.title = statistic.name + " over " + x.label;
  picture.set("statistic", statistic.name);
  picture.set("y_label", statistic.label());
  picture.set("y_axis",
              statistic.is_log ? roomy_log_axis("y", statistic.smallest, statistic.largest) : std::string());
  x.set("x", &picture);
  if (!report.is_grid) {
    std::vector<double> at, values;
    for (const SweepRow& row : report.rows) at.push_back(x.at(row)), values.push_back(statistic.at(row));
    picture.add_columns(picture.name + ".dat", {x.label + ", " + statistic.label()},
                        {array_of(at), array_of(values)});
    picture.set("lines", 0);
    picture.has_cloud = at.size() > kManyPoints;
    return picture;
  }
  std::vector<SweptLine> lines = lines_of(report, x.place);
  const bool together = lines.empty();  // too many
  if (together) lines = {{"median over the other values", all_rows(report)}};
  const bool bands = together || (report.has_seeds && lines.size() <= kMostLinesWithBands);
  std::vector<PictureColumns> curves;
  std::vector<std::string> labels;
  for (const SweptLine& line : lines) {
    curves.push_back(quantile_curve(grouped_values(line.rows, x, statistic)));
    labels.push_back(line.name.empty() && report.has_seeds ? "median" : line.name);
  }
  picture.add_blocks(picture.name + ".dat",
                     {x.label + ", then of " + statistic.label() +
                      ": median, quantiles 5, 25, 75, 95 %; one block per line"},
                     curves);
  picture.set("lines", int(lines.size()));
  picture.set("bands", bands ? int(lines.size()) : 0);
  picture.set("label", labels);
  picture.set("mark", std::size_t(curves[0][0].size()) > kMostMarks ? 0.0 : 0.7);
  return picture;
}

// Edges between the cells of neighbouring numbers. The outer halves of the end cells equal the inner ones.
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

Picture plane_picture(const SweepReport& report, const SweptAxis& x, const SweptAxis& y,
                      const SweptStatistic& statistic, const std::string& kind) {
  const bool medians = report.axes.size() > 2 && report.is_grid;
  Picture picture(kind + "_" + statistic.file, report.title, "sweep_" + kind);
  picture.title = statistic.name + " over " + x.label + " and " + y.label;
  picture.set("statistic", statistic.name + (medians ? ", median over the other values" : ""));
  picture.set("value_label", statistic.label());
  x.set("x", &picture);
  y.set("y", &picture);
  return picture;
}

void set_ranges(const std::vector<double>& x, const std::vector<double>& y, Picture* picture) {
  picture->set("x_low", x.front()), picture->set("x_high", x.back());
  picture->set("y_low", y.front()), picture->set("y_high", y.back());
}

Picture map_picture(const SweepReport& report, const SweptAxis& x, const SweptAxis& y,
                    const SweptStatistic& statistic) {
  Picture picture = plane_picture(report, x, y, statistic, "map");
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
    set_ranges(ex, ey, &picture);
  } else {
    for (const SweepRow& row : report.rows)
      if (const double value = statistic.at(row); std::isfinite(value))
        add({x.at(row), y.at(row), 0, 0, 0, 0, value});
  }
  PictureColumns arrays;
  for (const std::vector<double>& column : columns) arrays.push_back(array_of(column));
  picture.add_columns(picture.name + ".dat",
                      {x.label + ", " + y.label + ", ends of the cell along both, " + statistic.label()},
                      arrays);
  picture.set("cells", int(report.is_grid));
  picture.set("value_axis",
              statistic.is_log ? log_axis("cb", statistic.smallest, statistic.largest) : std::string());
  return picture;
}

// Levels at round numbers: 1, 2, 5 times powers of ten for a logarithmic statistic, else even steps.
std::vector<double> contour_levels(const SweptStatistic& statistic) {
  std::vector<double> levels;
  const double low = statistic.smallest, high = statistic.largest;
  constexpr double kApart = 1e-9;  // smaller differences are rounding errors and have no levels
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

// A point between grid neighbours where the statistic has a given value; part_x, part_y: fractions of the
// frame.
struct Crossing {
  double x, y, part_x, part_y;
};
std::vector<Crossing> crossings(const SweptPlane& plane, const SweptAxis& x, const SweptAxis& y,
                                double level) {
  const auto part = [](double at, const std::vector<double>& all, bool is_log) {
    const auto scale = [&](double value) { return is_log ? std::log(value) : value; };
    return (scale(at) - scale(all.front())) / (scale(all.back()) - scale(all.front()));
  };
  std::vector<Crossing> found;
  for (const double at_y : plane.y)
    for (std::size_t i = 0; i + 1 < plane.x.size(); ++i) {
      const double a = plane.median(plane.x[i], at_y) - level, b = plane.median(plane.x[i + 1], at_y) - level;
      if (!(a * b < 0)) continue;
      const double at_x = plane.x[i] + a / (a - b) * (plane.x[i + 1] - plane.x[i]);
      found.push_back({at_x, at_y, part(at_x, plane.x, x.is_log), part(at_y, plane.y, y.is_log)});
    }
  return found;
}

// Puts a label on each contour line, near the middle of the frame, clear of other labels.
std::string level_labels(const SweptPlane& plane, const SweptAxis& x, const SweptAxis& y,
                         const std::vector<double>& levels) {
  constexpr double kFrameWidth = 850, kFrameHeight = 600;  // frame [pixels]
  constexpr double kCharacter = 10, kLine = 24;            // label [pixels]
  std::string rows;
  std::vector<PixelBox> taken;
  for (const double level : levels) {
    const std::string text = fmt::format("{:.6g}", level);
    std::vector<Crossing> places = crossings(plane, x, y, level);
    std::stable_sort(places.begin(), places.end(), [](const Crossing& a, const Crossing& b) {
      return std::hypot(a.part_x - 0.5, a.part_y - 0.5) < std::hypot(b.part_x - 0.5, b.part_y - 0.5);
    });
    for (const Crossing& place : places) {
      const double half = 0.5 * kCharacter * double(text.size() + 1);
      const PixelBox box{kFrameWidth * place.part_x - half, kFrameWidth * place.part_x + half,
                         kFrameHeight * place.part_y - 0.5 * kLine,
                         kFrameHeight * place.part_y + 0.5 * kLine};
      if (box.left < 0 || box.right > kFrameWidth || box.low < 0 || box.high > kFrameHeight) continue;
      if (std::any_of(taken.begin(), taken.end(), [&](const PixelBox& other) { return other.overlaps(box); }))
        continue;
      taken.push_back(box);
      rows += fmt::format("{:.9g} {:.9g} {}\n", place.x, place.y, text);
      break;
    }
  }
  return rows;
}

// Returns nothing if no level is between the values.
std::optional<Picture> contour_lines_picture(const SweepReport& report, const SweptAxis& x,
                                             const SweptAxis& y, const SweptStatistic& statistic) {
  const SweptPlane plane = plane_of(report, x, y, statistic);
  const std::vector<double> levels = contour_levels(statistic);
  if (plane.x.size() < 2 || plane.y.size() < 2 || levels.empty()) return std::nullopt;
  Picture picture = plane_picture(report, x, y, statistic, "contour");
  std::string data =
      fmt::format("# {}, {}, {}; a block for each {}\n", x.label, y.label, statistic.label(), y.label);
  for (const double at_y : plane.y) {
    for (const double at_x : plane.x)
      fmt::format_to(std::back_inserter(data), "{:.9g} {:.9g} {:.9g}\n", at_x, at_y,
                     plane.median(at_x, at_y));
    data += "\n";
  }
  picture.data.emplace_back(picture.name + ".dat", data);
  const std::string labels = level_labels(plane, x, y, levels);
  if (!labels.empty())
    picture.data.emplace_back(picture.name + "_labels.dat", fmt::format("# {}, {}, level of {}\n{}", x.label,
                                                                        y.label, statistic.label(), labels));
  picture.set("labels", int(!labels.empty()));
  picture.set("levels", fmt::format("{:.9g}", fmt::join(levels, ", ")));
  set_ranges(plane.x, plane.y, &picture);
  return picture;
}

}  // namespace

std::vector<DrawnPicture> draw_pictures(const SweepReport& report, const std::string& directory,
                                        const PictureOptions& options, Warnings* warnings) {
  if (options.format == PictureFormat::kNone) return {};
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
    if (std::optional<Picture> lines = contour_lines_picture(report, x, y, statistic))
      pictures.push_back(std::move(*lines));
  }
  return draw(pictures, directory, options, warnings);
}

}  // namespace aberfit
