#include "aberfit/report/psd_of_focus_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "aberfit/core/constants.h"
#include "json_number.h"
#include "paragraph.h"
#include "unknown_text.h"

namespace aberfit {
using namespace internal;

namespace {

std::string shown(const NumberOfFocus& number, double value) {
  return six_digits(value, number.unknown.dimension);
}

// "below 3 nm" where only one end is known.
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

std::string number_rows(const PsdOfFocus& result) {
  std::string text = fmt::format("\n  {:<22} {:>15} {:>9}  {:<36} {:>10}\n", "number", "value", "std",
                                 fmt::format("{:.3g} % interval", 100 * result.confidence), "start");
  for (const NumberOfFocus& number : result.numbers)
    text += fmt::format("  {:<22} {:>15} {:>9}  {:<36} {:>10}\n", name_of(number.unknown).substr(0, 22),
                        number.identified() ? shown(number, number.best) : "-",
                        number.identified() ? format_percent(number.log_std) : "-", interval_text(number),
                        format_quantity(number.unknown.start, number.unknown.dimension));
  for (std::size_t u = 0; u < result.numbers.size(); ++u)
    for (std::size_t v = 0; v < u; ++v)
      text += fmt::format("  correlation of {} and {}: {:.3f}\n", name_of(result.numbers[v].unknown),
                          name_of(result.numbers[u].unknown),
                          result.correlation(Eigen::Index(u), Eigen::Index(v)));
  return text;
}

}  // namespace

Json to_json(const PsdOfFocus& result, const Json& study, const Provenance& provenance) {
  Json json = json_document("psd-of-focus", study);
  json["status"] = to_string(result.status);
  json["message"] = result.message.empty() ? Json(nullptr) : Json(result.message);
  json["confidence"] = result.confidence;
  json["numbers"] = Json::array();
  for (const NumberOfFocus& number : result.numbers)
    json["numbers"].push_back({{"pointer", number.unknown.pointer},
                               {"start", json_number(number.unknown.start)},
                               {"identified", number.identified()},
                               {"value", json_number(number.identified() ? number.best : kNaN)},
                               {"best", json_number(number.best)},
                               {"relative_std", json_number(number.identified() ? number.log_std : kNaN)},
                               {"lower", json_number(number.lower_found ? number.lower : kNaN)},
                               {"upper", json_number(number.upper_found ? number.upper : kNaN)}});
  json["correlation_of_logarithms"] = Json::array();
  for (Eigen::Index u = 0; u < result.correlation.rows(); ++u)
    json["correlation_of_logarithms"].push_back(json_numbers(result.correlation.row(u)));
  json["chi_squared"] = json_number(result.is_noise_known ? result.chi_squared : kNaN);
  json["degrees_of_freedom"] = result.degrees_of_freedom;
  json["goodness"] = json_number(result.goodness);
  json["noise_factor"] = json_number(result.noise_factor);
  json["of"] = result.is_one_mirror ? "mirror" : "mean";
  json["plane_m"] = json_number(result.dz);
  json["total"] = json_number(result.total);
  json["background"] = result.is_image ? json_number(result.background) : Json(nullptr);
  json["centre_pixels"] = result.is_image ? Json::array({result.centre_x, result.centre_y}) : Json(nullptr);
  json["light"] = {{"kind", result.is_image ? "rings" : "circles"}, {"radius_m", json_numbers(result.radius)},
                   {"measured", json_numbers(result.measured)},     {"fitted", json_numbers(result.fitted)},
                   {"noise", json_numbers(result.noise)},           {"spread", json_numbers(result.spread)}};
  json["evaluations"] = result.evaluations;
  json["seconds"] = json_number(result.seconds);
  json["warnings"] = json_warnings(result.warnings);
  json["provenance"] = to_json(provenance);
  return json;
}

std::string summary_table(const PsdOfFocus& result) {
  std::string text = wrapped(focus_headline(result), kColumns, 2) +
                     (result.title.empty() ? "" : "\n" + result.title) + "\n\n";
  text += paragraph(
      "Light ",
      fmt::format("{} {} out to {}{}; of {}", result.radius.size(),
                  result.is_image ? "rings of pixels" : "circles",
                  metres_text(result.radius.size() > 0 ? result.radius.maxCoeff() : 0),
                  result.dz == 0 ? "" : fmt::format(", {} from the focus", metres_text(result.dz)),
                  result.is_one_mirror ? "one mirror: its own departure from the mean counts as noise"
                                       : "the mean of many mirrors"));
  if (result.is_image)
    text +=
        paragraph("Image ", fmt::format("centre at pixel {:.2f}, {:.2f} from the lower left; light {:.6g}, "
                                        "background {:.4g} a pixel",
                                        result.centre_x, result.centre_y, result.total, result.background));
  else if (result.total != 1)
    text += paragraph("Light ", fmt::format("{:.5g} of what the curve calls 1", result.total));
  text += paragraph(
      "Match ",
      result.is_noise_known
          ? fmt::format("chi-squared {:.4g} at {} degrees of freedom: chance {:.2g}", result.chi_squared,
                        result.degrees_of_freedom, result.goodness)
          : fmt::format("no noise was given; it is taken from the residuals, up to {:.2g} at {} degrees of "
                        "freedom: chance of their form {:.2g}",
                        result.noise.size() > 0 ? result.noise.maxCoeff() : 0, result.degrees_of_freedom,
                        result.goodness));
  text += fmt::format("Cost      {} evaluations, {:.2g} s\n", result.evaluations, result.seconds);
  return text + number_rows(result) + warning_lines(result.warnings);
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
