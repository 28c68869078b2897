#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <regex>
#include <string>
#include <vector>

#include "aberfit/method/verify.h"
#include "aberfit/roughness/psd.h"
#include "aberfit/study/study.h"
#include "aberfit/theory/geometric_harvey_shack.h"
#include "aberfit/theory/regime.h"
#include "fits/paper_branches.h"
#include "fits/paper_numbers.h"

/// Formulas of the paper: one function for each name in the column `formula` of numbers.csv, and one
/// condition for each row that needs one.
namespace aberfit::test {

inline constexpr double kArcsec = std::numbers::pi / 180 / 3600;

/// All data that the functions use.
struct Paper {
  const Study& study;
  const VerifyReport& report;
  std::vector<PaperNumber> numbers;
  PaperSum sum;
  PaperFocus ideal, independent;
  Deflections deflections;  ///< of the Harvey-Shack branch

  Paper(const Study& of_study, const VerifyReport& of_report, int threads)
      : study(of_study),
        report(of_report),
        numbers(paper_numbers()),
        sum(paper_sum(study, report.shown->pupil, report.shown->nominal)),
        ideal(paper_focus(report.shown->nominal, report.shown->nominal)),
        independent(independent_zernikes(study, threads)),
        deflections(deflections_of(report.shown->harvey_shack, report.shown->nominal)) {}

  /// The printed value of a row [SI].
  double printed(const std::string& id) const {
    const auto row =
        std::find_if(numbers.begin(), numbers.end(), [&](const PaperNumber& n) { return n.id == id; });
    EXPECT_NE(row, numbers.end()) << id;
    return row == numbers.end() ? std::nan("") : row->value() * row->si;
  }

  // Statistics of the report: means of the two branches, closed forms by rays, generalised Harvey-Shack.
  double of(const std::vector<EquivalenceMetric>& metrics, const char* name,
            double EquivalenceMetric::*member) const {
    const auto at =
        std::find_if(metrics.begin(), metrics.end(), [&](const auto& m) { return m.name == name; });
    EXPECT_NE(at, metrics.end()) << name;
    return at == metrics.end() ? std::nan("") : (*at).*member;
  }
  double hs(const char* name) const { return of(report.metrics, name, &EquivalenceMetric::target); }
  double at(const char* name) const { return of(report.metrics, name, &EquivalenceMetric::model); }
  double ghs(const char* name) const { return of(report.light, name, &EquivalenceMetric::target); }
  double theory(const char* name) const {
    for (std::size_t k = 0; k < report.metrics.size(); ++k)
      if (report.metrics[k].name == name) return report.theory[k];
    ADD_FAILURE() << name;
    return std::nan("");
  }

  /// Ring FWHM over EE90 f/R: 2.81 for a stationary surface, whatever its size.
  double shape(double ring_fwhm, double ee90) const {
    return ring_fwhm / (ee90 * study.mirror.focal_length / aperture_radius(study.aperture));
  }
  double stationary_shape() const { return shape(theory("ring_fwhm_m"), theory("ee90_radius_m")); }

  // Arithmetic on the printed gradients.
  double turn(double gradient) const {
    return printed("wavelength") / (4 * std::numbers::pi) * gradient;  // [rad] of [rad/m]
  }
  double gradient_total() const {
    return std::hypot(printed("hs-gradient-rms-x"), printed("hs-gradient-rms-y"));
  }
  double per_axis() const { return turn(gradient_total() / std::numbers::sqrt2); }
  double mean_deflection() const { return std::sqrt(std::numbers::pi / 2) * per_axis(); }
  /// EE90 of rays with the printed gradients: a Gaussian spot.
  double ee90_of_gradients(Convention convention) const {
    const GeometricHarveyShack spot(study.mirror, study.aperture, per_axis(), convention, 0);
    return std::sqrt(2 * std::log(10.0)) * spot.focal_sigma();
  }
  /// Three standard errors of a mean over the printed number of rays.
  double three_errors(double rms) const { return 3 * rms / std::sqrt(printed("rays")); }

  // The roughness that the paper states, and its formulas for it.
  RadialPsd stated_psd() const {
    return RadialPsd(UniformPsd{printed("sigma"), printed("f-min"), printed("f-max")});
  }
  SceneNumbers stated() const {
    return scene_numbers(stated_psd(), study.mirror, study.aperture, printed("wavelength"));
  }
  double slope_of_band() const { return std::numbers::sqrt2 * stated().rms_slope_per_axis; }
  double printed_slope() const {
    const double a = printed("f-min"), b = printed("f-max");
    return printed("sigma") * std::sqrt((b * b + a * b + a * a) / 3);
  }
};

/// Ratio R = 2 sigma D/(1.22 lambda l_c) of a surface with that correlation length [1].
inline double paper_ratio(double sigma, double l_c, double diameter, double wavelength) {
  const double length = 2 * l_c / std::sqrt(std::numbers::pi);  // int exp(-(r/l)^2) dr = sqrt(pi)/2 l
  const RadialPsd psd(GaussianPsd{sigma, length});
  return scene_numbers(psd, Mirror{2.8, -1, {}}, CircleAperture{diameter}, wavelength).paper_ratio_r;
}
/// Ratio R of a table cell with id R-<sigma>nm-<l_c>um-<D>m, at the table's 500 nm.
inline double ratio_of_cell(const std::string& id) {
  static const std::regex kCell("R-(\\d+)nm-(\\d+)um-([0-9.]+)m");
  std::smatch part;
  if (!std::regex_match(id, part, kCell)) return std::nan("");
  return paper_ratio(std::stod(part[1]) * 1e-9, std::stod(part[2]) * 1e-6, std::stod(part[3]), 500e-9);
}

using PaperFormula = double (*)(const Paper&);

/// Values [SI].
inline const std::map<std::string, PaperFormula> kPaperFormulas = {
    // The scene.
    {"focal_length", [](const Paper& p) { return p.study.mirror.focal_length; }},
    {"aperture_diameter", [](const Paper& p) { return 2 * aperture_radius(p.study.aperture); }},
    {"wavelength", [](const Paper& p) { return double(p.study.wavelength); }},
    {"rays", [](const Paper& p) { return double(p.report.rays); }},
    {"rms_height", [](const Paper& p) { return p.report.scene.numbers.rms_height; }},
    {"correlation_length", [](const Paper& p) { return p.report.scene.numbers.correlation_length; }},
    {"lowest_frequency", [](const Paper& p) { return 1 / p.printed("aperture"); }},
    {"highest_frequency", [](const Paper&) { return PaperSum::kHigh; }},
    // The ideal mirror.
    {"ideal_ring", [](const Paper&) { return kIdealRing; }},
    {"ideal_ee90", [](const Paper& p) { return p.ideal.ee90; }},
    {"ideal_fwhm",
     [](const Paper& p) {
       const VerifyRays& shown = *p.report.shown;
       return evaluate_exact({shown.nominal, shown.nominal, Eigen::ArrayXd(), Centre::kNominal},
                             {RingFwhm{0.9, kIdealRing}}, 1)[0];
     }},
    {"ideal_fwhm_counted",
     [](const Paper& p) { return counted_ring_width(p.report.shown->nominal, kIdealRing); }},
    // One draw of the Harvey-Shack branch.
    {"gradient_x", [](const Paper& p) { return p.deflections.rms_x / p.turn(1); }},
    {"gradient_y", [](const Paper& p) { return p.deflections.rms_y / p.turn(1); }},
    {"axis_ratio", [](const Paper& p) { return p.deflections.rms_x / p.deflections.rms_y; }},
    {"gradient_covariance",
     [](const Paper& p) {
       const Deflections& d = p.deflections;
       return ((d.weight * d.x * d.y).sum() - d.mean_x * d.mean_y) / (p.turn(1) * p.turn(1));
     }},
    {"mean_x", [](const Paper& p) { return p.deflections.mean_x; }},
    {"mean_y", [](const Paper& p) { return p.deflections.mean_y; }},
    {"mean_z", [](const Paper& p) { return p.deflections.mean_z; }},
    {"hs_fwhm_counted",
     [](const Paper& p) {
       const VerifyRays& shown = *p.report.shown;
       return counted_ring_width(shown.harvey_shack, paper_focus(shown.harvey_shack, shown.nominal).ee90);
     }},
    // Means of both branches.
    {"hs_ee90", [](const Paper& p) { return p.hs("ee90_radius_m"); }},
    {"hs_fwhm", [](const Paper& p) { return p.hs("ring_fwhm_m"); }},
    {"hs_shape", [](const Paper& p) { return p.shape(p.hs("ring_fwhm_m"), p.hs("ee90_radius_m")); }},
    {"at_ee90", [](const Paper& p) { return p.at("ee90_radius_m"); }},
    {"at_shape", [](const Paper& p) { return p.shape(p.at("ring_fwhm_m"), p.at("ee90_radius_m")); }},
    {"at_scatter_rms", [](const Paper& p) { return p.at("scatter_rms_rad"); }},
    {"at_scatter_mean", [](const Paper& p) { return p.at("scatter_mean_rad"); }},
    {"error_of_rays", [](const Paper& p) { return p.theory("ee90_radius_m") / p.ghs("ee90_radius_m") - 1; }},
    // Zernikes with independent coefficients.
    {"independent_ee90", [](const Paper& p) { return p.independent.ee90; }},
    {"independent_fwhm", [](const Paper& p) { return p.independent.ring_fwhm; }},
    {"independent_scatter_rms", [](const Paper& p) { return p.independent.scatter_rms; }},
    {"independent_shape",
     [](const Paper& p) { return p.shape(p.independent.ring_fwhm, p.independent.ee90); }},
    // The sum of section 5.3, literally and with the cells of section 5.5.
    {"gradient_of_literal_sum",
     [](const Paper& p) {
       const double modes = 1e4, ratio = p.printed("f-max") / p.printed("f-min");
       return 2 * std::numbers::pi * p.printed("f-max") *
              std::sqrt(modes * p.printed("p0-value") / (4 * std::log(ratio)));
     }},
    {"sum_gradient", [](const Paper& p) { return p.sum.gradient; }},
    {"sum_gradient_expected", [](const Paper& p) { return p.sum.expected_gradient; }},
    {"sum_height", [](const Paper& p) { return p.sum.height; }},
    {"sum_ee90", [](const Paper& p) { return p.sum.focus.ee90; }},
    // Arithmetic on the printed gradients.
    {"printed_axis_ratio",
     [](const Paper& p) { return p.printed("hs-gradient-rms-x") / p.printed("hs-gradient-rms-y"); }},
    {"covariance_share",
     [](const Paper& p) {
       return std::abs(p.printed("hs-covariance")) / std::pow(p.printed("hs-gradient-rms-x"), 2);
     }},
    {"gradient_total", [](const Paper& p) { return p.gradient_total(); }},
    {"metres_per_radian", [](const Paper& p) { return p.turn(1); }},
    {"deflection_x", [](const Paper& p) { return p.turn(p.printed("hs-gradient-rms-x")); }},
    {"deflection_y", [](const Paper& p) { return p.turn(p.printed("hs-gradient-rms-y")); }},
    {"deflection_z",  // std of its component along the axis, to first order
     [](const Paper& p) {
       return p.per_axis() * (p.printed("aperture") / 2) / (p.printed("focal-length") * std::numbers::sqrt2);
     }},
    {"mean_deflection", [](const Paper& p) { return p.mean_deflection(); }},  // of a Rayleigh law
    {"rms_deflection", [](const Paper& p) { return p.turn(p.gradient_total()); }},
    {"deflection_of_theory", [](const Paper& p) { return p.turn(p.printed("hs-gradient-theory")); }},
    {"ratio_of_deflections",
     [](const Paper& p) { return p.printed("hs-deflection-mean") / p.printed("hs-deflection-theory"); }},
    {"angle_of_99_percent", [](const Paper& p) { return std::sqrt(2 * std::log(100.0)) * p.per_axis(); }},
    {"bias",
     [](const Paper& p) {
       return std::hypot(p.printed("hs-mean-x"), p.printed("hs-mean-y"), p.printed("hs-mean-z")) /
              p.mean_deflection();
     }},
    {"ee90_of_gradients", [](const Paper& p) { return p.ee90_of_gradients(Convention::kPaper); }},
    {"ee90_by_reflection", [](const Paper& p) { return p.ee90_of_gradients(Convention::kPhysical); }},
    // Arithmetic on other printed numbers.
    {"fwhm_growth", [](const Paper& p) { return p.printed("hs-fwhm") / p.printed("ideal-fwhm"); }},
    {"fwhm_difference", [](const Paper& p) { return p.printed("hs-fwhm") - p.printed("at-fwhm"); }},
    {"ee90_growth", [](const Paper& p) { return p.printed("at-ee90") / p.printed("ideal-ee90"); }},
    {"ee90_difference", [](const Paper& p) { return p.printed("hs-ee90") - p.printed("at-ee90"); }},
    {"scatter_difference",
     [](const Paper& p) { return 1 - p.printed("at-scatter-rms") / p.printed("hs-scatter-rms"); }},
    {"branch_difference",
     [](const Paper& p) {
       return std::max(1 - p.printed("at-ee90") / p.printed("hs-ee90"),
                       1 - p.printed("at-fwhm") / p.printed("hs-fwhm"));
     }},
    {"printed_shape", [](const Paper& p) { return p.shape(p.printed("at-fwhm"), p.printed("at-ring")); }},
    {"fwhm_in_printed_ring",
     [](const Paper& p) { return p.stationary_shape() * p.printed("at-ring") / p.shape(1, 1); }},
    {"largest_angle", [](const Paper& p) { return std::asin(p.printed("wavelength") * p.printed("f-max")); }},
    // The stated roughness.
    {"level_2d", [](const Paper& p) { return p.stated_psd()(1e3); }},
    {"level_1d",
     [](const Paper& p) {
       return std::pow(p.printed("sigma"), 2) / (p.printed("f-max") - p.printed("f-min"));
     }},
    {"slope_of_band", [](const Paper& p) { return p.slope_of_band(); }},
    {"printed_scatter", [](const Paper& p) { return 2 * p.printed_slope(); }},
    {"length_of_band", [](const Paper& p) { return p.stated().correlation_length; }},
    {"slope_scale", [](const Paper& p) { return p.printed("sigma") / p.printed("lc-footnote"); }},
    {"two_slopes", [](const Paper& p) { return 2 * p.printed("sigma") / p.printed("lc-footnote"); }},
    {"phase_of_height", [](const Paper& p) { return p.printed("sigma") / p.turn(1); }},
    {"gradient_scale",
     [](const Paper& p) { return p.printed("sigma") / p.printed("lc-footnote") / p.turn(1); }},
    {"terms_in_two_dimensions",
     [](const Paper& p) { return std::pow(p.printed("aperture") / 2 / p.printed("lc-footnote"), 2) / 2; }},
    // Blur against diffraction.
    {"blur",
     [](const Paper& p) {
       return 2 * p.printed("focal-length") * p.printed("sigma") / p.printed("lc-footnote");
     }},
    {"airy_radius",
     [](const Paper& p) {
       return 1.22 * p.printed("wavelength") * p.printed("focal-length") / p.printed("aperture");
     }},
    {"blur_over_airy",
     [](const Paper& p) { return kPaperFormulas.at("blur")(p) / kPaperFormulas.at("airy_radius")(p); }},
    {"ratio_over_f_numbers",  // at f/3 over that at f/15
     [](const Paper& p) {
       const auto ratio = [&](double n) {
         return 2 * n * p.printed("ex-sigma") / p.printed("ex-lc") / (1.22 * p.printed("ex-wavelength") * n);
       };
       return ratio(3) / ratio(15);
     }},
    {"error_of_table",
     [](const Paper& p) { return p.printed("R-1nm-1um-1.0m") / ratio_of_cell("R-1nm-1um-1.0m") - 1; }},
    {"smallest_cell", [](const Paper&) { return ratio_of_cell("R-1nm-100um-0.2m"); }},
    {"main_ratio",
     [](const Paper& p) {
       return paper_ratio(p.printed("sigma"), p.printed("main-lc"), p.printed("aperture"),
                          p.printed("range-wavelength"));
     }},
    {"main_ratio_633nm",
     [](const Paper& p) {
       return paper_ratio(p.printed("sigma"), p.printed("main-lc"), p.printed("aperture"),
                          p.printed("wavelength"));
     }},
    {"main_ratio_1mm",
     [](const Paper& p) {
       return paper_ratio(p.printed("sigma"), p.printed("lc-footnote"), p.printed("aperture"),
                          p.printed("wavelength"));
     }},
    {"specular_share",  // of 1 nm at 500 nm
     [](const Paper& p) {
       return 1 -
              scene_numbers(RadialPsd(GaussianPsd{1e-9, 1e-4}), p.study.mirror, p.study.aperture, 500e-9).tis;
     }},
    // The worked example.
    {"example_blur",
     [](const Paper& p) {
       return 2 * p.printed("ex-f-number") * p.printed("ex-diameter") * p.printed("ex-sigma") /
              p.printed("ex-lc");
     }},
    {"example_airy",
     [](const Paper& p) { return 1.22 * p.printed("ex-wavelength") * p.printed("ex-f-number"); }},
    {"example_ratio", [](const Paper& p) { return p.printed("ex-rgeom") / p.printed("ex-rdiff"); }},
    {"example_orders", [](const Paper& p) { return std::log10(p.printed("ex-ratio")); }},
    {"example_height", [](const Paper& p) { return p.printed("ex-sigma") / p.printed("sigma"); }},
};

inline double paper_formula(const Paper& p, const PaperNumber& row) {
  return row.formula == "cell" ? ratio_of_cell(row.id) : kPaperFormulas.at(row.formula)(p);
}

/// Whether a ratio is 1 to a relative difference.
inline bool is_one(double ratio, double within) { return std::abs(ratio - 1) < within; }

using PaperCondition = bool (*)(const Paper&, double ours, double printed);

/// Conditions by the id of the row; both values in SI units.
inline const std::map<std::string, PaperCondition> kPaperConditions = {
    {"xi", [](const Paper& p, double ours, double) { return is_one(ours / p.stationary_shape(), 0.05); }},
    {"rule-term-count",
     [](const Paper& p, double ours, double) {
       return is_one(std::numbers::pi * p.printed("aperture") / p.printed("lc-footnote") / ours, 0.5);
     }},
    {"small-angle", [](const Paper&, double ours, double) { return ours < 0.05; }},
    {"ideal-focus", [](const Paper& p, double ours,
                       double printed) { return std::abs(ours - printed) < 0.05 && p.ideal.ee90 < 1e-12; }},
    {"ideal-resolution", [](const Paper&, double ours, double) { return ours < 1e-12; }},
    {"hs-covariance",
     [](const Paper& p, double, double printed) {
       return std::abs(printed) <
              p.three_errors(p.printed("hs-gradient-rms-x") * p.printed("hs-gradient-rms-y"));
     }},
    {"hs-covariance-share", [](const Paper&, double ours, double printed) { return ours < printed; }},
    {"eq-phase-sum", [](const Paper& p, double ours,
                        double) { return is_one(ours / p.printed("hs-gradient-rms-total"), 0.05); }},
    {"p0-1d", [](const Paper& p, double ours, double) { return is_one(ours / p.stated_psd()(1e3), 0.01); }},
    {"eq-cell",
     [](const Paper& p, double, double) {
       const double ratio = p.printed("f-max") / p.printed("f-min");
       return is_one(std::log10(ratio) / std::log(ratio), 0.01);
     }},
    {"hs-scatter-range", [](const Paper&, double ours, double) { return ours < 8 * kArcsec; }},
    {"projection", [](const Paper& p, double ours,
                      double) { return is_one(ours / p.printed("hs-deflection-std-z"), 0.01); }},
    {"hs-mean-x",
     [](const Paper& p, double, double printed) {
       return std::abs(printed) < p.three_errors(p.turn(p.printed("hs-gradient-rms-x")));
     }},
    {"hs-mean-y",
     [](const Paper& p, double, double printed) {
       return std::abs(printed) < p.three_errors(p.turn(p.printed("hs-gradient-rms-y")));
     }},
    {"hs-mean-z",
     [](const Paper& p, double, double printed) {
       return std::abs(printed) < p.three_errors(p.printed("hs-deflection-std-z"));
     }},
    {"hs-scatter-prediction",
     [](const Paper& p, double ours, double) { return is_one(ours / p.printed("hs-deflection-mean"), 0.1); }},
    {"eq-slope", [](const Paper& p, double ours, double) { return is_one(p.printed_slope() / ours, 0.01); }},
    {"eq-scatter",
     [](const Paper& p, double ours, double) { return is_one(ours / p.printed("hs-deflection-mean"), 0.1); }},
    {"eq-at-surface",
     [](const Paper& p, double ours, double) { return is_one(ours / p.printed("hs-ee90"), 0.1); }},
    // Differences of the branches, compared with three standard errors of a difference of ray statistics.
    {"fwhm-similar",
     [](const Paper& p, double ours, double) { return ours < 3 * 0.01 * p.printed("hs-fwhm"); }},
    {"ee90-difference",
     [](const Paper& p, double ours, double) { return ours < 3 * 0.0072 * p.printed("hs-ee90"); }},
    {"equivalence", [](const Paper&, double ours, double) { return ours < 3 * 0.0072; }},
    {"scatter-difference", [](const Paper&, double ours, double printed) { return ours < printed; }},
    {"scatter-within-noise", [](const Paper&, double ours, double) { return ours < 2 * 0.0060; }},
    {"ee90-increase", [](const Paper&, double ours, double) { return ours >= 10; }},
    {"not-systematic",
     [](const Paper& p, double ours, double) { return is_one(ours / p.stationary_shape(), 0.05); }},
    {"eq-phase-height",
     [](const Paper& p, double ours, double) { return is_one(ours / p.report.scene.numbers.g, 1e-9); }},
    {"eq-gradient-scale", [](const Paper& p, double ours,
                             double) { return is_one(ours / p.printed("hs-gradient-rms-total"), 0.5); }},
    {"eq-ratio", [](const Paper& p, double ours,
                    double) { return is_one(ours / kPaperFormulas.at("main_ratio_1mm")(p), 1e-9); }},
    {"f-number-free", [](const Paper&, double ours, double) { return is_one(ours, 1e-9); }},
    {"lc-band", [](const Paper& p, double ours, double) { return is_one(ours * p.printed("f-max"), 0.1); }},
    {"lc-integral",
     [](const Paper& p, double ours, double) {
       const auto& psd = std::get<UniformPsd>(*p.study.psd);
       return is_one(ours * std::numbers::pi * (psd.f_max + psd.f_min), 1e-6);
     }},
    {"R-table", [](const Paper&, double ours, double) { return std::abs(ours) < 0.002; }},
    {"ex-orders", [](const Paper&, double ours, double printed) { return ours > printed; }},
    {"ex-aligns", [](const Paper&, double ours, double) { return is_one(ours, 0.1); }},
    {"regime-rays", [](const Paper&, double ours, double) { return std::abs(ours) < 0.01; }},
    {"dominance-limits", [](const Paper&, double ours, double) { return ours < 0.5; }},
    {"r-above-10", [](const Paper&, double ours, double printed) { return ours > printed; }},
    {"transition-limits", [](const Paper&, double ours, double) { return is_one(ours, 0.5); }},
};

}  // namespace aberfit::test
