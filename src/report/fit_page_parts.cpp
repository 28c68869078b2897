#include <fmt/format.h>

#include <cmath>

#include "aberfit/core/units.h"
#include "aberfit/method/constants.h"
#include "aberfit/report/scatter_table.h"
#include "fit_page.h"
#include "map_report.h"
#include "paragraph.h"

namespace aberfit::internal {
namespace {

std::string residual_words(const BandShares& shares) {
  if (!std::isfinite(shares.map_residual)) return "";
  std::string text = fmt::format(" The residual of the map is {}", metres_text(shares.map_residual));
  if (std::isfinite(shares.specified_residual))
    text += fmt::format(", that of its specification {}", metres_text(shares.specified_residual));
  return text + (shares.rest_rms > 0 ? "; it is not added because the scatter represents it." : ".");
}

std::string abg_words(const AbgFit& fit) {
  if (!fit.describes()) return no_abg(fit) + ".";
  return fmt::format(
      "ABg: A {:.4g} /sr, B {:.4g}, g {:.4g}{}; its error from {} to {} is at most {} (RMS {}), its TIS {}.",
      fit.model.a, fit.model.b, fit.model.g, fit.at_least_b ? " (the least B)" : "",
      format_quantity(fit.theta_min, Dimension::kAngle), format_quantity(fit.theta_max, Dimension::kAngle),
      format_percent(fit.largest_error), format_percent(fit.rms_error), format_percent(fit.tis));
}

// Adds the best model, and the error of the form that every program accepts.
void add_abg(Page* page, const std::vector<AbgFit>& fits) {
  if (fits.empty()) return;
  std::string text = abg_words(fits.back());
  if (fits.size() > 1 && fits.back().describes())
    text += fmt::format(" OpticStudio needs B above 1e-12, and then the error is {}: use the table there.",
                        format_percent(fits.front().largest_error));
  page->say("", text);
}

std::string set_name(const FrontierPoint& point) {
  return point.family == "fourier" ? fmt::format("{} waves", point.order)
                                   : fmt::format("n <= {}", point.order);
}

std::string rest_words(const MapLight& light, const MapPanels& panels) {
  const ResidualPsd& rest = light.rest;
  if (!rest.obstacle.empty()) return "the residual has none: " + rest.obstacle;
  if (!(rest.rms_height > 0)) return "the residual has none: the terms leave nothing that affects the PSF";
  return fmt::format("the residual from {} to {} has RMS {} (its map {}), TIS {}",
                     format_quantity(rest.f_min, Dimension::kSpatialFrequency),
                     format_quantity(rest.f_max, Dimension::kSpatialFrequency), metres_text(rest.rms_height),
                     metres_text(panels.residual.rms), format_percent(rest.tis));
}

void add_beside(Page::Table* table, const std::string& what, const BesideDraws& one) {
  table->add({what, fmt::format("{:.3f}", one.value), fmt::format("{:.3f}", one.mean),
              fmt::format("{:.3f} .. {:.3f}", one.low, one.high), one.inside() ? "inside" : "OUTSIDE"},
             one.inside() ? Page::Tone::kPlain : Page::Tone::kBad);
}

void add_other_light(Page* page, const std::vector<OtherLight>& others) {
  if (others.empty()) return;
  Page::Table table{"Largest difference of ee35 to ee90 at other wavelengths and stops, in tolerances",
                    {"", "fitted", "realisations (RMS)", "of"},
                    "lrrl"};
  std::vector<std::string> unanswered;
  for (const OtherLight& other : others) {
    const std::string what = other.stop < 1
                                 ? fmt::format("stop of {:.3g} %", 100 * other.stop)
                                 : fmt::format("{:.3g} wavelengths, {}", other.wavelength_ratio,
                                               format_quantity(other.wavelength, Dimension::kLength));
    if (other.obstacle.empty())
      table.add({what, fmt::format("{:.2f}", other.worst), fmt::format("{:.2f}", other.draws),
                 fmt::format("ee{:g}", 100 * other.fraction)});
    else
      unanswered.push_back(what + ": no value: " + other.obstacle);
  }
  if (!table.rows.empty()) page->parts.push_back(std::move(table));
  for (std::string& text : unanswered) page->say("", std::move(text));
}

}  // namespace

void add_band(Page* page, const BandShares& shares, const std::optional<ScatterOfRest>& scatter,
              const EquivalentSurface& surface) {
  const auto squares = [](double a, double b, Dimension dimension) {
    return fmt::format("{} and {}, together {}", format_quantity(a, dimension), format_quantity(b, dimension),
                       format_quantity(std::hypot(a, b), dimension));
  };
  page->say("Band", shares.reason);
  if (scatter) add_abg(page, scatter->abg);
  if (!(shares.cut > 0)) return;
  page->say("", fmt::format("Terms and scatter: RMS height {}; RMS slope {} per axis.{}",
                            squares(surface.rms_height, shares.rest_rms, Dimension::kLength),
                            squares(surface.rms_slope_per_axis, shares.rest_slope, Dimension::kAngle),
                            residual_words(shares)));
}

void add_frontier(Page* page, const Frontier& frontier, const std::string& points_name) {
  page->say("Terms", fmt::format("{}; {:.3g} s", frontier.message, frontier.seconds));
  if (frontier.points.size() == 1 && !frontier.fewest) return;
  Page::Table table{"Sets of terms that were tried",
                    {"set", "terms", points_name, "fit [tol.]", "held out [%]", "time [s]", "verdict"},
                    "lrrrrrl"};
  const auto known = [](double value, const char* form) {
    return std::isfinite(value) ? fmt::format(fmt::runtime(form), value) : "-";
  };
  for (const FrontierPoint& point : frontier.points) {
    const std::string verdict = point.verdict ? to_string(*point.verdict) : "not judged";
    table.add({set_name(point), std::to_string(point.terms), std::to_string(point.rays),
               known(point.fitted_mismatch, "{:.4g}"), known(100 * point.held_out_mismatch, "{:.3f}"),
               known(point.seconds, "{:.2f}"),
               verdict + (point.chosen   ? ", taken"
                          : point.passes ? ", passes"
                                         : "")});
  }
  page->parts.push_back(std::move(table));
}

std::string character_words(const Character& character, Verdict verdict) {
  const std::string fault = character.fault();
  if (fault.empty()) return "the PSD and shape are those of a random realisation";
  return (verdict == Verdict::kEquivalent ? "but it is no realisation of this roughness: "
                                          : "it is no realisation of this roughness: ") +
         fault;
}

void add_character(Page* page, const Character& character) {
  Page::Table table{
      fmt::format("Character, compared with {} random realisations", character.draws),
      {"", "fitted", "mean", fmt::format("{:g} % of realisations", 100 * law::kCharacterConfidence), ""},
      "lrrrl"};
  for (const CharacterBin& bin : character.psd)
    add_beside(&table, fmt::format("PSD {:.4g} .. {:.4g} /m, ratio", bin.low, bin.high), bin.ratio);
  for (const ZoneSlope& zone : character.zones)
    add_beside(&table, fmt::format("RMS slope {:.2f} .. {:.2f} R, ratio", zone.rho_min, zone.rho_max),
               zone.ratio);
  add_beside(&table, "RMS slope, x over y", character.slope_x_over_y);
  if (character.length_over_width)
    add_beside(&table, "image, length over width", *character.length_over_width);
  if (character.bright_share)
    add_beside(&table, "energy in brightest 1 % beyond ee35", *character.bright_share);
  page->parts.push_back(std::move(table));
  if (!character.light_obstacle.empty()) page->say("", "no image was compared: " + character.light_obstacle);
  add_other_light(page, character.others);
}

void add_map_light(Page* page, const FitOutcome& outcome) {
  if (!outcome.map.light || !outcome.map.panels) return;
  const MapLight& light = *outcome.map.light;
  Page::Table table{"PSF of the map by wave optics", {""}, "l"};
  for (const MapColumnName& name : kMapColumns) table.heads.push_back(name.label), table.align += 'r';
  const auto row = [&](const char* name, double LitSurface::*value, Dimension dimension) {
    std::vector<std::string> cells = {name};
    for (const LitSurface* lit : light.columns()) cells.push_back(four_digits(lit->*value, dimension));
    table.add(std::move(cells));
  };
  row("Strehl ratio", &LitSurface::strehl, Dimension::kNumber);
  row("ee50 radius", &LitSurface::ee50, Dimension::kLength);
  row("ee80 radius", &LitSurface::ee80, Dimension::kLength);
  row("ee90 radius", &LitSurface::ee90, Dimension::kLength);
  row("spot FWHM", &LitSurface::spot_fwhm, Dimension::kLength);
  page->parts.push_back(std::move(table));
  for (std::size_t k = 0; k < light.columns().size(); ++k)
    if (const std::string& obstacle = light.columns()[k]->obstacle; !obstacle.empty())
      page->say("", std::string(kMapColumns[k].label) + ": no PSF, " + obstacle);
  page->say("Pupil",
            fmt::format("the whole aperture on {} points of the map, without piston and tilt of the mount; "
                        "{} of it has no measured height and takes that of the terms in all columns",
                        light.cells, format_percent(light.filled_share)));
  page->say("PSD", rest_words(light, *outcome.map.panels));
}

}  // namespace aberfit::internal
