#include "aberfit/study/published.h"

#include <fmt/format.h>

#include <cctype>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <utility>

#include "aberfit/core/constants.h"
#include "aberfit/core/errors.h"
#include "aberfit/core/text.h"
#include "expression.h"

namespace aberfit {
using namespace internal;

namespace {

struct Values {
  double gx, gy, wavelength, focal_length, diameter, rms, correlation_length, f_min, f_max;
  double deflection(double gradient) const { return wavelength / (4 * kPi) * gradient; }
  double per_axis() const { return deflection(std::sqrt((gx * gx + gy * gy) / 2)); }
};

using Formula = std::pair<std::string, std::function<double(const Values&)>>;

const std::vector<Formula>& formulas() {
  static const std::vector<Formula> table = {
      {"total_gradient", [](const Values& v) { return std::hypot(v.gx, v.gy); }},
      {"deflection_x", [](const Values& v) { return v.deflection(v.gx); }},
      {"deflection_y", [](const Values& v) { return v.deflection(v.gy); }},
      {"mean_deflection", [](const Values& v) { return std::sqrt(kPi / 2) * v.per_axis(); }},
      {"rms_deflection", [](const Values& v) { return v.deflection(std::hypot(v.gx, v.gy)); }},
      {"focal_shift_std",
       [](const Values& v) {
         return v.per_axis() * v.diameter / 2 / (v.focal_length * std::numbers::sqrt2);
       }},
      {"largest_angle", [](const Values& v) { return std::asin(v.wavelength * v.f_max); }},
      {"paper_ratio_r",
       [](const Values& v) { return 2 * v.rms * v.diameter / (1.22 * v.wavelength * v.correlation_length); }},
      {"uniform_psd_2d",
       [](const Values& v) { return v.rms * v.rms / (kPi * (v.f_max * v.f_max - v.f_min * v.f_min)); }},
      {"uniform_psd_1d", [](const Values& v) { return v.rms * v.rms / (v.f_max - v.f_min); }},
      {"uniform_slope_total",
       [](const Values& v) {
         return 2 * kPi * v.rms * std::sqrt((v.f_max * v.f_max + v.f_min * v.f_min) / 2);
       }},
  };
  return table;
}

}  // namespace

const std::vector<std::string>& published_formulas() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> list;
    for (const Formula& formula : formulas()) list.push_back(formula.first);
    return list;
  }();
  return names;
}

double evaluate_formula(const std::string& name, const FormulaInputs& inputs, const Study& study) {
  const double unknown = std::nan("");
  const Values values{inputs.gradient_x.value_or(unknown),
                      inputs.gradient_y.value_or(unknown),
                      inputs.wavelength.value_or(study.wavelength),
                      inputs.focal_length.value_or(study.mirror.focal_length),
                      inputs.diameter.value_or(2 * aperture_radius(study.aperture)),
                      inputs.rms.value_or(unknown),
                      inputs.correlation_length.value_or(unknown),
                      inputs.f_min.value_or(unknown),
                      inputs.f_max.value_or(unknown)};
  for (const Formula& formula : formulas())
    if (formula.first == name) return formula.second(values);
  return unknown;
}

const std::vector<std::string>& published_verdicts() {
  static const std::vector<std::string> words = {
      "holds", "fails", "reading", "input", "not-stated", "not-reproducible", "untested", "picture"};
  return words;
}

double half_last_digit(const std::string& printed) {
  if (!parse_finite(printed)) return std::nan("");
  const std::size_t mantissa_end = std::min(printed.find_first_of("eE"), printed.size());
  const std::size_t point = printed.find('.');
  const double decimals = point < mantissa_end ? double(mantissa_end - point - 1) : 0.0;
  const double exponent =
      mantissa_end < printed.size() ? *parse_finite(printed.substr(mantissa_end + 1)) : 0.0;
  return 0.5 * std::pow(10.0, exponent - decimals);
}

namespace {

// What stands at a name in an expression.
std::string as_name(std::string text) {
  for (char& c : text)
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '.') c = '_';
  return text;
}

using Names = std::map<std::string, double, std::less<>>;

Names names_of(const std::vector<PublishedNumber>& rows, const Quantities& quantities) {
  Names names;
  for (const auto& [name, value] : quantities) names[as_name(name)] = value;
  for (const PublishedNumber& row : rows)
    if (!row.id.empty() && row.value) names["printed." + as_name(row.id)] = *row.value * row.scale;
  return names;
}

template <typename Map>
std::string list_of(const Map& names) {
  std::string known;
  for (const auto& [name, value] : names) known += (known.empty() ? "" : ", ") + name;
  return known;
}

// A row among its neighbours: evaluates what it asks for, and says where it cannot.
struct PublishedRow {
  const Study& study;
  std::size_t at;
  const Quantities& quantities;
  const Names& names;

  const PublishedNumber& row() const { return study.verify.published[at]; }

  [[noreturn]] void refuse(const char* key, const std::string& found, const std::string& allowed) const {
    throw InputError(study.path, fmt::format("/verify/published/{}/{}", at, key), found, allowed);
  }
  double expression(const char* key, const std::string& text, const Names& own) const {
    return evaluate_expression(text, [&](std::string_view name) {
      if (const auto found = own.find(name); found != own.end()) return found->second;
      if (const auto found = names.find(name); found != names.end()) return found->second;
      refuse(key, '"' + std::string(name) + '"', list_of(names));
    });
  }
  // [SI]; NaN: there is none.
  double ours() const {
    if (!row().formula.empty()) return evaluate_formula(row().formula, row().inputs, study);
    if (!row().expression.empty()) return expression("expression", row().expression, {});
    if (row().quantity.empty()) return std::nan("");
    const auto found = quantities.find(row().quantity);
    if (found != quantities.end()) return found->second;
    refuse("quantity", '"' + row().quantity + '"', list_of(quantities));
  }
};

PublishedComparison compare_row(const PublishedRow& place) {
  const PublishedNumber& row = place.row();
  PublishedComparison c;
  c.id = row.id;
  c.section = row.section;
  c.label = row.label;
  c.printed_text = row.printed;
  c.printed = row.value.value_or(std::nan(""));
  c.derived = row.derived;
  c.ours = place.ours() / row.scale;
  c.unit = row.unit;
  c.from = !row.formula.empty() ? row.formula : !row.expression.empty() ? row.expression : row.quantity;
  if (c.from.empty()) c.from = row.holds;
  c.within = row.within ? *row.within * std::abs(c.printed) : half_last_digit(row.printed);
  c.verdict = row.verdict;
  c.reading = row.reading;
  c.picture = row.picture;
  bool compared = true, holds = false;
  if (!row.holds.empty()) {
    holds = place.expression("holds", row.holds, {{"ours", c.ours}, {"printed", c.printed}}) != 0;
    c.within = std::nan("");
  } else if (std::isfinite(c.printed) && std::isfinite(c.ours) && std::isfinite(c.within)) {
    // A bound that is met to the last bit is met: numbers of a table are decimal, ours are binary.
    constexpr double kRounding = 1e-12;
    holds = std::abs(c.ours - c.printed) <= c.within + kRounding * std::abs(c.printed);
  } else {
    compared = false;
  }
  if (compared)
    c.verdict = !holds ? "fails" : row.verdict.empty() || row.verdict == "fails" ? "holds" : row.verdict;
  return c;
}

}  // namespace

std::vector<PublishedComparison> compare_published(const Study& study, const Quantities& quantities) {
  const Names names = names_of(study.verify.published, quantities);
  std::vector<PublishedComparison> compared;
  for (std::size_t k = 0; k < study.verify.published.size(); ++k)
    compared.push_back(compare_row({study, k, quantities, names}));
  return compared;
}

}  // namespace aberfit
