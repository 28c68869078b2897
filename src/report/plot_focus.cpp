#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <set>
#include <tuple>

#include "focal_frame.h"
#include "picture.h"

namespace aberfit::internal {
namespace {

struct Branch {
  const char* key;  // in file names
  const char* label;
  const FocalLight* light;
  int column;  // of the curves
  int line;    // gnuplot line type
};

// Ideal, target and fitted, the target only where there is one.
std::vector<Branch> branches(const PlotInput& input) {
  std::vector<Branch> all = {{"ideal", "ideal mirror", &input.ideal, 2, 1}};
  if (input.target) all.push_back({"target", "target (Harvey-Shack)", input.target, 3, 2});
  all.push_back({"fitted", "fitted surface", &input.fitted, 4, 3});
  return all;
}

const FocalLight& reference(const PlotInput& input) { return input.target ? *input.target : input.fitted; }

const char* reference_name(const PlotInput& input) { return input.target ? "target" : "fitted surface"; }

double spot_scale(const PlotInput& input) {
  return internal::spot_scale(input.core_sigma, {&input.fitted, &input.ideal});
}

std::string length_text(double value) {
  return std::isfinite(value) ? display(value, Dimension::kLength) : "none";
}

// A plane [m] that is no further before the focus than nine tenths of the way to the mirror - rings of light
// that scatters widely fade only beyond - nor than the light of the surface is known.
double within_reach(const PlotInput& input, double dz) {
  const double farthest = std::min(0.9 * input.mirror.focal_length, input.fitted.farthest_plane());
  return std::clamp(dz, -farthest, farthest);
}

// f sigma_f / R: the defocus at which the geometric blur of the rim equals the spot.
double plane_unit(const PlotInput& input) {
  return input.mirror.focal_length * spot_scale(input) / aperture_radius(input.aperture);
}

// Step between tics of about `wanted`: 1, 2 or 5 times a power of ten.
double nice_step(double wanted) {
  if (!(wanted > 0)) return 1;
  const double decade = std::pow(10.0, std::floor(std::log10(wanted)));
  for (const double factor : {1.0, 2.0, 5.0})
    if (wanted <= factor * decade) return factor * decade;
  return 10 * decade;
}

// Targets of EE radii at the focus: (radius, fraction).
std::pair<Eigen::ArrayXd, Eigen::ArrayXd> fitted_fractions(const ResultDocument& result) {
  std::vector<double> radius, fraction;
  for (const Target& target : result.targets)
    if (const auto* ee = std::get_if<EncircledEnergyRadius>(&target.statistic); ee && ee->dz == 0) {
      radius.push_back(target.value);
      fraction.push_back(ee->fraction);
    }
  return {array_of(radius), array_of(fraction)};
}

// Radii that a curve is known by.
struct EeRadii {
  Branch branch;
  double ee50 = 0, ee90 = 0;
  bool is_point = false;  // a perfect focus has radii of rounding errors, which nobody wants to read
};

// EE(r) of all surfaces, NaN without a target, and the EE radii the fit was asked for.
struct EeCurves {
  double last = 0;  // of the radii
  std::vector<EeRadii> known_by;
  Eigen::ArrayXd radii, ideal, target, fitted;
  double n_eff = NAN;    // points that the target's shares are counted from
  Eigen::ArrayXd error;  // of the target
  Eigen::ArrayXd asked_radius, asked_fraction;
};

EeCurves ee_curves(const PlotInput& input) {
  constexpr int kPoints = 501;
  EeCurves curves;
  const double reach = std::max(curve_end(reference(input)), curve_end(input.fitted));
  std::tie(curves.asked_radius, curves.asked_fraction) = fitted_fractions(input.result);
  const double asked = curves.asked_radius.size() > 0 ? curves.asked_radius.maxCoeff() : 0.0;
  curves.last = reach > 0 ? std::max(1.2 * reach, 1.05 * asked) : 4 * spot_scale(input);
  curves.radii = Eigen::ArrayXd::LinSpaced(kPoints, 0.0, curves.last);
  curves.target = Eigen::ArrayXd::Constant(kPoints, NAN);
  curves.ideal = input.ideal.encircled_energy(curves.radii);
  if (input.target) curves.target = input.target->encircled_energy(curves.radii);
  curves.fitted = input.fitted.encircled_energy(curves.radii);
  if (input.target) curves.n_eff = input.target->sample_size();
  curves.error = (curves.target * (1.0 - curves.target) / curves.n_eff).sqrt();  // binomial
  for (const Branch& branch : branches(input)) {
    const double ee50 = branch.light->statistic(EncircledEnergyRadius{0.5, 0.0});
    const double ee90 = branch.light->statistic(EncircledEnergyRadius{0.9, 0.0});
    curves.known_by.push_back({branch, ee50, ee90, ee90 < 1e-6 * curves.last});
  }
  return curves;
}

// Lines from the axis to the curves at ee50 and ee90.
std::string ee_arrows(const EeCurves& curves, const AxisUnit& unit) {
  std::string arrows;
  for (const auto& [branch, ee50, ee90, is_point] : curves.known_by)
    if (!is_point && !std::isnan(ee90) && branch.column > 2)
      arrows += fmt::format(
          "set arrow from {0:.9g},0 to {0:.9g},0.5 nohead linetype {2} linewidth 0.8\n"
          "set arrow from {1:.9g},0 to {1:.9g},0.9 nohead linetype {2} linewidth 0.8\n",
          ee50 * unit.per_si, ee90 * unit.per_si, branch.line);
  return arrows;
}

// What gnuplot's `plot` shows of a branch; `text` goes into the key.
std::string curve_of(const Branch& branch, const std::string& name, const std::string& text) {
  return fmt::format("'{}.dat' using ($1*u):{} with lines linetype {} title {}", name, branch.column,
                     branch.line, gnuplot_text(fmt::format("{}: {}", branch.label, text)));
}

// The curves of all shares, and the values fitted to.
std::string ee_lines(const EeCurves& curves, const std::string& name) {
  std::vector<std::string> lines;
  for (const auto& [branch, ee50, ee90, is_point] : curves.known_by)
    lines.push_back(curve_of(
        branch, name, is_point ? "a point" : "ee50 " + length_text(ee50) + ", ee90 " + length_text(ee90)));
  if (curves.asked_radius.size() > 0)
    lines.push_back(
        "'ee_targets.dat' using ($1*u):2 with points pointtype 6 pointsize 1.4 linewidth 1.5 linecolor rgb "
        "'black' title 'values fitted to'");
  return fmt::format("{}", fmt::join(lines, kNextCurve));
}

// fitted - target with one standard error of the target's rays.
std::string ee_difference_panel(const EeCurves& curves, const AxisUnit& unit, const std::string& name) {
  const double difference =
      std::max((curves.fitted - curves.target).abs().maxCoeff(), curves.error.maxCoeff());
  return fmt::format(
      "unset arrow\n"
      "set size 1,0.34\nset origin 0,0\n"
      "set format x '%g'\nset xlabel 'radius [{0}]'\n"
      "set ylabel 'difference [% of light]'\n"
      "set autoscale y\nset ytics {3:.9g}\n"
      "plot {4}0 with lines dashtype 1 linecolor rgb '#666666' linewidth 1 notitle, \\\n"
      "  '{1}.dat' using ($1*u):(100*($4-$3)) with lines linetype 3 linecolor rgb '{2}' linewidth 2 title "
      "'fitted - target'\n",
      unit.name, name, kFittedColour, nice_step(100 * difference / 2),
      std::isfinite(curves.n_eff)
          ? fmt::format("'{}.dat' using ($1*u):(-100*$5):(100*$5) with filledcurves fillcolor rgb '#cfe3f2' "
                        "title 'sampling error of the target, 1 sigma', \\\n  ",
                        name)
          : "");
}

}  // namespace

/// EE(r) at z = f, below it the difference fitted - target with one standard error of the target's rays.
Picture ee_curves_picture(const PlotInput& input) {
  const std::string name = "ee_curves";
  const EeCurves curves = ee_curves(input);
  Picture picture{name, script_head(name, 1200, 950), {}};
  picture.add_columns(
      name + ".dat",
      {"Share of the light within a radius of the centre at z = f",
       "columns: radius_m ideal target fitted standard_error_of_target (shares; nan: no target)"},
      {curves.radii, curves.ideal, curves.target, curves.fitted, curves.error});
  if (curves.asked_radius.size() > 0)
    picture.add_columns(
        "ee_targets.dat",
        {"Encircled-energy radii the fit was asked for at z = f", "columns: radius_m fraction"},
        {curves.asked_radius, curves.asked_fraction});

  const AxisUnit unit = length_unit(curves.last);
  picture.script += ee_arrows(curves, unit);
  picture.script += fmt::format(
      "u = {:.9g}  # axis units per metre\n"
      "set xrange [0:{:.9g}]\n"
      "set lmargin 11\nset rmargin 3\n"
      "set multiplot title {} font 'DejaVu Sans,16'\n"
      "set size 1,{}\nset origin 0,{}\n"
      "set ylabel 'share of the light within the radius'\n"
      "set yrange [0:1.05]\nset ytics 0.1\n"
      "set key maxcols 2\n"
      "{}plot {}\n",
      unit.per_si, curves.last * unit.per_si, picture_title(input, "Encircled energy at z = f"),
      input.target ? 0.63 : 0.95, input.target ? 0.32 : 0.0,
      input.target ? "set format x ''\n" : fmt::format("set xlabel 'radius [{}]'\n", unit.name),
      ee_lines(curves, name));
  if (input.target) picture.script += ee_difference_panel(curves, unit, name);
  picture.script += "unset multiplot\n";
  return picture;
}

namespace {

// The FWHM through a ring, where the curve of it has both halves: a search for planes that the picture does
// not show takes minutes, and nobody could see what it found.
std::string width_text(const FocalLight& light, double ring, const Eigen::ArrayXd& curve) {
  double peak = 0, first = NAN, last = NAN;
  for (const double share : curve) {
    if (!std::isfinite(share)) continue;
    if (std::isnan(first)) first = share;
    last = share;
    peak = std::max(peak, share);
  }
  if (first < 0.5 * peak && last < 0.5 * peak) return length_text(light.statistic(RingFwhm{0.9, ring}));
  return std::isfinite(last) ? "beyond these planes" : "none";
}

using Curve = std::map<double, double>;  // share of the light inside a ring, by plane [m]

// The polynomial through the two points on either side of a plane, without the plane itself.
double by_neighbours(const Curve& curve, double plane) {
  std::vector<Curve::const_iterator> about;
  for (auto at = curve.upper_bound(plane); at != curve.end() && about.size() < 2; ++at) about.push_back(at);
  const std::size_t above = about.size();
  for (auto at = curve.lower_bound(plane); at != curve.begin() && about.size() < above + 2;)
    about.push_back(--at);
  double sum = 0;
  for (const auto& i : about) {
    double weight = 1;
    for (const auto& j : about)
      if (j != i) weight *= (plane - j->first) / (i->first - j->first);
    sum += weight * i->second;
  }
  return sum;
}

// A plane of light may take a tenth of a second, so there are as few as a smooth line needs: half as far
// apart again beside every plane that its neighbours do not foretell. Halfway between planes a cubic errs by
// a seventh of such a miss, here less than two pixels.
Eigen::ArrayXd smooth_curve(const FocalLight& light, double ring, const Eigen::ArrayXd& drawn) {
  constexpr int kFirst = 21, kRounds = 2;
  constexpr double kMiss = 0.01;
  Curve known;
  Eigen::ArrayXd planes = Eigen::ArrayXd::LinSpaced(kFirst, drawn[0], drawn[drawn.size() - 1]);
  for (int round = 0; planes.size() > 0; ++round) {
    const Eigen::ArrayXd share = light.ring_through(ring, planes);
    for (Eigen::Index k = 0; k < planes.size(); ++k) known[planes[k]] = share[k];
    std::set<double> between;
    for (auto at = std::next(known.begin()); round < kRounds && std::next(at) != known.end(); ++at)
      if (std::abs(by_neighbours(known, at->first) - at->second) > kMiss)
        for (const auto beside : {std::prev(at), std::next(at)})
          between.insert(0.5 * (at->first + beside->first));
    planes = array_of({between.begin(), between.end()});
  }
  return drawn.unaryExpr([&](double plane) {
    const auto at = known.find(plane);
    return at == known.end() ? by_neighbours(known, plane) : at->second;
  });
}

}  // namespace

/// N(z) through one ring, the target's ee90 at z = f, for all three surfaces.
Picture ring_through_picture(const PlotInput& input) {
  const std::string name = "ring_through";
  constexpr double kReach = 4;  // in units of ring f / R; half maximum is near 1.4
  double ring = reference(input).statistic(EncircledEnergyRadius{0.9, 0.0});
  if (!(ring > 1e-12)) ring = 2 * spot_scale(input);
  const double last =
      within_reach(input, kReach * ring * input.mirror.focal_length / aperture_radius(input.aperture));
  const bool smooth = input.result.model == "waves";  // rays are counted in all planes at once
  const Eigen::ArrayXd planes = Eigen::ArrayXd::LinSpaced(smooth ? 201 : 1001, -last, last);
  std::vector<Eigen::ArrayXd> columns = {planes, {}, Eigen::ArrayXd::Constant(planes.size(), NAN), {}};
  const std::vector<Branch> all = branches(input);
  for (const Branch& branch : all)
    columns[std::size_t(branch.column - 1)] =
        smooth ? smooth_curve(*branch.light, ring, planes) : branch.light->ring_through(ring, planes);
  Picture picture{name, script_head(name, 1200, 800), {}};
  picture.add_columns(
      name + ".dat",
      {fmt::format("Share of the light inside a ring of radius {:.9g} m, centred on the focus", ring),
       "columns: plane_dz_m (offset from z = f) ideal target fitted (shares; nan: no target)"},
      columns);
  std::vector<std::string> lines;
  for (const Branch& branch : all)
    lines.push_back(curve_of(
        branch, name, "FWHM " + width_text(*branch.light, ring, columns[std::size_t(branch.column - 1)])));
  const AxisUnit unit = length_unit(last);
  picture.script += fmt::format(
      "u = {:.9g}  # axis units per metre\n"
      "set multiplot title {} font 'DejaVu Sans,16'\n"
      "set size 1,0.94\nset origin 0,0\n"
      "set xlabel 'plane: distance from z = f along the axis [{}]'\n"
      "set ylabel {}\n"
      "{}set yrange [0:1.05]\nset ytics 0.1\n"
      "set key maxcols 3\n"
      "plot {}, \\\n  {:.9g} with lines linecolor rgb '#999999' linewidth 0.8 title 'half maximum of the "
      "{}'\n"
      "unset multiplot\n",
      unit.per_si, picture_title(input, "Light through a ring"), unit.name,
      gnuplot_text("share of the light inside a ring of radius " + length_text(ring)),
      symmetric_range("x", last * unit.per_si), fmt::join(lines, kNextCurve),
      0.5 * columns[input.target ? 2 : 3].maxCoeff(), reference_name(input));
  return picture;
}

namespace {

struct Plane {
  const char* key;
  double units;  // of plane_unit
};
constexpr Plane kPlanes[] = {{"before", -2.0}, {"focus", 0.0}, {"behind", 2.0}};

// What all images share: how much of the plane they show.
struct ImageFrame {
  static constexpr int kPixels = 129;  // odd, so that the centre is a pixel
  double half = 0;                     // of the width [m]
  double ring = 0;                     // ee90 at z = f [m]
  double decades = 0;                  // below the brightest pixel of target and fitted surface
  AxisUnit unit;

  double pixel() const { return 2 * half / kPixels; }
};

ImageFrame image_frame(const PlotInput& input) {
  constexpr double kDecades = 2.5, kHalfWidth = 5;  // at that many sigmas
  ImageFrame frame;
  frame.ring = reference(input).statistic(EncircledEnergyRadius{0.9, 0.0});
  const double scale = spot_scale(input);
  frame.half = image_half_width(frame.ring, scale);
  frame.decades = kDecades + 2 * std::log10(frame.half / (kHalfWidth * scale));
  frame.unit = length_unit(frame.half);
  return frame;
}

std::vector<std::string> image_header(const ImageFrame& frame, const Branch& branch, double dz) {
  return {fmt::format("Share of the light per pixel, {} at dz = {:.9g} m from z = f", branch.label, dz),
          fmt::format("{0} x {0} pixels of {1:.9g} m; rows from -y to +y, columns from -x to +x; the first "
                      "pixel is centred on {2:.9g} m in x and y",
                      ImageFrame::kPixels, frame.pixel(), -frame.half + 0.5 * frame.pixel())};
}

// Places of the panels, rows by columns, on the screen.
struct PanelGrid {
  static constexpr int kRowHeight = 415, kHeadHeight = 130;  // [pixels]
  std::size_t rows;

  int height() const { return kHeadHeight + kRowHeight * int(rows); }
  double bottom() const { return 85.0 / height(); }

  std::string margins(std::size_t row, std::size_t column) const {
    const double left = 0.08, panel_width = 0.255, panel_height = (kRowHeight - 45.0) / height();
    const double x0 = left + double(column) * 0.272;
    const double y0 = bottom() + double(rows - 1 - row) * kRowHeight / height();
    return fmt::format("set lmargin at screen {:.4f}\nset rmargin at screen {:.4f}\n", x0, x0 + panel_width) +
           fmt::format("set bmargin at screen {:.4f}\nset tmargin at screen {:.4f}\n", y0, y0 + panel_height);
  }

  // One colour box for all, beside the last panel.
  std::string colour_box(std::size_t row, std::size_t column) const {
    if (row != 0 || column != 2) return "unset colorbox\n";
    return fmt::format("set colorbox user origin screen 0.895,{:.4f} size screen 0.016,{:.4f}\n", bottom(),
                       1.0 - bottom() - double(kHeadHeight - 85) / height() - 45.0 / height());
  }
};

// Titles above the first row, tics and labels at the outer edges only.
std::string panel_labels(const PanelGrid& grid, std::size_t row, std::size_t column, const std::string& label,
                         double dz, const std::string& unit) {
  std::string text;
  text += row == 0 ? fmt::format("set title {} offset 0,-0.5\n",
                                 gnuplot_text(dz == 0 ? "z = f"
                                                      : fmt::format("{} {} f", length_text(std::abs(dz)),
                                                                    dz < 0 ? "before z =" : "behind z =")))
                   : "unset title\n";
  text += row + 1 == grid.rows ? fmt::format("set format x '%g'\nset xlabel 'x [{}]'\n", unit)
                               : "set format x ''\nunset xlabel\n";
  text += column == 0 ? fmt::format("set format y '%g'\nset ylabel {}\n",
                                    gnuplot_text(fmt::format("{}      y [{}]", label, unit)))
                      : "set format y ''\nunset ylabel\n";
  return text;
}

std::string panel_plot(const ImageFrame& frame, const std::string& file) {
  std::string text = fmt::format(
      "plot '{}' matrix using ($1*p+o):($2*p+o):($3*b>lowest?$3*b:lowest) with image notitle", file);
  if (frame.ring > 0 && frame.ring < frame.half)
    text +=
        ", \\\n  [0:2*pi] '+' using (ring*cos($1)):(ring*sin($1)) with lines linecolor rgb 'white' linewidth "
        "1 dashtype 2 notitle";
  return text + "\n";
}

// Constants, axes and colours of all panels. brightest: share of the light in the pixel that becomes 1.
std::string images_head(const PlotInput& input, const ImageFrame& frame, double brightest) {
  const AxisUnit& unit = frame.unit;
  return fmt::format(
      "p = {:.9g}; o = {:.9g}  # pixel and first pixel [{}]\n"
      "b = {:.9g}  # share per pixel -> brightness relative to the brightest pixel of target and fitted "
      "surface\n"
      "lowest = {:.9g}\n"
      "ring = {:.9g}  # ee90 radius at z = f [{}]\n"
      "set samples 181\n"
      "set multiplot title {} font 'DejaVu Sans,16'\n"
      "unset grid\nunset key\n"
      "{}{}set size ratio -1\n"
      "set tics out\n"
      "set logscale cb\nset cbrange [lowest:1]\n"
      "set cblabel 'light per pixel / brightest of a rough mirror   (dashed: ee90 at z = f)' offset 1.5,0\n"
      "set palette defined (0 '#000004', 1 '#1b0c41', 2 '#4a0c6b', 3 '#781c6d', 4 '#a52c60', 5 '#cf4446', 6 "
      "'#ed6925', 7 '#fb9b06', 8 '#f7d13d', 9 '#fcffa4')\n",
      frame.pixel() * unit.per_si, (-frame.half + 0.5 * frame.pixel()) * unit.per_si, unit.name,
      brightest > 0 ? 1.0 / brightest : 1.0, std::pow(10.0, -frame.decades), frame.ring * unit.per_si,
      unit.name, picture_title(input, "Spots near focus"), symmetric_range("x", frame.half * unit.per_si),
      symmetric_range("y", frame.half * unit.per_si), reference_name(input));
}

}  // namespace

/// Spots as a camera would see them: three planes by three surfaces, logarithmic, one common scale.
Picture focal_images_picture(const PlotInput& input) {
  const std::string name = "focal_images";
  const ImageFrame frame = image_frame(input);
  const std::vector<Branch> rows = branches(input);
  const PanelGrid grid{rows.size()};

  Picture picture{name, "", {}};
  double brightest = 0;
  std::string panels;
  for (std::size_t row = 0; row < rows.size(); ++row) {
    for (std::size_t column = 0; column < std::size(kPlanes); ++column) {
      const double dz = within_reach(input, kPlanes[column].units * plane_unit(input));
      const Eigen::ArrayXXd image = rows[row].light->image(dz, frame.half, ImageFrame::kPixels);
      if (row > 0) brightest = std::max(brightest, image.maxCoeff());
      const std::string file = fmt::format("{}_{}_{}.dat", name, rows[row].key, kPlanes[column].key);
      picture.add_matrix(file, image_header(frame, rows[row], dz), image);
      panels += grid.margins(row, column);
      panels += panel_labels(grid, row, column, rows[row].label, dz, frame.unit.name);
      panels += grid.colour_box(row, column);
      panels += panel_plot(frame, file);
    }
  }
  picture.script = script_head(name, 1500, grid.height()) + images_head(input, frame, brightest) + panels +
                   "unset multiplot\n";
  return picture;
}

}  // namespace aberfit::internal
