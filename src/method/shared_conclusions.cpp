#include "shared_conclusions.h"

#include <fmt/format.h>

#include "aberfit/method/constants.h"
#include "aberfit/method/judge.h"
#include "aberfit/roughness/psd_in_band.h"

namespace aberfit::internal {
namespace {}  // namespace

void ask_perfect_mirror(const FitCase& of, FitOutcome* result) {
  result->judgement.perfect = judge_perfect_mirror(of);
  if (result->judgement.perfect && result->judgement.perfect->mismatch < 1)
    result->warnings.push_back(
        {"margin-sees-nothing",
         fmt::format(
             "the perfect mirror would also pass: its worst statistic, {}, is only {:.2g} tolerances from "
             "the target. A margin of {:.3g} % cannot detect this roughness; take a smaller margin",
             result->judgement.perfect->statistic, result->judgement.perfect->mismatch,
             100 * of.task.equivalence.margin)});
}

void tell_spread(const FitCase& of, FitOutcome* result) {
  result->scene.spread = mirror_spread(of.task, of.ground, of.targets, of.context.threads);
  result->scene.spread.tell(&result->judgement.metrics);
  if (result->judgement.light) result->scene.spread.tell(&result->judgement.light->metrics);
}

void warn_of_spread(const std::string& holds_for, FitOutcome* result) {
  const StatisticSpread* worst = result->scene.spread.worst();
  if (!worst || !(worst->tolerances > 1)) return;
  result->warnings.push_back(
      {"realisation-spread",
       fmt::format(
           "mirrors of this specification vary by up to {}, one standard deviation; the verdict holds for {}",
           spread_words(*worst), holds_for)});
}

void tell_scatter_of_rest(const FitCase& of, FitOutcome* result) {
  if (!of.ground.split || !of.ground.split->has_rest()) return;
  of.context.say("scatter");
  const RadialPsd& rest = of.ground.split->rest();
  const ScatterFunction function(rest, of.task.wavelength);
  ScatterOfRest& scatter = result->band.scatter.emplace();
  scatter.table = scatter_table(function);
  scatter.rest = psd_in_band(*of.task.psd, rest.f_min(), rest.f_max());
  const AbgFit common = fit_abg(function);
  if (!common.found) return;
  scatter.abg.push_back(common);
  if (!common.at_least_b || common.largest_error < law::kNoteworthy) return;
  // OpticStudio's least B is too large for the knee of a mirror metres across; this fit has almost no limit.
  AbgOptions free;
  free.least_b = 1e-30;
  scatter.abg.push_back(fit_abg(function, free));
}

}  // namespace aberfit::internal
