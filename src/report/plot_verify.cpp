#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "aberfit/core/constants.h"
#include "aberfit/report/verify_report.h"
#include "aberfit/scene/mirror.h"
#include "focus_curves.h"
#include "picture.h"

namespace aberfit {
using namespace internal;

namespace {

constexpr double kArcsec = kPi / 180 / 3600;

// One of the plots of a picture.
struct Panel {
  std::string title, x_label, y_label;
  std::string settings;  // gnuplot lines before the plot; undone after it
  std::string plot;      // what stands after "plot" or, where settings are of three dimensions, "splot"
  bool three_dimensional = false;
};

// The panels row by row, each from the same state of gnuplot.
std::string panels(const std::string& name, const std::string& title, int width, int height, int columns,
                   const std::vector<Panel>& all) {
  const int rows = (int(all.size()) + columns - 1) / columns;
  std::string script = script_head(name, width, height) +
                       fmt::format("set multiplot layout {},{} title {} font 'DejaVu Sans,16'\n", rows,
                                   columns, gnuplot_text(title));
  for (const Panel& panel : all)
    script += fmt::format(
        "unset logscale; unset arrow; unset colorbox; set offsets 0,0,0,0; set autoscale; set format '%g'; "
        "set size noratio; set key inside top right vertical Right noreverse; set tics nomirror; set xtics "
        "auto offset 0,0; set ytics auto offset 0,0\n"
        "set title {}\nset xlabel {} offset 0,0\nset ylabel {} offset 0,0\n{}{} {}\n",
        gnuplot_text(panel.title), gnuplot_text(panel.x_label), gnuplot_text(panel.y_label), panel.settings,
        panel.three_dimensional ? "splot" : "plot", panel.plot);
  return script + "unset multiplot\n";
}

// One of the paper's three cases.
struct Case {
  const char* key;
  const char* label;
  const RayBundle* rays;
  double ring;  // of its ring-through curve [m]
};

// Everything the pictures look at.
struct Scene {
  const VerifyReport& report;
  const Mirror& mirror;
  const Aperture& aperture;
  double wavelength;
  const VerifyRays& shown;
  std::vector<Case> cases;
  AxisUnit lateral;  // of the mirror

  double radius() const { return aperture_radius(aperture); }
  std::string title(const std::string& text) const {
    return report.title.empty() ? text : text + " - " + report.title;
  }
};

double ee90_of(const RayBundle& rays) {
  static const Eigen::ArrayXd kNoHeight;
  return evaluate_exact({rays, rays, kNoHeight, Centre::kNominal}, {EncircledEnergyRadius{}}, 1)[0];
}

// About `count` of n things, evenly through their order, which is random or regular, but not sorted by what
// is shown.
std::vector<Eigen::Index> some_of(Eigen::Index n, Eigen::Index count) {
  std::vector<Eigen::Index> chosen;
  const double step = std::max(1.0, double(n) / double(count));
  for (double at = 0; at < double(n); at += step) chosen.push_back(Eigen::Index(at));
  return chosen;
}

Eigen::ArrayXd at(const Eigen::ArrayXd& values, const std::vector<Eigen::Index>& chosen) {
  Eigen::ArrayXd some(Eigen::Index(chosen.size()));
  for (std::size_t k = 0; k < chosen.size(); ++k) some[Eigen::Index(k)] = values[chosen[k]];
  return some;
}

Eigen::ArrayXd heights_at(const Mirror& mirror, const Eigen::ArrayXd& x, const Eigen::ArrayXd& y) {
  Eigen::ArrayXd z(x.size());
  for (Eigen::Index i = 0; i < x.size(); ++i) z[i] = base_surface(mirror, x[i], y[i]).height;
  return z;
}

/// The mirror in three dimensions, its profile, and where rays hit it.
Picture mirror_picture(const Scene& s) {
  constexpr int kRings = 24, kSpokes = 73;
  constexpr Eigen::Index kDots = 3000;
  const std::string name = "mirror";
  std::string surface = "# Mirror without roughness: x, y, z [m], rings with a blank line between\n";
  for (int i = 0; i <= kRings; ++i) {
    for (int k = 0; k < kSpokes; ++k) {
      const double rho = s.radius() * i / kRings, angle = 2 * kPi * k / (kSpokes - 1);
      const double x = rho * std::cos(angle), y = rho * std::sin(angle);
      surface += fmt::format("{:.6g} {:.6g} {:.6g}\n", x, y,
                             aperture_contains(s.aperture, x * (1 - 1e-9), y * (1 - 1e-9), 0.0)
                                 ? base_surface(s.mirror, x, y).height
                                 : NAN);
    }
    surface += "\n";
  }
  const std::vector<Eigen::Index> dots = some_of(s.shown.pupil.size(), kDots);
  const Eigen::ArrayXd x = at(s.shown.pupil.x, dots), y = at(s.shown.pupil.y, dots);
  const Eigen::ArrayXd across = Eigen::ArrayXd::LinSpaced(201, -s.radius(), s.radius());
  const AxisUnit depth = length_unit(base_surface(s.mirror, s.radius(), 0.0).height);
  const std::string u = fmt::format("{:.9g}", s.lateral.per_si), v = fmt::format("{:.9g}", depth.per_si);
  const std::string of_x = "x [" + s.lateral.name + "]", of_y = "y [" + s.lateral.name + "]",
                    of_z = "z [" + depth.name + "]";
  const std::string space = fmt::format(
      "set view 62,35\nset xyplane 0\nset xlabel offset 0,-1\nset zlabel '{}' rotate by 90 offset 1,0\nset "
      "xtics {:.9g} offset 0,-0.4\nset ytics {:.9g} offset 1,-0.3\n"
      "set key off\n",
      of_z, s.radius() * s.lateral.per_si, s.radius() * s.lateral.per_si);
  Picture picture{name, "", {}};
  picture.data = {
      {"mirror_surface.dat", surface},
      {"mirror_hits.dat", columns_file({fmt::format("{} of {} points where rays hit the mirror: x, y, z [m]",
                                                    x.size(), s.shown.pupil.size())},
                                       {x, y, heights_at(s.mirror, x, y)})},
      {"mirror_profile.dat",
       columns_file({"Profile through the vertex: x, z [m]"},
                    {across, heights_at(s.mirror, across, Eigen::ArrayXd::Zero(across.size()))})}};
  const std::string hits = fmt::format("hit points, {} of {}", x.size(), s.shown.pupil.size());
  picture.script = panels(
      name, s.title("Mirror and hit points"), 1400, 1150, 2,
      {{"the mirror without roughness (z stretched)", of_x, of_y,
        space + "set palette defined (0 '#053061', 0.5 '#92c5de', 1 '#fddbc7')\nset colorbox\nset cblabel '" +
            of_z + "' offset 1.5,0\n",
        "'mirror_surface.dat' using ($1*" + u + "):($2*" + u + "):($3*" + v + "):($3*" + v +
            ") with pm3d notitle",
        true},
       {"profile through the vertex", of_x, of_z, "set key off\n",
        "'mirror_profile.dat' using ($1*" + u + "):($2*" + v + ") with lines linetype 2 notitle"},
       {hits + ", in space", of_x, of_y, space,
        "'mirror_hits.dat' using ($1*" + u + "):($2*" + u + "):($3*" + v +
            ") with points pointtype 7 pointsize 0.25 linecolor rgb '" + kTargetColour + "' notitle",
        true},
       {hits + ", in the aperture plane", of_x, of_y, "set key off\nset size ratio -1\n",
        "'mirror_hits.dat' using ($1*" + u + "):($2*" + u +
            ") with points pointtype 7 pointsize 0.25 linecolor rgb '" + kTargetColour + "' notitle"}});
  return picture;
}

/// Reflected rays of the ideal mirror from the mirror through the focus, and the last piece for all cases.
Picture reflected_rays_picture(const Scene& s) {
  constexpr Eigen::Index kRays = 60;
  constexpr double kBeyond = 1.08;  // of the focal length
  const std::string name = "reflected_rays";
  const double f = s.mirror.focal_length;
  const std::vector<Eigen::Index> some = some_of(s.shown.pupil.size(), kRays);
  std::string fan = "# Reflected rays of the ideal mirror: x, y, z [m] of hit point and far end\n";
  for (const Eigen::Index i : some) {
    const RayBundle& r = s.shown.nominal;
    const double x = s.shown.pupil.x[i], y = s.shown.pupil.y[i], far = (kBeyond - 1) * f;
    fan += fmt::format("{:.6g} {:.6g} {:.6g}\n{:.6g} {:.6g} {:.6g}\n\n\n", x, y,
                       base_surface(s.mirror, x, y).height, r.x[i] + far * r.tx[i], r.y[i] + far * r.ty[i],
                       kBeyond * f);
  }
  Picture picture{name, "", {{"reflected_rays_fan.dat", fan}}};
  const std::string u = fmt::format("{:.9g}", s.lateral.per_si);
  std::vector<Panel> all = {
      {fmt::format("{} reflected rays of the ideal mirror, focus at z = {:.9g} m", some.size(), f),
       "x [" + s.lateral.name + "]", "y [" + s.lateral.name + "]",
       fmt::format("set view 75,30\nset xyplane 0\nset xlabel offset 0,-1\nset zlabel 'z [m]' rotate by 90 "
                   "offset -1,0\nset xtics {0:.9g} offset 0,-0.4\nset ytics {0:.9g} offset 1,-0.3\n"
                   "set key off\n",
                   s.radius() * s.lateral.per_si),
       "'reflected_rays_fan.dat' using ($1*" + u + "):($2*" + u +
           "):3 with lines linetype 2 linewidth 0.7 notitle",
       true}};
  for (const Case& c : s.cases) {
    const double reach = 2.5 * c.ring * f / s.radius();
    const AxisUnit along = length_unit(reach), wide = length_unit(3 * c.ring);
    std::string lines = fmt::format("# Rays near the focus, {}: distance from z = f, x [m]\n", c.label);
    for (const Eigen::Index i : some)
      for (const double dz : {-reach, reach})
        lines +=
            fmt::format("{:.6g} {:.6g}\n{}", dz, c.rays->x[i] + dz * c.rays->tx[i], dz > 0 ? "\n\n" : "");
    const std::string file = fmt::format("reflected_rays_{}.dat", c.key);
    picture.data.emplace_back(file, lines);
    all.push_back(
        {fmt::format("{}, near the focus", c.label), fmt::format("distance from z = f [{}]", along.name),
         "x [" + wide.name + "]", "set key off\nset autoscale xfix\n",
         fmt::format("'{}' using ($1*{:.9g}):($2*{:.9g}) with lines linetype 2 linewidth 0.7 notitle", file,
                     along.per_si, wide.per_si)});
  }
  picture.script = panels(name, s.title("Reflected rays"), 1400, 1150, 2, all);
  return picture;
}

/// Points of the published phase in the frequency plane.
Picture frequency_picture(const Scene& s) {
  constexpr int kBins = 28, kAngles = 24, kBands = 3;
  const std::string name = "frequency_sampling";
  const auto n = Eigen::Index(s.shown.published_modes.size());
  Eigen::ArrayXd f(n), angle(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const FourierMode& mode = s.shown.published_modes[std::size_t(k)];
    f[k] = std::hypot(mode.fx, mode.fy);
    angle[k] = std::atan2(mode.fy, mode.fx);
  }
  const double f_min = s.report.quantities.at("published_phase.f_min_per_m"),
               f_max = s.report.quantities.at("published_phase.f_max_per_m");
  const double step = std::log(f_max / f_min) / kBins;
  Eigen::ArrayXd middle(kBins), count = Eigen::ArrayXd::Zero(kBins), per_radius(kBins), per_area(kBins);
  for (Eigen::Index k = 0; k < n; ++k)
    count[std::clamp(int(std::log(f[k] / f_min) / step), 0, kBins - 1)] += 1;
  for (int b = 0; b < kBins; ++b) {
    const double low = f_min * std::exp(b * step), high = low * std::exp(step);
    middle[b] = std::sqrt(low * high);
    per_radius[b] = count[b] / (high - low);
    per_area[b] = count[b] / (kPi * (high * high - low * low));
  }
  Eigen::ArrayXXd turns = Eigen::ArrayXXd::Zero(kAngles, kBands);
  const double band = std::log(f_max / f_min) / kBands;
  for (Eigen::Index k = 0; k < n; ++k)
    turns(std::clamp(int((angle[k] / kPi + 1) / 2 * kAngles), 0, kAngles - 1),
          std::clamp(int(std::log(f[k] / f_min) / band), 0, kBands - 1)) += 1;
  std::vector<Eigen::ArrayXd> angles = {
      Eigen::ArrayXd::LinSpaced(kAngles, -180 + 180.0 / kAngles, 180 - 180.0 / kAngles)};
  std::string bands;
  for (int b = 0; b < kBands; ++b) {
    angles.push_back(turns.col(b));
    bands += fmt::format(
        "{}'frequency_angles.dat' using 1:{} with histeps linewidth 2 title '{:.3g} to {:.3g} /m'",
        b ? ", " : "", b + 2, f_min * std::exp(b * band), f_min * std::exp((b + 1) * band));
  }
  const Eigen::ArrayXd decades = (f / f_min).log10();
  // Laws through all points: n/ln(f_max/f_min) points for each unit of ln f.
  const double law = double(n) / std::log(f_max / f_min);
  Picture picture{name, "", {}};
  picture.data = {
      {"frequency_points.dat",
       columns_file({"Points of the phase sum: log10(f/f_min) times cosine and sine of its direction"},
                    {decades * angle.cos(), decades * angle.sin()})},
      {"frequency_density.dat",
       columns_file({"f [/m], points in an equal step of log f, per unit of f [m], per unit of area [m^2]"},
                    {middle, count, per_radius, per_area})},
      {"frequency_angles.dat", columns_file({"direction [degrees], points in each of three bands"}, angles)}};
  picture.script = panels(
      name, s.title(fmt::format("Frequency sampling of the published phase, {} points", n)), 1400, 1150, 2,
      {{"points, radius = log10(f/f_min)", "log10(f/f_min) along f_p", "log10(f/f_min) along f_q",
        "set key off\nset size ratio -1\n",
        fmt::format(
            "'frequency_points.dat' with points pointtype 7 pointsize 0.15 linecolor rgb '{}' notitle",
            kTargetColour)},
       {"points in equal steps of log f: flat", "f_r [cycles/m]", "points",
        fmt::format("set logscale x\nset format x '%.0e'\nset yrange [0:{:.9g}]\n", 1.4 * count.maxCoeff()),
        fmt::format("'frequency_density.dat' using 1:2 with histeps linetype 2 title 'points', {:.9g} with "
                    "lines linetype 1 title 'uniform in log f'",
                    law * step)},
       {"density: 1/f per unit radius is 1/f² per unit area", "f_r [cycles/m]", "density",
        "set logscale xy\nset format '%.0e'\nset key top right\n",
        fmt::format("'frequency_density.dat' using 1:3 with points pointtype 7 linecolor rgb '{0}' title "
                    "'per unit radius [m]', {2:.9g}/x with lines linecolor rgb '{0}' dashtype 2 title '1/f', "
                    "'' using 1:4 with points pointtype 5 linecolor rgb '{1}' title 'per unit area [m²]', "
                    "{3:.9g}/x**2 with lines linecolor rgb '{1}' dashtype 2 title '1/f²'",
                    kTargetColour, kFittedColour, law, law / (2 * kPi))},
       {"direction, in three bands: flat", "direction [degrees]", "points",
        fmt::format("set xrange [-180:180]\nset xtics 90\nset yrange [0:{:.9g}]\n", 1.5 * turns.maxCoeff()),
        bands}});
  return picture;
}

struct Histogram {
  Eigen::ArrayXd middle, density, law;
};

// Density of values in bins, and a law beside it (empty: none).
template <typename Law>
Histogram histogram(const Eigen::ArrayXd& values, const Eigen::ArrayXd& weights, double low, double high,
                    const Law& law) {
  constexpr int kBins = 61;
  Histogram h;
  h.middle.resize(kBins);
  for (int b = 0; b < kBins; ++b) h.middle[b] = low + (high - low) * (b + 0.5) / kBins;
  h.density = weighted_density(values, weights, low, high, kBins);
  h.law = h.middle.unaryExpr(law);
  return h;
}
double gauss(double x, double sigma) {
  return std::exp(-0.5 * x * x / (sigma * sigma)) / (sigma * std::sqrt(2 * kPi));
}
double rayleigh(double r, double sigma) {
  return r <= 0 ? 0.0 : r / (sigma * sigma) * std::exp(-0.5 * r * r / (sigma * sigma));
}

// Of the Rayleigh law of a case: as wide as its deflections.
double per_axis(const Deflections& d) { return d.rms / std::numbers::sqrt2; }
double rayleigh_mean(const Deflections& d) { return std::sqrt(kPi / 2) * per_axis(d); }

// A dashed vertical line and its place in the key.
struct Upright {
  double x;
  std::string title;
};

// A histogram panel of the Harvey-Shack branch with a law, and the terms' histogram beside it. x_label: with
// its unit in brackets.
Panel histogram_panel(Picture* picture, const std::string& key, const std::string& title,
                      const std::string& x_label, const Histogram& hs, const Histogram& terms,
                      const std::string& law_label, const std::vector<Upright>& marks = {}) {
  const std::string file = picture->name + "_" + key + ".dat";
  picture->data.emplace_back(
      file, columns_file({title, "middle of the bin: " + x_label + "; density of Harvey-Shack, law, terms"},
                         {hs.middle, hs.density, hs.law, terms.density}));
  const std::size_t unit = x_label.find('[') + 1;
  Panel panel{title, x_label, "density [1/(" + x_label.substr(unit, x_label.find(']') - unit) + ")]",
              "set yrange [0:*]\nset offsets 0,0,graph 0.28,0\n",
              fmt::format("'{0}' using 1:2 with histeps linecolor rgb '{1}' linewidth 2 dashtype 1 title "
                          "'Harvey-Shack', '' using 1:3 with lines linetype 1 title {3}, '' using 1:4 with "
                          "histeps linecolor rgb '{2}' linewidth 1.2 dashtype 1 title 'terms, one draw'",
                          file, kTargetColour, kFittedColour, gnuplot_text(law_label))};
  int dash = 2;
  for (const Upright& mark : marks) {
    const std::string look = fmt::format("linecolor rgb 'black' linewidth 1.2 dashtype {}", dash++);
    panel.settings +=
        fmt::format("set arrow from {0:.9g}, graph 0 to {0:.9g}, graph 0.72 nohead {1}\n", mark.x, look);
    panel.plot += ", NaN with lines " + look + " title " + gnuplot_text(mark.title);
  }
  return panel;
}

/// Phase gradients that the deflections stand for: components, both together, magnitude.
Picture gradient_picture(const Scene& s, const Deflections& hs, const Deflections& terms) {
  Picture picture{"phase_gradients", "", {}};
  const double scale = 4 * kPi / s.wavelength;  // of a deflection [rad], in rad/m
  const double sx = scale * hs.rms_x, sy = scale * hs.rms_y, total = std::hypot(sx, sy);
  const double reach = 4 * std::max(sx, sy);
  const auto component = [&](const char* key, const char* axis, const Eigen::ArrayXd& of_hs, double sigma,
                             const Eigen::ArrayXd& of_terms) {
    const auto law = [&](double x) { return gauss(x, sigma); };
    return histogram_panel(&picture, key, fmt::format("component along {}", axis),
                           fmt::format("dPhi/d{} [rad/m]", axis),
                           histogram(scale * of_hs, hs.weight, -reach, reach, law),
                           histogram(scale * of_terms, terms.weight, -reach, reach, law),
                           fmt::format("Gaussian, RMS {:.4g} rad/m", sigma));
  };
  std::vector<Panel> all = {component("x", "x", hs.x, sx, terms.x), component("y", "y", hs.y, sy, terms.y)};
  const std::vector<Eigen::Index> dots = some_of(hs.x.size(), 5000);
  picture.data.emplace_back("phase_gradients_scatter.dat",
                            columns_file({"dPhi/dx, dPhi/dy [rad/m] of rays of the Harvey-Shack branch"},
                                         {scale * at(hs.x, dots), scale * at(hs.y, dots)}));
  all.push_back(
      {fmt::format("both components, {} of {} rays", dots.size(), hs.x.size()), "dPhi/dx [rad/m]",
       "dPhi/dy [rad/m]",
       fmt::format("set size ratio -1\nset samples 181\nset xrange [{0:.9g}:{1:.9g}]\nset yrange "
                   "[{0:.9g}:{1:.9g}]\nset key top right\n",
                   -reach, reach),
       fmt::format(
           "'phase_gradients_scatter.dat' with points pointtype 7 pointsize 0.2 linecolor rgb '{}' title "
           "'Harvey-Shack', for [k=1:3] [0:2*pi] '+' using (k*{:.9g}*cos($1)):(k*{:.9g}*sin($1)) with lines "
           "linecolor rgb 'black' linewidth 1.2 dashtype k title sprintf('%d sigma', k)",
           kTargetColour, sx, sy)});
  const auto law = [&](double r) { return rayleigh(r, total / std::numbers::sqrt2); };
  all.push_back(histogram_panel(&picture, "magnitude", "magnitude", "|grad Phi| [rad/m]",
                                histogram(scale * hs.magnitude, hs.weight, 0, reach, law),
                                histogram(scale * terms.magnitude, terms.weight, 0, reach, law), "Rayleigh",
                                {{total, fmt::format("RMS {:.4g} rad/m", total)}}));
  picture.script = panels(picture.name, s.title("Phase gradients, (4 pi/lambda) times the deflection"), 1400,
                          1150, 2, all);
  return picture;
}

/// Deflection of the rays: components and magnitude.
Picture deflection_picture(const Scene& s, const Deflections& hs, const Deflections& terms) {
  Picture picture{"deflections", "", {}};
  const AxisUnit unit = angle_unit(3 * hs.rms);
  const double u = unit.per_si, reach = 4 * u * std::max(hs.rms_x, hs.rms_y);
  std::vector<Panel> all;
  const auto component = [&](const std::string& axis, const Eigen::ArrayXd& of_hs, double sigma,
                             const Eigen::ArrayXd& of_terms, double far, const std::string& name,
                             double per) {
    const auto law = [&](double x) { return gauss(x, per * sigma); };
    return histogram_panel(&picture, axis, "component along " + axis, name,
                           histogram(per * of_hs, hs.weight, -far, far, law),
                           histogram(per * of_terms, terms.weight, -far, far, law),
                           fmt::format("Gaussian, std {:.4g}", per * sigma));
  };
  const std::string name = "deflection [" + unit.name + "]";
  all.push_back(component("x", hs.x, hs.rms_x, terms.x, reach, name, u));
  all.push_back(component("y", hs.y, hs.rms_y, terms.y, reach, name, u));
  const AxisUnit fine = angle_unit(3 * hs.rms_z);
  all.push_back(component("z", hs.z, hs.rms_z, terms.z, 4 * fine.per_si * hs.rms_z,
                          "change of the direction cosine z [" + fine.name + "]", fine.per_si));
  const auto law = [&](double r) { return rayleigh(r, u * per_axis(hs)); };
  all.push_back(histogram_panel(
      &picture, "magnitude", "magnitude", "|D| [" + unit.name + "]",
      histogram(u * hs.magnitude, hs.weight, 0, reach, law),
      histogram(u * terms.magnitude, terms.weight, 0, reach, law), "Rayleigh",
      {{u * rayleigh_mean(hs), fmt::format("mean {:.4g} {}", u * rayleigh_mean(hs), unit.name)},
       {u * hs.rms, fmt::format("RMS {:.4g} {}", u * hs.rms, unit.name)}}));
  picture.script = panels(picture.name, s.title("Deflections of the rays"), 1400, 1150, 2, all);
  return picture;
}

/// Scatter angles, on the sky's scale.
Picture scatter_angle_picture(const Scene& s, const Deflections& hs, const Deflections& terms) {
  Picture picture{"scatter_angles", "", {}};
  const double sigma = per_axis(hs) / kArcsec, reach = 7.7 * sigma;  // 20 arcsec for the paper's spot
  const auto law = [&](double r) { return rayleigh(r, sigma); };
  const double mean = rayleigh_mean(hs) / kArcsec, rms = hs.rms / kArcsec;
  picture.script = panels(
      picture.name, s.title("Scatter angles"), 1200, 800, 1,
      {histogram_panel(
          &picture, "all", "angle between each ray and its ideal ray", "scatter angle [arcsec]",
          histogram(hs.magnitude / kArcsec, hs.weight, 0, reach, law),
          histogram(terms.magnitude / kArcsec, terms.weight, 0, reach, law), "Rayleigh",
          {{mean, fmt::format("mean {:.4g} arcsec", mean)}, {rms, fmt::format("RMS {:.4g} arcsec", rms)}})});
  return picture;
}

/// N(z) of each case through its own ring.
Picture ring_picture(const Scene& s) {
  constexpr int kPoints = 801;
  static const Eigen::ArrayXd kNoHeight;
  Picture picture{"ring_through", "", {}};
  std::vector<Panel> all;
  for (const Case& c : s.cases) {
    const double last = 3.5 * c.ring * s.mirror.focal_length / s.radius();
    const Eigen::ArrayXd planes = Eigen::ArrayXd::LinSpaced(kPoints, -last, last);
    const Eigen::ArrayXd share = ring_through_curve(*c.rays, Centre::kNominal, c.ring, planes);
    const double width = evaluate_exact({*c.rays, s.shown.nominal, kNoHeight, Centre::kNominal},
                                        {RingFwhm{0.9, c.ring}}, 1)[0];
    const std::string file = fmt::format("ring_through_{}.dat", c.key);
    picture.data.emplace_back(
        file, columns_file({fmt::format("Share of the rays inside a ring of {:.9g} m, {}", c.ring, c.label),
                            "distance from z = f [m], share"},
                           {planes, share}));
    const AxisUnit unit = length_unit(last);
    all.push_back(
        {fmt::format("{}: ring {}, FWHM {}", c.label, display(c.ring, Dimension::kLength),
                     display(width, Dimension::kLength)),
         fmt::format("distance from z = f [{}]", unit.name), "share of the rays in the ring",
         fmt::format("set key off\nset yrange [0:1.05]\nset xrange [{:.9g}:{:.9g}]\n", -last * unit.per_si,
                     last * unit.per_si),
         fmt::format(
             "'{}' using ($1*{:.9g}):2 with lines linetype 2 notitle, {:.9g} with lines linetype 1 notitle",
             file, unit.per_si, 0.5 * share.maxCoeff())});
  }
  picture.script =
      panels(picture.name, s.title("Rays through a ring, half maximum dotted"), 1100, 1300, 1, all);
  return picture;
}

/// Cuts through the height error of the traced terms.
Picture height_picture(const Scene& s) {
  constexpr int kPoints = 801;
  Picture picture{"height_profile", "", {}};
  const Eigen::ArrayXd across = Eigen::ArrayXd::LinSpaced(kPoints, -s.radius(), s.radius());
  const Eigen::ArrayXd none = Eigen::ArrayXd::Zero(kPoints);
  SurfaceField along_x, along_y;
  const GivenSurface& surface = s.shown.surface;
  SurfaceOperator(surface.terms, across, none).apply(surface.coefficients, &along_x);
  SurfaceOperator(surface.terms, none, across).apply(surface.coefficients, &along_y);
  Eigen::ArrayXd on_x = along_x.height, on_y = along_y.height;
  for (int i = 0; i < kPoints; ++i) {
    // Points on the rim itself belong to the cut; rounding would decide.
    if (!aperture_contains(s.aperture, across[i] * (1 - 1e-9), 0.0, 0.0)) on_x[i] = NAN;
    if (!aperture_contains(s.aperture, 0.0, across[i] * (1 - 1e-9), 0.0)) on_y[i] = NAN;
  }
  const Eigen::ArrayXd& h = s.shown.field.height;
  const Eigen::ArrayXd w = s.shown.pupil.weight / s.shown.pupil.weight.sum();
  const double mean = (w * h).sum(), rms = std::sqrt((w * (h - mean).square()).sum());
  const AxisUnit unit = length_unit(3 * rms);
  picture.data.emplace_back(
      "height_profile.dat",
      columns_file({"Height error of the terms through the vertex: position, along x, along y [m]"},
                   {across, on_x, on_y}));
  const auto curve = [&](int column, int type, const char* title) {
    return fmt::format(
        "'height_profile.dat' using ($1*{:.9g}):(${}*{:.9g}) with lines linetype {} title '{}'",
        s.lateral.per_si, column, unit.per_si, type, title);
  };
  picture.script =
      panels(picture.name, s.title("Height error of the aberration terms"), 1200, 700, 1,
             {{fmt::format("one draw, RMS over the aperture {}{}", display(rms, Dimension::kLength),
                           s.report.convention == Convention::kPaper
                               ? " (half the specified: convention paper deflects half as much)"
                               : ""),
               "distance from the vertex [" + s.lateral.name + "]", "height [" + unit.name + "]",
               fmt::format("set xrange [{:.9g}:{:.9g}]\nset offsets 0,0,graph 0.15,0\n",
                           -s.radius() * s.lateral.per_si, s.radius() * s.lateral.per_si),
               curve(2, 2, "along x (y = 0)") + ", " + curve(3, 3, "along y (x = 0)")}});
  return picture;
}

// An image of a case: share of its brightest pixel, square root, so that faint parts show.
std::string image_plot(const std::string& file, double x0, double dx, double y0, double dy, double largest) {
  return fmt::format("'{}' matrix using ({:.9g}+$1*{:.9g}):({:.9g}+$2*{:.9g}):(sqrt($3/{:.9g})) with image",
                     file, x0, dx, y0, dy, largest);
}
constexpr const char* kImageSettings =
    "set key off\nunset grid\nset tics out\nset cbrange [0:1]\n"
    "set palette defined (0 'black', 0.35 '#3b0f70', 0.65 '#de4968', 1 '#fcfdbf')\n";

/// Images of all cases in three planes.
Picture images_picture(const Scene& s) {
  constexpr int kPixels = 75;
  constexpr double kHalfWidth = 3.95, kPlanes[] = {-1.4, 0, 1.4};  // of the ring, and of ring f/R
  Picture picture{"focal_images", "", {}};
  std::vector<Panel> all;
  for (const Case& c : s.cases) {
    const double half = kHalfWidth * (c.rays == &s.shown.nominal ? 3 / kHalfWidth : 1.0) * c.ring;
    const AxisUnit unit = length_unit(half);
    const double pixel = 2 * half / kPixels;
    for (std::size_t k = 0; k < std::size(kPlanes); ++k) {
      const double dz = kPlanes[k] * c.ring * s.mirror.focal_length / s.radius();
      const std::string offset =
          dz == 0 ? "" : (dz < 0 ? " - " : " + ") + display(std::abs(dz), Dimension::kLength);
      const Eigen::ArrayXXd image = focal_image(*c.rays, Centre::kNominal, dz, half, kPixels);
      const std::string file = fmt::format("focal_images_{}_{}.dat", c.key, k);
      picture.data.emplace_back(
          file, matrix_file({fmt::format("Share of the rays per pixel of {:.6g} m, {} at {:.6g} m from z = f",
                                         pixel, c.label, dz)},
                            image));
      all.push_back(
          {std::string(c.label) + ", z = f" + offset, "x [" + unit.name + "]", "y [" + unit.name + "]",
           std::string(kImageSettings) +
               fmt::format("set size ratio -1\nset xrange [{0:.9g}:{1:.9g}]\nset yrange [{0:.9g}:{1:.9g}]\n",
                           -half * unit.per_si, half * unit.per_si),
           image_plot(file, (-half + 0.5 * pixel) * unit.per_si, pixel * unit.per_si,
                      (-half + 0.5 * pixel) * unit.per_si, pixel * unit.per_si,
                      std::max(image.maxCoeff(), 1e-300))});
    }
  }
  picture.script = panels(picture.name, s.title("Focal images by rays, colour: root of the brightness"), 1500,
                          1500, 3, all);
  return picture;
}

/// Light along x in planes through the focus.
Picture volume_picture(const Scene& s) {
  constexpr int kPixels = 121, kPlanes = 161;
  Picture picture{"focal_volume", "", {}};
  std::vector<Panel> all;
  for (const Case& c : s.cases) {
    const double last = 3 * c.ring * s.mirror.focal_length / s.radius(), half = 3.5 * c.ring;
    Eigen::ArrayXXd light(kPixels, kPlanes);
    for (int k = 0; k < kPlanes; ++k) {
      const double dz = last * (2.0 * k / (kPlanes - 1) - 1);
      light.col(k) = weighted_density(c.rays->x + dz * c.rays->tx, c.rays->weight, -half, half, kPixels) * 2 *
                     half / kPixels;
    }
    const std::string file = fmt::format("focal_volume_{}.dat", c.key);
    picture.data.emplace_back(file,
                              matrix_file({fmt::format("Share of the rays in strips of {:.6g} m along y, {}; "
                                                       "rows -x to +x, columns {:.6g} to {:.6g} m from z = f",
                                                       2 * half / kPixels, c.label, -last, last)},
                                          light));
    const AxisUnit along = length_unit(last), wide = length_unit(half);
    const double dx = 2 * half / kPixels * wide.per_si, dz = 2 * last / (kPlanes - 1) * along.per_si;
    // The ideal focus is one strip, so bright that nothing else would show.
    const double largest = c.rays == &s.shown.nominal ? 0.25 * light.maxCoeff() : light.maxCoeff();
    all.push_back(
        {std::string(c.label), fmt::format("distance from z = f [{}]", along.name), "x [" + wide.name + "]",
         std::string(kImageSettings) + fmt::format("set xrange [{:.9g}:{:.9g}]\nset yrange [{:.9g}:{:.9g}]\n",
                                                   -last * along.per_si, last * along.per_si,
                                                   -half * wide.per_si, half * wide.per_si),
         image_plot(file, -last * along.per_si, dz, -half * wide.per_si + 0.5 * dx, dx,
                    std::max(largest, 1e-300))});
  }
  picture.script =
      panels(picture.name, s.title("Focal volume, colour: root of the brightness"), 1100, 1300, 1, all);
  return picture;
}

}  // namespace

const std::vector<std::string>& verify_picture_names() {
  static const std::vector<std::string> names = {
      "mirror",         "reflected_rays", "frequency_sampling", "phase_gradients", "deflections",
      "scatter_angles", "ring_through",   "height_profile",     "focal_images",    "focal_volume"};
  return names;
}

std::vector<std::string> write_verify_plots(const VerifyReport& report, const Mirror& mirror,
                                            const Aperture& aperture, double wavelength,
                                            const std::string& directory, Warnings* warnings) {
  const VerifyRays& shown = *report.shown;
  // The ideal focus is a point: its ring is chosen, as the paper chose it.
  Scene scene{report,
              mirror,
              aperture,
              wavelength,
              shown,
              {{"ideal", "ideal mirror", &shown.nominal, kIdealRing},
               {"harvey_shack", "Harvey-Shack", &shown.harvey_shack, ee90_of(shown.harvey_shack)},
               {"terms", "aberration terms", &shown.terms, ee90_of(shown.terms)}},
              length_unit(aperture_radius(aperture))};
  const Deflections hs = deflections_of(shown.harvey_shack, shown.nominal),
                    terms = deflections_of(shown.terms, shown.nominal);
  std::vector<Picture> pictures = {mirror_picture(scene), reflected_rays_picture(scene)};
  if (!shown.published_modes.empty()) pictures.push_back(frequency_picture(scene));
  for (Picture& picture :
       std::vector<Picture>{gradient_picture(scene, hs, terms), deflection_picture(scene, hs, terms),
                            scatter_angle_picture(scene, hs, terms), ring_picture(scene),
                            height_picture(scene), images_picture(scene), volume_picture(scene)})
    pictures.push_back(std::move(picture));
  return draw_pictures(pictures, directory, warnings);
}

}  // namespace aberfit
