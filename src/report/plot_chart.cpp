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

constexpr int kWidth = 1200, kHeight = 850;  // [pixels]
constexpr double kLeft = 0.085, kRight = 0.975, kLow = 0.09,
                 kHigh = 0.835;  // frame [picture]
constexpr double kMark = 6;      // half size of a point [pixels]
constexpr std::size_t kColours = 7;
constexpr double kSmallest = 1e-17;  // errors of 0 have no place on a logarithmic axis

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

// gnuplot tics of seconds: labels with prefix at the powers of ten, of which the axis has at least one, and
// small tics between. gnuplot's own prefixes have no micro sign.
std::string decade_tics(double low, double high) {
  static const char* const kPrefixes[] = {"p", "n", "µ", "m", "", "k", "M"};
  std::string tics;
  const int first = int(std::ceil(std::log10(low) - 1e-9)), last = int(std::floor(std::log10(high) + 1e-9));
  for (int e = first - 1; e <= last; ++e) {
    const int group = std::clamp((e + 300) / 3 - 100, -4, 2);
    if (e >= first)
      tics += fmt::format("\"{:g} {}s\" 1e{}, ", std::pow(10.0, e - 3 * group), kPrefixes[group + 4], e);
    for (int k = 2; k < 10; ++k) tics += fmt::format("\"\" {}e{} 1, ", k, e);
  }
  return "(" + tics.substr(0, tics.size() - 2) + ")";
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
  double at(double share) const { return low * std::pow(high / low, share); }
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
    x_.widen(0, std::sqrt(std::max(1.0, 12 * x_.low / x_.high)));  // so that it contains a power of ten
    y_.widen(0.07, 1.6);
  }
  bool empty() const { return methods_.empty(); }

  Picture picture(const std::string& study_title) {
    Picture picture("chart_" + file_name(), study_title, "chart");
    picture.title = family_.title;
    add_frontier(&picture);
    std::vector<PictureColumns> blocks;
    for (const std::string& method : methods_)
      blocks.push_back(columns(shown([&](const ChartRow& row) { return row.method == method; })));
    add(&picture, "methods", blocks);
    for (const auto& [name, flag] :
         {std::pair{"today", &ChartRow::is_default}, {"cheapest", &ChartRow::is_cheapest_within_tolerance}}) {
      const std::vector<const ChartRow*> rows =
          shown([flag = flag](const ChartRow& row) { return row.*flag; });
      picture.set(name, int(!rows.empty()));
      if (!rows.empty()) add(&picture, name, {columns(rows)});
    }
    picture.set("method", methods_);
    picture.set("methods", int(methods_.size()));
    picture.set("what", family_.title);
    picture.set("x_label", "time of " + family_.timed);
    picture.set("y_label", family_.error_of + (has_zero_ ? " (0 at the lower edge)" : ""));
    picture.set("x_axis", log_axis("x", x_.low, x_.high) + "; set xtics " + decade_tics(x_.low, x_.high));
    picture.set("y_axis", log_axis("y", y_.low, y_.high));
    picture.set("frame", std::vector<double>{kLeft, kRight, kLow, kHigh});
    set_tolerance(&picture);
    add_labels(&picture);
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

  PictureColumns columns(const std::vector<const ChartRow*>& rows) const {
    PictureColumns result(4, Eigen::ArrayXd(Eigen::Index(rows.size())));
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const auto k = Eigen::Index(i);
      result[0][k] = rows[i]->seconds, result[1][k] = rows[i]->seconds_low;
      result[2][k] = rows[i]->seconds_high, result[3][k] = shown_error(*rows[i]);
    }
    return result;
  }
  static void add(Picture* picture, const std::string& what, const std::vector<PictureColumns>& blocks) {
    picture->add_blocks(picture->name + "_" + what + ".dat",
                        {what + ": median, lower and upper quartile of the time [s], error"}, blocks);
  }
  std::vector<const ChartRow*> shown(const std::function<bool(const ChartRow&)>& wanted) const {
    std::vector<const ChartRow*> rows;
    for (const ChartRow& row : family_.rows)
      if (is_shown(row) && wanted(row)) rows.push_back(&row);
    return rows;
  }
  void add_frontier(Picture* picture) {
    std::vector<const ChartRow*> rows = shown([](const ChartRow& row) { return row.on_frontier; });
    picture->set("frontier", int(!rows.empty()));
    if (rows.empty()) return;
    std::sort(rows.begin(), rows.end(), [](const ChartRow* a, const ChartRow* b) {
      return a->seconds < b->seconds || (a->seconds == b->seconds && a->error > b->error);
    });
    for (std::size_t i = 0; i + 1 < rows.size(); ++i) {  // lines of the stairs
      const double x = pixel_x(rows[i]->seconds), next = pixel_x(rows[i + 1]->seconds);
      const double y = pixel_y(shown_error(*rows[i])), down = pixel_y(shown_error(*rows[i + 1]));
      places_.block({x, next, y - 4, y + 4}, true);
      places_.block({next - 4, next + 4, down, y}, true);
    }
    add(picture, "frontier", {columns(rows)});
  }
  void set_tolerance(Picture* picture) {
    picture->set("tolerance", family_.tolerance > 0 ? family_.tolerance : 0.0);
    if (!(family_.tolerance > 0)) return;
    const std::string text = fmt::format("{}: {:.3g}", family_.tolerance_of, family_.tolerance);
    // The label stands on the side without points in the way.
    const double y = pixel_y(family_.tolerance), width = 8.0 * double(text.size());
    const double right = kWidth * (kRight - kLeft);
    const bool on_right = std::any_of(family_.rows.begin(), family_.rows.end(), [&](const ChartRow& row) {
      const double above = is_shown(row) ? pixel_y(shown_error(row)) - y : -1;
      return above > -kMark && above < 22 + kMark && pixel_x(row.seconds_low) < width + kMark;
    });
    places_.block({on_right ? right - width : 0, on_right ? right : width, y, y + 22});
    places_.block({0, kWidth, y - 2, y + 2});
    picture->set("tolerance_text", text);
    picture->set("on_right", int(on_right));
  }
  void add_labels(Picture* picture) {
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
      const auto method =
          std::size_t(std::find(methods_.begin(), methods_.end(), row->method) - methods_.begin());
      text += fmt::format("{:.5g} {:.5g} {} {}\n", x_.at(place->x / (kWidth * (kRight - kLeft))),
                          y_.at(place->y / (kHeight * (kHigh - kLow))), method % kColours + 1,
                          gnuplot_text(label));
    }
    picture->set("labels", int(!text.empty()));
    if (!text.empty())
      picture->data.emplace_back(
          picture->name + "_labels.dat",
          "# Time [s] and error where a label stands, number of its colour, text\n" + text);
  }

  const ChartFamily& family_;
  std::vector<std::string> methods_;
  LogAxis x_, y_;
  bool has_zero_ = false;
  LabelPlaces places_{kWidth * (kRight - kLeft), kHeight*(kHigh - kLow)};
};

}  // namespace

std::vector<DrawnPicture> draw_pictures(const Chart& chart, const std::string& directory,
                                        const PictureOptions& options, Warnings* warnings) {
  if (options.format == PictureFormat::kNone) return {};
  std::vector<Picture> pictures;
  for (const ChartFamily& family : chart.families) {
    FamilyPicture maker(family);
    if (!maker.empty()) pictures.push_back(maker.picture(chart.title));
  }
  return draw(pictures, directory, options, warnings);
}

}  // namespace aberfit
