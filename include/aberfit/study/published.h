#pragma once
#include <string>
#include <vector>

#include "aberfit/study/study.h"

namespace aberfit {

/// Names of the formulas that `verify.published[].formula` may ask for.
const std::vector<std::string>& published_formulas();

/// Value [SI] of a formula on its inputs; what they leave out comes from the study. NaN when neither has it.
///   total_gradient            sqrt(gx^2 + gy^2)                                     [rad/m]
///   deflection_x, _y          lambda/(4 pi) g                                       [rad]
///   mean_deflection           Rayleigh mean sqrt(pi/2) of the per-axis RMS          [rad]
///   rms_deflection            lambda/(4 pi) total gradient                          [rad]
///   focal_shift_std           per-axis deflection * R/(f sqrt 2), first order       [m]
///   largest_angle             asin(lambda f_max), grating equation at normal incidence [rad]
///   paper_ratio_r             2 sigma D/(1.22 lambda l_c)                           [1]
///   uniform_psd_2d            sigma^2/(pi (f_max^2 - f_min^2))                      [m^4]
///   uniform_psd_1d            sigma^2/(f_max - f_min)                               [m^3]
///   uniform_slope_total       2 pi sigma sqrt((f_max^2 + f_min^2)/2)                [1]
double evaluate_formula(const std::string& name, const FormulaInputs& inputs, const Study& study);

}  // namespace aberfit
