#include "aberfit/report/ceilings_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "aberfit/core/constants.h"
#include "aberfit/report/documents.h"
#include "paragraph.h"
#include "picture.h"

namespace aberfit {
using namespace internal;

namespace {

constexpr double kSquareNanometreMillimetre = 1e-21;  // [m^3], unit of drawings
constexpr double kPerMillimetre = 1000;

// These functions give the fields of a table in the units of drawings.
std::string rms_text(double rms) { return std::isfinite(rms) ? metres_text(rms) : "any"; }
std::string level_text(double level) {
  return std::isfinite(level) ? fmt::format("{:.4g}", level / kSquareNanometreMillimetre) : "any";
}
std::string binding_text(const Ceilings& ceilings, double rms, std::size_t binding) {
  return std::isfinite(rms) ? ceilings.budgets[binding].key : "-";
}

// Range from the smallest to the largest finite RMS height.
template <typename Items>
std::string range_text(const Items& items) {
  double least = kInfinity, most = 0;
  for (const auto& item : items) {
    if (!std::isfinite(item.rms)) continue;
    least = std::min(least, item.rms);
    most = std::max(most, item.rms);
  }
  if (!(most > 0)) return "any height";
  return metres_text(least) + (least == most ? "" : " to " + metres_text(most)) + " RMS";
}

void add_octaves(Page* page, const Ceilings& ceilings) {
  Page::Table table{
      "The most roughness that one octave may have if all others are smooth: RMS height, and level of the "
      "one-sided profile PSD. Two octaves cannot both be at their ceiling.",
      {"f [1/mm]", "cycles across", "RMS", "PSD [nm^2 mm]", "limited by"},
      "rrrrl"};
  for (const OctaveCeiling& octave : ceilings.octaves)
    table.add({fmt::format("{:.4g}", octave.frequency / kPerMillimetre),
               fmt::format("{:.4g}", octave.frequency * ceilings.across), rms_text(octave.rms),
               level_text(octave.profile_psd), binding_text(ceilings, octave.rms, octave.binding)});
  page->parts.push_back(std::move(table));
}

void add_lines(Page* page, const Ceilings& ceilings) {
  Page::Table table{
      "The largest profile PSD A/f^B (as in ISO 10110-8) over the whole band; f is in 1/mm. It may be used "
      "up completely. Headroom: the ceiling of the nearest octave over the level of the line there.",
      {"B", "A [nm^2 mm]", "RMS", "headroom", "nearest [1/mm]", "limited by"},
      "rrrrrl"};
  for (const LineCeiling& line : ceilings.lines) {
    const bool known = std::isfinite(line.headroom);
    table.add({fmt::format("{:.4g}", line.exponent), level_text(line.level), rms_text(line.rms),
               known ? fmt::format("{:.3g}", line.headroom) : "-",
               known ? fmt::format("{:.4g}", line.closest / kPerMillimetre) : "-",
               binding_text(ceilings, line.rms, line.binding)});
  }
  page->parts.push_back(std::move(table));
}

std::string shown_bounds(const Ceilings& ceilings) {
  std::string text;
  for (const Budget& budget : ceilings.budgets)
    text += (text.empty() ? "" : ", ") + budget.key + " " + budget.bound;
  return text;
}

}  // namespace

Page page_of(const Ceilings& ceilings) {
  const bool found = ceilings.reason.empty();
  Page page;
  page.headline = found ? "CEILINGS: " + range_text(ceilings.octaves) + " in one octave alone, " +
                              range_text(ceilings.lines) + " along a line A/f^B"
                        : "NO SOLUTION";
  page.tone = found ? Page::Tone::kGood : Page::Tone::kOpen;
  if (!found) page.advice.push_back(ceilings.reason);
  page.title = ceilings.title;
  page.answers.push_back({"How certain",
                          "Each ceiling is exact to 1e-11 for the mean PSF of such mirrors. Two of them "
                          "cannot be used at once."});
  page.answers.push_back(
      {"What it rests on",
       to_string(ceilings.theory) == "ghs"
           ? "Generalised Harvey-Shack for a stationary, isotropic, Gaussian roughness. The PSD "
             "of the study is not used."
           : "Geometric Harvey-Shack. The PSD of the study is not used."});
  page.answers.push_back({"What would change it",
                          "Roughness in other octaves uses a part of the same budgets. The lines A/f^B allow "
                          "for the whole band."});
  if (found)
    page.answers.push_back(
        {"What to do next",
         "A line A/f^B can go on the drawing as it is. A measured PSD (`aberfit psd`) must "
         "stay below that line; its octaves must at least stay below their ceilings."});
  page.say("Budget", shown_bounds(ceilings));
  page.say("Theory", fmt::format("{}; plate scale 1/f = {:.5g} arcsec/mm", to_string(ceilings.theory),
                                 1e-3 / ceilings.focal_length / unit_factor("arcsec", Dimension::kAngle)));
  page.say("Band", fmt::format("{:.4g} /mm to {:.4g} /mm, {:.4g} to {:.4g} cycles across",
                               ceilings.f_min / kPerMillimetre, ceilings.f_max / kPerMillimetre,
                               ceilings.f_min * ceilings.across, ceilings.f_max * ceilings.across));
  page.say("Cost", fmt::format("{} evaluations, {:.2g} s", ceilings.evaluations, ceilings.seconds));
  if (found) add_octaves(&page, ceilings), add_lines(&page, ceilings);
  page.warnings = ceilings.warnings;
  return page;
}

std::string ceilings_csv(const Ceilings& ceilings) {
  std::string text = "frequency_per_m,rms_m,profile_psd_m3,binding\n";
  const auto number = [](double value) { return std::isfinite(value) ? fmt::format("{:.12g}", value) : ""; };
  for (const OctaveCeiling& octave : ceilings.octaves)
    fmt::format_to(std::back_inserter(text), "{:.12g},{},{},{}\n", octave.frequency, number(octave.rms),
                   number(octave.profile_psd),
                   std::isfinite(octave.rms) ? ceilings.budgets[octave.binding].key : "");
  return text;
}

std::vector<DrawnPicture> draw_pictures(const Ceilings& ceilings, const std::string& directory,
                                        const PictureOptions& options, Warnings* warnings) {
  std::vector<double> at, height, level, exponent;
  for (const OctaveCeiling& octave : ceilings.octaves)
    if (std::isfinite(octave.rms)) at.push_back(octave.frequency), height.push_back(octave.profile_psd);
  if (at.empty() || !ceilings.reason.empty()) return {};
  std::vector<std::string> labels;
  for (const LineCeiling& line : ceilings.lines) {
    if (!std::isfinite(line.rms)) continue;
    level.push_back(line.level), exponent.push_back(line.exponent);
    labels.push_back(fmt::format("A/f^{:g}, {} RMS", line.exponent, metres_text(line.rms)));
  }
  Picture picture("ceilings", ceilings.title);
  picture.add_columns(
      "ceilings.dat",
      {"Ceiling of each octave alone: its middle [1/m], level of the one-sided profile PSD [m^3]"},
      {array_of(at), array_of(height)});
  picture.set("bounds", shown_bounds(ceilings));
  picture.set("f_axis", log_axis("x", ceilings.f_min / kPerMillimetre, ceilings.f_max / kPerMillimetre));
  const Eigen::ArrayXd octaves = array_of(height) / kSquareNanometreMillimetre;
  picture.set("l_axis", log_axis("y", 1e-4 * octaves.minCoeff(), 10 * octaves.maxCoeff()));
  picture.set("lines", int(labels.size()));
  picture.set("level", level);
  picture.set("exponent", exponent);
  picture.set("label", labels);
  return draw({picture}, directory, options, warnings);
}

}  // namespace aberfit
