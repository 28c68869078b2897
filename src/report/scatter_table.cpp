#include "aberfit/report/scatter_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>

#include "aberfit/core/units.h"

namespace aberfit {
namespace {

constexpr double kMuchMoreLight = 0.1;   // excess of the model's TIS that is reported
constexpr double kNotOne = 1e-6;         // deviation of the renormalisation that is reported
constexpr double kInterpolation = 5e-4;  // error of log S between rows of a PSD
constexpr double kBesideJump = 1e-9;
constexpr double kBelowBreakpoints = 1e-3;
constexpr int kMostHalvings = 30;
constexpr double kSmallestPsd = 1e-290;  // [m^4], in place of 0

std::string without_breaks(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < ' '; }, ' ');
  return text;
}

std::string scene_lines(const ScatterExport& scatter) {
  const ScatterTable& t = scatter.table;
  std::string text = "# aberfit scatter function, version 1\n";
  if (!scatter.title.empty()) text += fmt::format("# {}\n", without_breaks(scatter.title));
  text += fmt::format(
      "# wavelength_m = {:.9g}, normal incidence; roughness of {}\n# rms_height_m = {:.9g}, rms_slope = "
      "{:.9g} rad per axis, g = 4 pi rms_height/wavelength = {:.9g}\n# tis = 1 - exp(-g^2) = {:.9g}; the "
      "specular energy, exp(-g^2), is not in the columns\n",
      t.wavelength, band_text(t.f_min, t.f_max), t.rms_height, t.rms_slope, t.g, t.tis);
  if (t.cut_share > 0)
    text += fmt::format(
        "# A fraction {:.3g} of the height variance lies above 1/wavelength and does not scatter\n",
        t.cut_share);
  if (std::abs(t.renormalisation - 1) > kNotOne)
    text += fmt::format(
        "# All values are multiplied by {:.9g} for orders beyond 90 degrees, so that the integral is tis; "
        "scalar theory holds if this factor is close to 1\n",
        t.renormalisation);
  return text;
}

std::string use_lines(const ScatterExport& scatter) {
  std::string text =
      "# asf_per_sr: scattered light per solid angle at theta from the specular direction; bsdf_per_sr = asf "
      "/ cos(theta), whose integral with cos(theta) over the hemisphere is tis; tis_within: fraction of the "
      "energy that is scattered to within theta. The reflectance is 1: multiply by that of the mirror.\n";
  if (scatter.has_terms)
    text +=
        "# Use: take the terms as the shape of the surface and this as its scatter. Together they describe "
        "the mirror. The frequencies of the terms are not in this table. Attaching the scatter of the whole "
        "PSD to a surface that has the terms counts their energy twice.\n";
  else
    text +=
        "# Use: take this as the scatter of the nominal surface. All of the roughness is in this table; "
        "there are no terms beside it.\n";
  return text;
}

std::string abg_lines(const AbgFit& fit, double tis) {
  if (!fit.describes()) return fmt::format("# {}\n", no_abg(fit));
  std::string text = fmt::format(
      "# ABg: BSDF = A / (B + |sin theta|^g), A = {:.9g} /sr, B = {:.9g}, g = {:.9g}; fitted from {:.6g} to "
      "{:.6g} rad, where its error is at most {:.3g} % and {:.3g} % RMS\n# ABg: energy fraction between "
      "these angles {:.6g}, of the table {:.6g}; over the hemisphere the model integrates to {:.6g}, the "
      "table to {:.6g}\n",
      fit.model.a, fit.model.b, fit.model.g, fit.theta_min, fit.theta_max, 100 * fit.largest_error,
      100 * fit.rms_error, fit.model_in_range, fit.light_in_range, fit.tis, tis);
  if (std::abs(fit.tis - tis) > kMuchMoreLight * tis)
    text +=
        "# ABg: the model continues outside the range, but the roughness does not. Limit its angles to the "
        "range, or use the table.\n";
  if (fit.at_least_b)
    text +=
        "# ABg: B has the least allowed value; a program that allows smaller ones can follow the table more "
        "closely.\n";
  return text;
}

// Appends rows between two, including the second, until log-log interpolation is close to S.
void append_rows(const std::function<double(double)>& psd, double f_low, double s_low, double f_high,
                 double s_high, int halvings, std::string* text) {
  const double f = std::sqrt(f_low * f_high), s = psd(f);
  const double off = std::abs(std::log(s) - 0.5 * (std::log(s_low) + std::log(s_high)));
  if (off > kInterpolation && halvings < kMostHalvings) {
    append_rows(psd, f_low, s_low, f, s, halvings + 1, text);
    append_rows(psd, f, s, f_high, s_high, halvings + 1, text);
  } else {
    fmt::format_to(std::back_inserter(*text), "{:.12g},{:.9g}\n", f_high, s_high);
  }
}

}  // namespace

std::string no_abg(const AbgFit& fit) {
  return fmt::format(
      "No ABg model{} describes this scatter: from {} to {} the error of the nearest is {}, more than a "
      "factor of {}; use the table",
      fit.at_least_b ? fmt::format(" with B from {:.3g} on", fit.model.b) : "",
      format_quantity(fit.theta_min, Dimension::kAngle), format_quantity(fit.theta_max, Dimension::kAngle),
      format_percent(fit.largest_error), 1 + kUsableAbg);
}

std::string scatter_csv(const ScatterExport& scatter) {
  const ScatterTable& t = scatter.table;
  std::string text = scene_lines(scatter) + use_lines(scatter);
  for (const AbgFit& fit : scatter.abg)
    if (fit.found) text += abg_lines(fit, t.tis);
  if (scatter.rest) text += psd_formula(*scatter.rest, t.wavelength);
  text += "theta_rad,asf_per_sr,bsdf_per_sr,tis_within\n";
  for (Eigen::Index i = 0; i < t.theta.size(); ++i)
    fmt::format_to(std::back_inserter(text), "{:.12g},{:.9g},{:.9g},{:.12g}\n", t.theta[i], t.asf_per_sr[i],
                   t.bsdf_per_sr[i], t.tis_within[i]);
  return text;
}

std::string scatter_psd_csv(const PsdModel& rest, double wavelength) {
  std::string text =
      "# Two-sided, two-dimensional PSD of the surface that is scatter, S2(f) [m^4]; frequency in cycles/m; "
      "log-log between rows\n"
      "# For `\"model\": \"table\"`: \"kind\": \"2d\", \"frequency_unit\": \"/m\", \"psd_unit\": \"m^4\"\n"
      "frequency_per_m,psd_2d_m4\n";
  const RadialPsd psd(rest);
  const double high = std::min(psd.f_max(), 1 / wavelength);
  double low = psd.f_min();
  if (!(low < high)) return text;  // nothing scatters
  const auto& bends = psd.breakpoints();
  if (low == 0) low = kBelowBreakpoints * std::min(high, bends.empty() ? high : bends.front());
  std::vector<double> edges{low};
  for (const double f : bends)
    if (f > low * (1 + 4 * kBesideJump) && f < high * (1 - 4 * kBesideJump)) {
      edges.push_back(f * (1 - kBesideJump));
      edges.push_back(f * (1 + kBesideJump));
    }
  edges.push_back(high);
  const auto value = [&](double f) { return std::max(psd(f), kSmallestPsd); };
  fmt::format_to(std::back_inserter(text), "{:.12g},{:.9g}\n", low, value(low));
  for (std::size_t i = 0; i + 1 < edges.size(); ++i) {
    const double a = edges[i], b = edges[i + 1];
    append_rows(value, a, value(a), b, value(b), b / a - 1 < 4 * kBesideJump ? kMostHalvings : 0, &text);
  }
  return text;
}

}  // namespace aberfit
