#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "aberfit/report/chart.h"
#include "label_places.h"
#include "picture.h"

namespace aberfit {
using namespace internal;

namespace {

constexpr int kWidth = 1200, kHeight = 850;                                  // [pixels]
constexpr double kLeft = 0.085, kRight = 0.975, kLow = 0.09, kHigh = 0.835;  // frame, of the picture
constexpr double kMark = 6;                                                  // half a point [pixels]
constexpr const char* kColours[] = {"#0072B2", "#D55E00", "#009E73", "#CC79A7",
                                    "#E69F00", "#56B4E9", "#000000"};
constexpr int kMarks[] = {7, 5, 9, 11, 13, 7, 5};  // gnuplot's filled marks
constexpr double kSmallest = 1e-17;                // errors of 0 have no place on a logarithmic axis

std::string thousands(double count) {
  if (count >= 999500) return fmt::format("{:.3g}M", count / 1048576);
  if (count >= 1000)
    return std::fmod(count, 1024) == 0 ? fmt::format("{:.0f}k", count / 1024)
                                       : fmt::format("{:.3g}k", count / 1000);
  return fmt::format("{:g}", count);
}

std::string short_label(const ChartRow& row) {
  if (!std::isfinite(row.value)) return row.method;
  if (row.parameter == "rays") return thousands(row.value);
  if (row.unit == "/m") return fmt::format("{:.3g} /m", row.value);
  return fmt::format("{:g}", row.value);
}

// `set xtics` of seconds at the powers of ten (the axis holds one) with the prefix in the label, and small
// ones between. gnuplot's own prefixes know no micro sign.
std::string decade_tics(double low, double high) {
  static const char* const kPrefixes[] = {"p", "n", "µ", "m", "", "k", "M"};
  std::string tics;
  const int first = int(std::ceil(std::log10(low) - 1e-9)), last = int(std::floor(std::log10(high) + 1e-9));
  for (int e = first; e <= last; ++e) {
    const int group = std::clamp((e + 300) / 3 - 100, -4, 2);
    tics += fmt::format("{}'{:g} {}s' 1e{}", tics.empty() ? "" : ", ", std::pow(10.0, e - 3 * group),
                        kPrefixes[group + 4], e);
    for (int k = 2; k < 10; ++k) tics += fmt::format(", '' {}e{} 1", k, e);
  }
  for (int k = 2; k < 10; ++k) tics += fmt::format("{}'' {}e{} 1", tics.empty() ? "" : ", ", k, first - 1);
  return "set xtics (" + tics + ")\n";
}

bool is_shown(const ChartRow& row) { return std::isfinite(row.error) && row.seconds > 0; }

// Lower and upper end of a logarithmic axis, with room at both ends.
struct LogAxis {
  double low = std::numeric_limits<double>::infinity(), high = 0;
  void hold(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  void widen(double share, double least_factor) {
    const double factor = std::max(least_factor, std::pow(high / low, share));
    low /= factor;
    high *= factor;
  }
  double part(double value) const { return std::log(value / low) / std::log(high / low); }
};

class FamilyPicture {
 public:
  explicit FamilyPicture(const ChartFamily& family) : family_(family) {
    for (const ChartRow& row : family.rows) {
      if (!is_shown(row)) continue;
      x_.hold(row.seconds_low);
      x_.hold(row.seconds_high);
      if (row.error > 0) y_.hold(std::max(row.error, kSmallest));
      has_zero_ = has_zero_ || row.error == 0;
      if (std::find(methods_.begin(), methods_.end(), row.method) == methods_.end())
        methods_.push_back(row.method);
    }
    if (y_.high == 0) y_.hold(kSmallest);
    if (family.tolerance > 0) y_.hold(family.tolerance);
    if (has_zero_) y_.hold(y_.low / 10);
    x_.widen(0.08, 1.5);
    x_.widen(0, std::sqrt(std::max(1.0, 12 * x_.low / x_.high)));  // so that it holds a power of ten
    y_.widen(0.07, 1.6);
  }
  bool empty() const { return methods_.empty(); }

  Picture picture(const std::string& study_title) {
    const std::string name = "chart_" + file_name();
    Picture picture{name, script_head(name, kWidth, kHeight), {}};
    std::string plots = frontier_plot(name);
    for (std::size_t m = 0; m < methods_.size(); ++m) plots += method_plot(name, m);
    plots += marked_plot(name, &ChartRow::is_default, "today", 6, "#000000", 3.4);
    plots += marked_plot(name, &ChartRow::is_cheapest_within_tolerance, "cheapest within tolerance", 12,
                         "#AA0000", 4.4);
    picture.script += fmt::format(
        "set termoption enhanced\n"
        "set lmargin at screen {}\nset rmargin at screen {}\nset bmargin at screen {}\nset tmargin at screen "
        "{}\n"
        "set label {} noenhanced at screen 0.53, screen 0.972 center\n"
        "set key at screen 0.53, screen 0.95 center top horizontal noenhanced font ',12' spacing 1.0 samplen "
        "2\n"
        "set logscale xy\nset xrange [{:.9g}:{:.9g}]\nset yrange [{:.9g}:{:.9g}]\n"
        "{}set format y '10^{{%L}}'\n"
        "set xlabel {} noenhanced\nset ylabel {} noenhanced offset 0.5,0\n"
        "set grid xtics ytics\n{}{}plot {}\n",
        kLeft, kRight, kLow, kHigh, picture_title(family_.title, study_title), x_.low, x_.high, y_.low,
        y_.high, decade_tics(x_.low, x_.high), gnuplot_text("time of " + family_.timed),
        gnuplot_text(family_.error_of + (has_zero_ ? " (0 at the lower edge)" : "")), tolerance_mark(),
        labels(), plots.substr(0, plots.size() - std::string(", \\\n").size()));
    picture.data.emplace_back(name + ".dat", data_);
    return picture;
  }

 private:
  std::string file_name() const {
    std::string name = family_.name;
    std::replace(name.begin(), name.end(), '-', '_');
    return name;
  }
  double shown_error(const ChartRow& row) const {
    return row.error > 0 ? std::max(row.error, kSmallest) : y_.low * 1.3;
  }
  double pixel_x(double seconds) const { return x_.part(seconds) * kWidth * (kRight - kLeft); }
  double pixel_y(double error) const { return y_.part(error) * kHeight * (kHigh - kLow); }

  // A block of the data file; returns its number.
  int add_block(const std::string& what, const std::vector<const ChartRow*>& rows) {
    data_ += fmt::format("{}# {}\n# median, lower and upper quartile of the time [s], error\n",
                         blocks_ == 0 ? "" : "\n\n", what);
    for (const ChartRow* row : rows)
      data_ += fmt::format("{:.9g} {:.9g} {:.9g} {:.9g}\n", row->seconds, row->seconds_low, row->seconds_high,
                           shown_error(*row));
    return blocks_++;
  }
  std::vector<const ChartRow*> shown(const std::function<bool(const ChartRow&)>& wanted) const {
    std::vector<const ChartRow*> rows;
    for (const ChartRow& row : family_.rows)
      if (is_shown(row) && wanted(row)) rows.push_back(&row);
    return rows;
  }
  std::string frontier_plot(const std::string& name) {
    std::vector<const ChartRow*> rows = shown([](const ChartRow& row) { return row.on_frontier; });
    if (rows.empty()) return "";
    std::sort(rows.begin(), rows.end(), [](const ChartRow* a, const ChartRow* b) {
      return a->seconds < b->seconds || (a->seconds == b->seconds && a->error > b->error);
    });
    for (std::size_t i = 0; i + 1 < rows.size(); ++i) {  // where the stairs will be
      const double x = pixel_x(rows[i]->seconds), next = pixel_x(rows[i + 1]->seconds);
      const double y = pixel_y(shown_error(*rows[i])), down = pixel_y(shown_error(*rows[i + 1]));
      places_.block({x, next, y - 4, y + 4}, true);
      places_.block({next - 4, next + 4, down, y}, true);
    }
    return fmt::format(
        "'{}.dat' index {} using 1:4 with steps linecolor rgb '#d4d4d4' linewidth 5 dashtype 1 title "
        "'nothing measured is better'{}",
        name, add_block("frontier", rows), kNextCurve);
  }
  std::string method_plot(const std::string& name, std::size_t m) {
    const int block =
        add_block(methods_[m], shown([&](const ChartRow& row) { return row.method == methods_[m]; }));
    const std::size_t style = m % std::size(kColours);
    return fmt::format(
        "'{0}.dat' index {1} using 1:4:2:3 with xerrorbars pointtype {2} pointsize 1.3 linewidth 1.2 "
        "dashtype 1 linecolor rgb '{3}' title {4}{5}",
        name, block, kMarks[style], kColours[style], gnuplot_text(methods_[m]), kNextCurve);
  }
  std::string marked_plot(const std::string& name, bool ChartRow::*flag, const std::string& title, int point,
                          const std::string& colour, double size) {
    const std::vector<const ChartRow*> rows = shown([flag](const ChartRow& row) { return row.*flag; });
    if (rows.empty()) return "";
    return fmt::format(
        "'{}.dat' index {} using 1:4 with points pointtype {} pointsize {} linewidth 2 linecolor rgb '{}' "
        "title '{}'{}",
        name, add_block(title, rows), point, size, colour, title, kNextCurve);
  }
  std::string tolerance_mark() {
    if (!(family_.tolerance > 0)) return "";
    const std::string text = fmt::format("{}: {:.3g}", family_.tolerance_of, family_.tolerance);
    // On the side where no point is in the way.
    const double y = pixel_y(family_.tolerance), width = 8.0 * double(text.size());
    const double right = kWidth * (kRight - kLeft);
    const bool on_right = std::any_of(family_.rows.begin(), family_.rows.end(), [&](const ChartRow& row) {
      const double above = is_shown(row) ? pixel_y(shown_error(row)) - y : -1;
      return above > -kMark && above < 22 + kMark && pixel_x(row.seconds_low) < width + kMark;
    });
    places_.block({on_right ? right - width : 0, on_right ? right : width, y, y + 22});
    places_.block({0, kWidth, y - 2, y + 2});
    return fmt::format(
        "set arrow from graph 0, first {0:.9g} to graph 1, first {0:.9g} nohead linecolor rgb '#AA0000' "
        "dashtype 2\n"
        "set label {1} noenhanced at graph {2}, first {0:.9g} {3} offset 0,0.6 textcolor rgb '#AA0000' font "
        "',11'\n",
        family_.tolerance, gnuplot_text(text), on_right ? 0.992 : 0.008, on_right ? "right" : "left");
  }
  std::string labels() {
    std::vector<const ChartRow*> rows = shown([](const ChartRow&) { return true; });
    for (const ChartRow* row : rows) {
      const double x = pixel_x(row->seconds), y = pixel_y(shown_error(*row));
      const double mark = row->is_default || row->is_cheapest_within_tolerance ? 2 * kMark : kMark;
      places_.block({x - mark, x + mark, y - mark, y + mark});
      places_.block({pixel_x(row->seconds_low), pixel_x(row->seconds_high), y - 3, y + 3});
    }
    const auto rank = [](const ChartRow* row) {
      return row->is_default || row->is_cheapest_within_tolerance ? 0 : row->on_frontier ? 1 : 2;
    };
    std::stable_sort(rows.begin(), rows.end(),
                     [&](const ChartRow* a, const ChartRow* b) { return rank(a) < rank(b); });
    std::string text;
    for (const ChartRow* row : rows) {
      const std::string label = short_label(*row);
      const auto place = places_.put(pixel_x(row->seconds), pixel_y(shown_error(*row)),
                                     rank(row) == 0 ? 2.4 * kMark : kMark + 2, label);
      if (!place) continue;
      const std::size_t m =
          std::size_t(std::find(methods_.begin(), methods_.end(), row->method) - methods_.begin());
      text += fmt::format(
          "set label {} noenhanced at graph {:.5f}, graph {:.5f} center textcolor rgb '{}' font ',11'\n",
          gnuplot_text(label), place->x / (kWidth * (kRight - kLeft)), place->y / (kHeight * (kHigh - kLow)),
          kColours[m % std::size(kColours)]);
    }
    return text;
  }

  const ChartFamily& family_;
  std::vector<std::string> methods_;
  LogAxis x_, y_;
  bool has_zero_ = false;
  std::string data_;
  int blocks_ = 0;
  LabelPlaces places_{kWidth * (kRight - kLeft), kHeight*(kHigh - kLow)};
};

}  // namespace

std::vector<std::string> write_chart_plots(const Chart& chart, const std::string& directory,
                                           Warnings* warnings) {
  std::vector<Picture> pictures;
  for (const ChartFamily& family : chart.families) {
    FamilyPicture maker(family);
    if (!maker.empty()) pictures.push_back(maker.picture(chart.title));
  }
  return draw_pictures(pictures, directory, warnings);
}

}  // namespace aberfit
