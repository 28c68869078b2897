#include "aberfit/report/psd_of_focus_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "aberfit/core/units.h"
#include "aberfit/report/documents.h"
#include "paragraph.h"
#include "unknown_text.h"

namespace aberfit {
using namespace internal;

namespace {

std::string shown(const NumberOfFocus& number, double value) {
  return six_digits(value, number.unknown.dimension);
}

// The interval, or "below 3 nm" if only one end is known.
std::string interval_text(const NumberOfFocus& number) {
  if (number.identified()) return shown(number, number.lower) + " to " + shown(number, number.upper);
  if (number.upper_found) return "below " + shown(number, number.upper);
  if (number.lower_found) return "above " + shown(number, number.lower);
  return "anything";
}

std::string focus_headline(const PsdOfFocus& result) {
  std::string numbers;
  for (const NumberOfFocus& number : result.numbers)
    numbers += (numbers.empty() ? "" : ", ") + name_of(number.unknown) +
               (number.identified() ? " = " + shown(number, number.best) : " " + interval_text(number));
  switch (result.status) {
    case PsdOfFocusStatus::kFitted:
      return "FITTED: " + numbers;
    case PsdOfFocusStatus::kNotIdentified:
      return "NOT IDENTIFIED: " + numbers;
    case PsdOfFocusStatus::kNotDescribed:
      return "POOR FIT: " + numbers;
    case PsdOfFocusStatus::kNotConverged:
      return "NOT CONVERGED";
  }
  return "";
}

void add_numbers(Page* page, const PsdOfFocus& result) {
  Page::Table table{
      "",
      {"number", "value", "std", fmt::format("{:.3g} % interval", 100 * result.confidence), "start"},
      "lrrlr"};
  for (const NumberOfFocus& number : result.numbers)
    table.add({name_of(number.unknown), number.identified() ? shown(number, number.best) : "-",
               number.identified() ? format_percent(number.log_std) : "-", interval_text(number),
               format_quantity(number.unknown.start, number.unknown.dimension)});
  page->parts.push_back(std::move(table));
  for (std::size_t u = 0; u < result.numbers.size(); ++u)
    for (std::size_t v = 0; v < u; ++v)
      page->say("", fmt::format("correlation of {} and {}: {:.3f}", name_of(result.numbers[v].unknown),
                                name_of(result.numbers[u].unknown),
                                result.correlation(Eigen::Index(u), Eigen::Index(v))));
}

std::string match_text(const PsdOfFocus& result) {
  if (result.is_noise_known)
    return fmt::format("chi-squared {:.4g} at {} degrees of freedom, p-value {:.2g}", result.chi_squared,
                       result.degrees_of_freedom, result.goodness);
  return fmt::format(
      "no noise was given, so it is estimated from the residuals: up to {:.2g} at {} degrees of freedom; "
      "p-value of their shape {:.2g}",
      result.noise.size() > 0 ? result.noise.maxCoeff() : 0, result.degrees_of_freedom, result.goodness);
}

}  // namespace

Page page_of(const PsdOfFocus& result) {
  Page page;
  page.headline = focus_headline(result);
  page.tone = result.status == PsdOfFocusStatus::kFitted ? Page::Tone::kGood : Page::Tone::kOpen;
  page.title = result.title;
  page.answers.push_back({"How certain", fmt::format("{} intervals; {}", format_percent(result.confidence),
                                                     match_text(result))});
  page.answers.push_back(
      {"What it rests on", "The mean PSF of generalised Harvey-Shack for the study's mirror and PSD model."});
  page.answers.push_back({"What would change it",
                          "Another noise, plane or centre would change it, and so would light that this "
                          "roughness does not scatter."});
  page.say("Light",
           fmt::format("{} {} out to {}{}; {}", result.radius.size(),
                       result.is_image ? "rings of pixels" : "circles",
                       metres_text(result.radius.size() > 0 ? result.radius.maxCoeff() : 0),
                       result.dz == 0 ? "" : fmt::format(", {} from the focus", metres_text(result.dz)),
                       result.is_one_mirror ? "one mirror, whose deviation from the mean counts as noise"
                                            : "the mean of many mirrors"));
  if (result.is_image)
    page.say(
        "Image",
        fmt::format(
            "centre at pixel {:.2f}, {:.2f} from the lower left; total {:.6g}, background {:.4g} per pixel",
            result.centre_x, result.centre_y, result.total, result.background));
  else if (result.total != 1)
    page.say("", fmt::format("the total energy is {:.5g} times what the curve calls 1", result.total));
  page.say("Match", match_text(result));
  page.say("Cost", fmt::format("{} evaluations, {:.2g} s", result.evaluations, result.seconds));
  add_numbers(&page, result);
  page.warnings = result.warnings;
  return page;
}

std::string focus_csv(const PsdOfFocus& result) {
  std::string text = result.is_image
                         ? "mean_radius_m,measured_per_pixel,fitted_per_pixel,noise,spread,residual\n"
                         : "radius_m,measured_share,fitted_share,noise,spread,residual\n";
  for (Eigen::Index k = 0; k < result.radius.size(); ++k)
    fmt::format_to(std::back_inserter(text), "{:.12g},{:.9g},{:.9g},{:.4g},{:.4g},{:.4g}\n", result.radius[k],
                   result.measured[k], result.fitted[k], result.noise[k], result.spread[k],
                   (result.measured[k] - result.fitted[k]) / std::hypot(result.noise[k], result.spread[k]));
  return text;
}

}  // namespace aberfit
