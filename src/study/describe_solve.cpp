#include <fmt/format.h>

#include <algorithm>

#include "aberfit/core/errors.h"
#include "describe.h"

namespace aberfit::internal {

namespace {

void describe_ceilings(Visitor& v, CeilingsSpec& ceilings) {
  const auto end = [&](const char* key, const char* meaning, std::optional<double>& value) {
    v.quantity({key, meaning, kOptional, "\"20 /m\""}, value, kFrequency, Range::positive());
  };
  end("f_min", "lowest frequency [cycles/m]; absent: 1 cycle across the aperture", ceilings.f_min);
  end("f_max", "highest frequency [cycles/m]; absent: 1000 cycles across", ceilings.f_max);
  v.quantities({"exponents", "exponents B of the lines A/f^B"}, ceilings.exponents, kNumber, Range{0.05, 15},
               true);
}

void describe_atmosphere(Visitor& v, Atmosphere& air) {
  v.quantity({"r0", "Fried's length r0 for a long exposure [m]", kRequired, "\"15 cm\""}, air.r0, kLength,
             Range::positive());
  v.quantity({"wavelength", "wavelength at which r0 is given [m]", kRequired, "\"500 nm\""}, air.wavelength,
             kLength, Range::positive());
  v.quantity_or({"outer_scale", "L0 of von Karman's spectrum (f^2 + 1/L0^2)^(-11/6) [m]; absent: none",
                 kOptional, "\"25 m\""},
                air.outer_scale, 0, kLength, Range::positive());
}

void describe_other(Visitor& v, OtherSurfaceSpec& surface) {
  v.text({"name", "name in the table of contributors", kRequired, "\"secondary\""}, surface.name, false);
  v.object(
      {"psd", "PSD of its height", kRequired}, nullptr,
      [&](Visitor& psd) { describe_psd_block(psd, surface.psd); }, "psd");
  v.quantity({"footprint", "diameter of the beam on it over that of the pupil"}, surface.footprint, kNumber,
             Range{0, 1e3, true, false});
  v.quantity({"incidence", "angle of incidence [rad]", kOptional, "\"45 deg\""}, surface.incidence, kAngle,
             Range{0, 1.5, false, false});
  std::string of = surface.is_wavefront ? "wavefront" : "surface";
  v.word({"of", "whether its PSD is that of the surface or of the reflected wavefront"}, of,
         {"surface", "wavefront"});
  surface.is_wavefront = of == "wavefront";
}

void describe_contributors(Visitor& v, ContributorsSpec& with) {
  v.list(
      {"surfaces", "further mirrors of the path"}, with.surfaces.size(), 0,
      [&](std::size_t count) { with.surfaces.resize(count); },
      [&](Visitor& surface, std::size_t k) { describe_other(surface, with.surfaces[k]); });
  v.optional_object({"atmosphere", "turbulence, long exposure: Kolmogorov's, or von Karman's"},
                    with.atmosphere, describe_atmosphere);
  v.quantity(
      {"jitter", "RMS motion of the image per axis, as angle on the sky [rad]", kOptional, "\"0.05 arcsec\""},
      with.jitter, kAngle, Range::non_negative());
}

}  // namespace

void describe_solve(Visitor& v, SolveSpec& solve) {
  v.texts({"for",
           "one or two unknown numbers of the roughness (up to four for a measured focus), as JSON pointers "
           "into the study, whose values are the start",
           kOptional, R"(["/roughness/psd/rms"])"},
          solve.unknowns, 1, 4);
  v.optional_object({"ceilings",
                     "instead of `for`: find the largest roughness of each octave alone, and the largest "
                     "lines A/f^B of a drawing; needs no roughness"},
                    solve.ceilings, describe_ceilings);
  v.optional_object({"focus", "instead of `so_that`: a measured focus, whose roughness is to be found"},
                    solve.focus, describe_focus);
  v.check(solve.unknowns.empty() == solve.ceilings.has_value(), solve.ceilings ? "ceilings" : "for",
          solve.ceilings ? "beside `for`" : kMissing,
          solve.ceilings ? "either `for` (numbers of the roughness) or `ceilings` (which need none)"
                         : "solve needs \"for\": [\"/roughness/psd/rms\"], numbers of the roughness, or "
                           "\"ceilings\": {}, which need none");
  for (std::size_t k = 1; k < solve.unknowns.size(); ++k) {
    const auto here = solve.unknowns.begin() + std::ptrdiff_t(k);
    v.check(std::find(solve.unknowns.begin(), here, *here) == here, fmt::format("for/{}", k),
            '"' + *here + "\" again", "different numbers");
  }
  v.check(solve.unknowns.size() <= 2 || solve.focus, "for", fmt::format("{} numbers", solve.unknowns.size()),
          "one or two, for a measured focus up to four");
  Visitor::TextsByKey bounds;
  std::vector<KeyPattern> patterns;
  for (const BudgetKey& key : budget_keys()) patterns.push_back({"", key.regex, key.sample});
  for (const Budget& budget : solve.budgets) bounds.emplace_back(budget.key, budget.bound);
  v.texts_by_key(
      {"so_that",
       "budgets that have to hold, each with <= or >= and a quantity. As length or as angle on the sky: "
       "ee<percent>_radius, ee<percent>_diameter, ensquared<percent>_side, fwhm (also in a plane out of "
       "focus, ee80_diameter@1mm) and hew; strehl, tis, mtf@20/mm, pssn (r0 of 15 cm at 500 nm) or "
       "pssn@0.2m, bsdf@5deg; rms_height (about the mean over the aperture) or rms_height@10/m-100/m, "
       "rms_slope (per axis) or rms_slope@10/m-100/m, structure@10mm (root where the bound is a length), "
       "scatter_rms. Heights may be given as lambda/20",
       kOptional, R"({"ee80_diameter": "<= 0.6 arcsec"})", "It begins with <= or >=; a quantity follows."},
      bounds, patterns, R"(\s*(<=|>=).*)");
  v.check(bounds.empty() == solve.focus.has_value(), solve.focus ? "focus" : "so_that",
          solve.focus ? "beside `so_that`" : kMissing,
          solve.focus ? "either `so_that` (budgets that have to hold) or `focus` (a measurement)"
                      : "solve needs \"so_that\": {\"ee80_diameter\": \"<= 0.6 arcsec\"}, budgets that have "
                        "to hold, or \"focus\", a measurement");
  v.check(!(solve.focus && (solve.ceilings || solve.confidence)), "focus",
          solve.ceilings ? "beside ceilings" : "beside confidence", "only with `for`");
  v.quantity(
      {"contour_decades",
       "for two unknowns: how far the curve is followed on either side of the study's values, in decades"},
      solve.contour_decades, kNumber, Range{0, 4, true, false});
  v.quantity({"confidence",
              "fraction of mirrors of the specification that have to meet the budgets; absent: their mean "
              "PSF has to",
              kOptional, "0.9"},
             solve.confidence, kNumber, Range{0.5, 1, true, true});
  v.optional_object(
      {"with", "other contributors to the blur; their transfer functions multiply that of the mirror"},
      solve.with, describe_contributors);
  v.check(!(solve.with && (solve.ceilings || solve.confidence)), "with",
          solve.ceilings ? "beside ceilings" : "beside confidence", "only with `for`");
  v.check(!(solve.confidence && solve.ceilings), "confidence", "beside ceilings", "with `for`");
  if (!v.reading()) return;
  solve.budgets.clear();
  for (const auto& [key, bound] : bounds) {
    try {
      solve.budgets.push_back(parse_budget(key, bound));
    } catch (const UnitError& error) {
      v.check(false, "so_that/" + key, error.what(),
              "<= or >= and a quantity of its kind, as `aberfit solve --help` lists them");
    }
  }
}

}  // namespace aberfit::internal
