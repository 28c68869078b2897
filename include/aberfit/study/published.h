#pragma once
#include <string>
#include <vector>

#include "aberfit/study/study.h"

namespace aberfit {

/// Names of the formulas that `verify.published[].formula` may ask for.
const std::vector<std::string>& published_formulas();

/// Words that `verify.published[].verdict` may be:
///   holds, fails      compared with ours, or argued in the reading
///   reading           holds only as the reading says, which the source does not
///   input             what the source starts from
///   not-stated        needed there, and not given
///   not-reproducible  follows from nothing that the source states
///   untested          nothing to compare
///   picture           answered by a picture
const std::vector<std::string>& published_verdicts();

/// Every row of study.verify.published with ours beside it [printed unit], the tolerance and the verdict: of
/// the comparison where there is one (`fails` where it does not hold), else as the row has it. Expressions
/// know the quantities by their keys, `printed.ID` as the printed value of the row of that id [SI], and in
/// `holds` also `ours` and `printed` of their own row [printed unit]; in a name, what is neither letter nor
/// digit nor point is written '_'. Throws InputError for what a row names and nobody knows.
std::vector<PublishedComparison> compare_published(const Study& study, const Quantities& quantities);

/// Half a unit of the last digit of a number as printed: 0.005e-5 for "1.57e-5". NaN for what is no number.
double half_last_digit(const std::string& printed);

/// Value [SI] of a formula on its inputs; what they leave out comes from the study. NaN when neither has it.
///   total_gradient            sqrt(gx^2 + gy^2)                                     [rad/m]
///   deflection_x, _y          lambda/(4 pi) g                                       [rad]
///   mean_deflection           Rayleigh mean sqrt(pi/2) of the per-axis RMS          [rad]
///   rms_deflection            lambda/(4 pi) total gradient                          [rad]
///   focal_shift_std           per-axis deflection * R/(f sqrt 2), first order: std of the
///                             deflection's component along the axis (its name is old)  [1]
///   largest_angle             asin(lambda f_max), grating equation at normal incidence [rad]
///   paper_ratio_r             2 sigma D/(1.22 lambda l_c)                           [1]
///   uniform_psd_2d            sigma^2/(pi (f_max^2 - f_min^2))                      [m^4]
///   uniform_psd_1d            sigma^2/(f_max - f_min)                               [m^3]
///   uniform_slope_total       2 pi sigma sqrt((f_max^2 + f_min^2)/2)                [1]
double evaluate_formula(const std::string& name, const FormulaInputs& inputs, const Study& study);

}  // namespace aberfit
