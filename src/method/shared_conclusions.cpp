#include "shared_conclusions.h"

#include <fmt/format.h>

#include "aberfit/method/judge.h"
#include "aberfit/roughness/psd_in_band.h"

namespace aberfit::internal {
namespace {

std::string spread_source(const Groundwork& ground, const Realisation& realisation) {
  std::string text = fmt::format("0.65/sqrt(N_eff), N_eff = {:.0f}", ground.numbers.n_eff);
  if (realisation.draws > 0)
    text = fmt::format("{:.1f} % by {}, {:.1f} % over {} draws", 100 * realisation.predicted, text,
                       100 * realisation.measured, realisation.draws);
  return text;
}

// B that OpticStudio takes is too large for the knee of a mirror metres across.
constexpr double kPoorAbg = 0.1, kFreeB = 1e-30;

}  // namespace

void ask_perfect_mirror(const FitCase& of, FitOutcome* result) {
  result->perfect = judge_perfect_mirror(of);
  if (result->perfect && result->perfect->mismatch < 1)
    result->warnings.push_back(
        {"margin-sees-nothing",
         fmt::format("the perfect mirror would pass, too: its worst statistic, {}, is {:.2g} of a tolerance "
                     "away, so a margin of {:.3g} % cannot see this roughness; take a smaller margin",
                     result->perfect->statistic, result->perfect->mismatch,
                     100 * of.task.equivalence.margin)});
}

void warn_of_realisations(const FitCase& of, const std::string& holds_for, FitOutcome* result) {
  if (!result->realisation || !(result->realisation->spread() > of.task.equivalence.margin)) return;
  result->warnings.push_back(
      {"realisation-spread",
       fmt::format("draws of this roughness differ by {:.1f} % in ee90 ({}): the verdict holds for {}",
                   100 * result->realisation->spread(), spread_source(of.ground, *result->realisation),
                   holds_for)});
}

void tell_scatter_of_rest(const FitCase& of, FitOutcome* result) {
  if (!of.ground.split || !of.ground.split->has_rest()) return;
  of.context.say("scatter");
  const RadialPsd& rest = of.ground.split->rest();
  const ScatterFunction function(rest, of.task.wavelength);
  ScatterOfRest& scatter = result->scatter.emplace();
  scatter.table = scatter_table(function);
  scatter.rest = psd_in_band(*of.task.psd, rest.f_min(), rest.f_max());
  const AbgFit common = fit_abg(function);
  if (!common.found) return;
  scatter.abg.push_back(common);
  if (!common.at_least_b || common.largest_error < kPoorAbg) return;
  AbgOptions free;
  free.least_b = kFreeB;
  scatter.abg.push_back(fit_abg(function, free));
}

}  // namespace aberfit::internal
