#pragma once
#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>

#include "sanitized.h"

namespace aberfit {

inline constexpr double kLongestFit = test::kSanitized ? 1200 : 120;  ///< [s] of processor time, one thread

/// Runs scene k of `seed` through the program, `check` and then `fit`, each a process of its own under the
/// time limit, and judges the result by tools of the tests' own. folder: an empty one, for all its files. The
/// row says
///   seed, row, name, classes, open     which scene
///   outcome                            equivalent, undecided, different; refused; crash, time-out (of
///   processor time), hang (of the clock) iteration_s, checked_terms         what `check` says of one
///   iteration [s], and of the terms check_s, fit_s                     processor time, which other work on
///   the machine does not lengthen exit, message                      of a refusal, a crash or a time-out,
///   and of which command remedy                             whether the message says what to do mismatch,
///   statistic                largest difference that the verdict was on, in margins rms_ratio, slope_ratio
///   of terms and scatter together, over the specification's carried                            share of the
///   specification's slope variance that the terms can carry cells, terms, model, theory, status, warnings
///   (codes), says (what it says of itself) second                             of whom the second opinion is,
///   how many margins off, or why there is
///                                      none
///   second_of_targets                  the same on the targets, which need no fit
/// with nothing where there is nothing to say.
nlohmann::json run_row(std::uint64_t seed, int k, const std::filesystem::path& folder);

/// Scene and second_of_targets of a row, without running the program.
nlohmann::json opinion_on_targets(std::uint64_t seed, int k, const std::filesystem::path& folder);

/// Returns the failure of a row in words; empty if it has none. Failures: crash, hang, time-out, refusal
/// without a remedy, a surface that is absurd for its specification, targets or a verdict that a second
/// opinion contradicts.
std::string failure_of(const nlohmann::json& row);

}  // namespace aberfit
