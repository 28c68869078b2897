#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
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

// The script of a picture: its panels row by row, each from the same state of gnuplot.
void draw_panels(const std::string& title, int width, int height, int columns, const std::vector<Panel>& all,
                 Picture* picture) {
  const int rows = (int(all.size()) + columns - 1) / columns;
  picture->script = script_head(picture->name, width, height);
  picture->script +=
      fmt::format("set multiplot layout {},{} title {} font 'DejaVu Sans,16'\n", rows, columns, title);
  for (const Panel& panel : all)
    picture->script += fmt::format(
        "unset logscale; unset arrow; unset colorbox; set offsets 0,0,0,0; set autoscale; set format '%g'; "
        "set size noratio; set key inside top right vertical Right noreverse; set tics nomirror; set xtics "
        "auto offset 0,0; set ytics auto offset 0,0\n"
        "set title {}\nset xlabel {} offset 0,0\nset ylabel {} offset 0,0\n{}{} {}\n",
        gnuplot_text(panel.title), gnuplot_text(panel.x_label), gnuplot_text(panel.y_label), panel.settings,
        panel.three_dimensional ? "splot" : "plot", panel.plot);
  picture->script += "unset multiplot\n";
}

// One of the paper's three cases.
struct Case {
  std::string key, label;
  const RayBundle& rays;
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
  AxisUnit lateral;       // of the mirror
  Deflections hs, terms;  // of both branches

  double radius() const { return aperture_radius(aperture); }
  bool is_ideal(const Case& c) const { return &c.rays == &shown.nominal; }
  std::string title(const std::string& text) const { return picture_title(text, report.title); }
};

double statistic_of(const RayBundle& rays, const VerifyRays& shown, const Statistic& statistic) {
  return ray_statistic(rays, shown.nominal, Centre::kNominal, statistic);
}

// About `count` of n things, evenly through their order, which is random or regular, but not sorted by what
// is shown.
std::vector<Eigen::Index> some_of(Eigen::Index n, Eigen::Index count) {
  std::vector<Eigen::Index> chosen;
  const double step = std::max(1.0, double(n) / double(count));
  for (double at = 0; at < double(n); at += step) chosen.push_back(Eigen::Index(at));
  return chosen;
}

Eigen::ArrayXd heights_at(const Mirror& mirror, const Eigen::ArrayXd& x, const Eigen::ArrayXd& y) {
  return x.binaryExpr(y, [&](double xi, double yi) { return base_surface(mirror, xi, yi).height; });
}

// Of a panel in three dimensions over the mirror. z_offset: of the label of z.
std::string space_settings(const Scene& s, const char* view, const std::string& z_label, int z_offset) {
  return fmt::format(
      "set view {}\nset xyplane 0\nset xlabel offset 0,-1\nset zlabel '{}' rotate by 90 offset {},0\n"
      "set xtics {:.9g} offset 0,-0.4\nset ytics {:.9g} offset 1,-0.3\nset key off\n",
      view, z_label, z_offset, s.radius() * s.lateral.per_si, s.radius() * s.lateral.per_si);
}

/// The mirror in three dimensions, its profile, and where rays hit it.
void draw_mirror(const Scene& s, Picture* picture) {
  constexpr int kRings = 24, kSpokes = 73;
  constexpr Eigen::Index kDots = 3000;
  std::string surface = "# Mirror without roughness: x, y, z [m], rings with a blank line between\n";
  for (int i = 0; i <= kRings; ++i) {
    for (int k = 0; k < kSpokes; ++k) {
      const double rho = s.radius() * i / kRings, angle = 2 * kPi * k / (kSpokes - 1);
      const double x = rho * std::cos(angle), y = rho * std::sin(angle);
      surface += fmt::format("{:.6g} {:.6g} {:.6g}\n", x, y,
                             aperture_holds(s.aperture, x, y) ? base_surface(s.mirror, x, y).height : NAN);
    }
    surface += "\n";
  }
  const std::vector<Eigen::Index> dots = some_of(s.shown.pupil.size(), kDots);
  const Eigen::ArrayXd x = s.shown.pupil.x(dots), y = s.shown.pupil.y(dots);
  const Eigen::ArrayXd across = Eigen::ArrayXd::LinSpaced(201, -s.radius(), s.radius());
  picture->data.emplace_back("mirror_surface.dat", surface);
  picture->add_columns(
      "mirror_hits.dat",
      {fmt::format("{} of {} points where rays hit the mirror: x, y, z [m]", x.size(), s.shown.pupil.size())},
      {x, y, heights_at(s.mirror, x, y)});
  picture->add_columns("mirror_profile.dat", {"Profile through the vertex: x, z [m]"},
                       {across, heights_at(s.mirror, across, Eigen::ArrayXd::Zero(across.size()))});
  const AxisUnit depth = length_unit(base_surface(s.mirror, s.radius(), 0.0).height);
  const double u = s.lateral.per_si, v = depth.per_si;
  const std::string of_x = s.lateral.label("x"), of_y = s.lateral.label("y"), of_z = depth.label("z");
  const std::string space = space_settings(s, "62,35", of_z, 1);
  const std::string hits = fmt::format("hit points, {} of {}", x.size(), s.shown.pupil.size());
  const std::string dotted =
      fmt::format(" with points pointtype 7 pointsize 0.25 linecolor rgb '{}' notitle", kTargetColour);
  draw_panels(
      s.title("Mirror and hit points"), 1400, 1150, 2,
      {{"the mirror without roughness (z stretched)", of_x, of_y,
        space + "set palette defined (0 '#053061', 0.5 '#92c5de', 1 '#fddbc7')\nset colorbox\n",
        fmt::format("'mirror_surface.dat' using ($1*{0:.9g}):($2*{0:.9g}):($3*{1:.9g}):($3*{1:.9g}) with "
                    "pm3d notitle",
                    u, v),
        true},
       {"profile through the vertex", of_x, of_z, "set key off\n",
        fmt::format("'mirror_profile.dat' using ($1*{:.9g}):($2*{:.9g}) with lines linetype 2 notitle", u,
                    v)},
       {hits + ", in space", of_x, of_y, space,
        fmt::format("'mirror_hits.dat' using ($1*{0:.9g}):($2*{0:.9g}):($3*{1:.9g})", u, v) + dotted, true},
       {hits + ", in the aperture plane", of_x, of_y, "set key off\nset size ratio -1\n",
        fmt::format("'mirror_hits.dat' using ($1*{0:.9g}):($2*{0:.9g})", u) + dotted}},
      picture);
}

/// Reflected rays of the ideal mirror from the mirror through the focus, and the last piece for all cases.
void draw_reflected_rays(const Scene& s, Picture* picture) {
  constexpr Eigen::Index kRays = 60;
  constexpr double kBeyond = 1.08;  // of the focal length
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
  picture->data.emplace_back("reflected_rays_fan.dat", fan);
  std::vector<Panel> all = {
      {fmt::format("{} reflected rays of the ideal mirror, focus at z = {:.9g} m", some.size(), f),
       s.lateral.label("x"), s.lateral.label("y"), space_settings(s, "75,30", "z [m]", -1),
       fmt::format("'reflected_rays_fan.dat' using ($1*{0:.9g}):($2*{0:.9g}):3 with lines linetype 2 "
                   "linewidth 0.7 notitle",
                   s.lateral.per_si),
       true}};
  for (const Case& c : s.cases) {
    const double reach = 2.5 * c.ring * f / s.radius();
    const AxisUnit along = length_unit(reach), wide = length_unit(3 * c.ring);
    std::string lines = fmt::format("# Rays near the focus, {}: distance from z = f, x [m]\n", c.label);
    for (const Eigen::Index i : some)
      for (const double dz : {-reach, reach})
        lines += fmt::format("{:.6g} {:.6g}\n{}", dz, c.rays.x[i] + dz * c.rays.tx[i], dz > 0 ? "\n\n" : "");
    const std::string file = fmt::format("reflected_rays_{}.dat", c.key);
    picture->data.emplace_back(file, lines);
    all.push_back(
        {c.label + ", near the focus", along.label("distance from z = f"), wide.label("x"),
         "set key off\nset autoscale xfix\n",
         fmt::format("'{}' using ($1*{:.9g}):($2*{:.9g}) with lines linetype 2 linewidth 0.7 notitle", file,
                     along.per_si, wide.per_si)});
  }
  draw_panels(s.title("Reflected rays"), 1400, 1150, 2, all, picture);
}

/// Points of the published phase in the frequency plane.
void draw_frequencies(const Scene& s, Picture* picture) {
  constexpr int kBins = 28, kAngles = 24, kBands = 3;
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
  picture->add_columns("frequency_points.dat",
                       {"Points of the phase sum: log10(f/f_min) times cosine and sine of its direction"},
                       {decades * angle.cos(), decades * angle.sin()});
  picture->add_columns(
      "frequency_density.dat",
      {"f [/m], points in an equal step of log f, per unit of f [m], per unit of area [m^2]"},
      {middle, count, per_radius, per_area});
  picture->add_columns("frequency_angles.dat", {"direction [degrees], points in each of three bands"},
                       angles);
  draw_panels(
      s.title(fmt::format("Frequency sampling of the published phase, {} points", n)), 1400, 1150, 2,
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
        bands}},
      picture);
}

// What the values of the Harvey-Shack branch should follow, and from where to where it is shown.
struct Law {
  double low, high;
  std::function<double(double)> density;
  std::string label;
};
Law gauss(double sigma, double reach, const std::string& label) {
  const auto density = [=](double x) {
    return std::exp(-0.5 * x * x / (sigma * sigma)) / (sigma * std::sqrt(2 * kPi));
  };
  return {-reach, reach, density, label};
}
Law rayleigh(double sigma, double reach) {
  const auto density = [=](double r) {
    return r <= 0 ? 0.0 : r / (sigma * sigma) * std::exp(-0.5 * r * r / (sigma * sigma));
  };
  return {0, reach, density, "Rayleigh"};
}

// Of the Rayleigh law of a case: as wide as its deflections.
double per_axis(const Deflections& d) { return d.rms / std::numbers::sqrt2; }
double rayleigh_mean(const Deflections& d) { return std::sqrt(kPi / 2) * per_axis(d); }

// A dashed vertical line and its place in the key.
struct Upright {
  double x;
  std::string title;
};

// A histogram of the Harvey-Shack branch with a law, and the terms' histogram beside it. x_label: with its
// unit in brackets.
Panel histogram_panel(const Scene& s, Picture* picture, const std::string& key, const std::string& title,
                      const std::string& x_label, const Eigen::ArrayXd& hs, const Eigen::ArrayXd& terms,
                      const Law& law, const std::vector<Upright>& marks = {}) {
  constexpr int kBins = 61;
  Eigen::ArrayXd middle(kBins);
  for (int b = 0; b < kBins; ++b) middle[b] = law.low + (law.high - law.low) * (b + 0.5) / kBins;
  const std::string file = picture->name + "_" + key + ".dat";
  picture->add_columns(
      file, {title, "middle of the bin: " + x_label + "; density of Harvey-Shack, law, terms"},
      {middle, weighted_density(hs, s.hs.weight, law.low, law.high, kBins), middle.unaryExpr(law.density),
       weighted_density(terms, s.terms.weight, law.low, law.high, kBins)});
  const std::size_t unit = x_label.find('[') + 1;
  Panel panel{title, x_label, "density [1/(" + x_label.substr(unit, x_label.find(']') - unit) + ")]",
              "set yrange [0:*]\nset offsets 0,0,graph 0.28,0\n",
              fmt::format("'{0}' using 1:2 with histeps linecolor rgb '{1}' linewidth 2 dashtype 1 title "
                          "'Harvey-Shack', '' using 1:3 with lines linetype 1 title {3}, '' using 1:4 with "
                          "histeps linecolor rgb '{2}' linewidth 1.2 dashtype 1 title 'terms, one draw'",
                          file, kTargetColour, kFittedColour, gnuplot_text(law.label))};
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
void draw_gradients(const Scene& s, Picture* picture) {
  const double scale = 4 * kPi / s.wavelength;  // of a deflection [rad], in rad/m
  const double sx = scale * s.hs.rms_x, sy = scale * s.hs.rms_y, total = std::hypot(sx, sy);
  const double reach = 4 * std::max(sx, sy);
  const auto component = [&](const std::string& axis, const Eigen::ArrayXd& hs, double sigma,
                             const Eigen::ArrayXd& terms) {
    return histogram_panel(s, picture, axis, "component along " + axis, "dPhi/d" + axis + " [rad/m]",
                           scale * hs, scale * terms,
                           gauss(sigma, reach, fmt::format("Gaussian, RMS {:.4g} rad/m", sigma)));
  };
  std::vector<Panel> all = {component("x", s.hs.x, sx, s.terms.x), component("y", s.hs.y, sy, s.terms.y)};
  const std::vector<Eigen::Index> dots = some_of(s.hs.x.size(), 5000);
  picture->add_columns("phase_gradients_scatter.dat",
                       {"dPhi/dx, dPhi/dy [rad/m] of rays of the Harvey-Shack branch"},
                       {scale * s.hs.x(dots), scale * s.hs.y(dots)});
  all.push_back(
      {fmt::format("both components, {} of {} rays", dots.size(), s.hs.x.size()), "dPhi/dx [rad/m]",
       "dPhi/dy [rad/m]",
       "set size ratio -1\nset samples 181\n" + symmetric_range("x", reach) + symmetric_range("y", reach) +
           "set key top right\n",
       fmt::format(
           "'phase_gradients_scatter.dat' with points pointtype 7 pointsize 0.2 linecolor rgb '{}' title "
           "'Harvey-Shack', for [k=1:3] [0:2*pi] '+' using (k*{:.9g}*cos($1)):(k*{:.9g}*sin($1)) with lines "
           "linecolor rgb 'black' linewidth 1.2 dashtype k title sprintf('%d sigma', k)",
           kTargetColour, sx, sy)});
  all.push_back(histogram_panel(s, picture, "magnitude", "magnitude", "|grad Phi| [rad/m]",
                                scale * s.hs.magnitude, scale * s.terms.magnitude,
                                rayleigh(total / std::numbers::sqrt2, reach),
                                {{total, fmt::format("RMS {:.4g} rad/m", total)}}));
  draw_panels(s.title("Phase gradients, (4 pi/lambda) times the deflection"), 1400, 1150, 2, all, picture);
}

/// Deflection of the rays: components and magnitude.
void draw_deflections(const Scene& s, Picture* picture) {
  const Deflections &hs = s.hs, &terms = s.terms;
  const AxisUnit unit = angle_unit(3 * hs.rms), fine = angle_unit(3 * hs.rms_z);
  const double u = unit.per_si, reach = 4 * u * std::max(hs.rms_x, hs.rms_y);
  const auto component = [&](const std::string& axis, const Eigen::ArrayXd& of_hs, double sigma,
                             const Eigen::ArrayXd& of_terms, double far, const std::string& x_label,
                             double per) {
    return histogram_panel(s, picture, axis, "component along " + axis, x_label, per * of_hs, per * of_terms,
                           gauss(per * sigma, far, fmt::format("Gaussian, std {:.4g}", per * sigma)));
  };
  std::vector<Panel> all = {component("x", hs.x, hs.rms_x, terms.x, reach, unit.label("deflection"), u),
                            component("y", hs.y, hs.rms_y, terms.y, reach, unit.label("deflection"), u),
                            component("z", hs.z, hs.rms_z, terms.z, 4 * fine.per_si * hs.rms_z,
                                      fine.label("change of the direction cosine z"), fine.per_si)};
  all.push_back(histogram_panel(
      s, picture, "magnitude", "magnitude", unit.label("|D|"), u * hs.magnitude, u * terms.magnitude,
      rayleigh(u * per_axis(hs), reach),
      {{u * rayleigh_mean(hs), fmt::format("mean {:.4g} {}", u * rayleigh_mean(hs), unit.name)},
       {u * hs.rms, fmt::format("RMS {:.4g} {}", u * hs.rms, unit.name)}}));
  draw_panels(s.title("Deflections of the rays"), 1400, 1150, 2, all, picture);
}

/// Scatter angles, on the sky's scale.
void draw_scatter_angles(const Scene& s, Picture* picture) {
  const double sigma = per_axis(s.hs) / kArcsec, reach = 7.7 * sigma;  // 20 arcsec for the paper's spot
  const double mean = rayleigh_mean(s.hs) / kArcsec, rms = s.hs.rms / kArcsec;
  const Panel panel = histogram_panel(
      s, picture, "all", "angle between each ray and its ideal ray", "scatter angle [arcsec]",
      s.hs.magnitude / kArcsec, s.terms.magnitude / kArcsec, rayleigh(sigma, reach),
      {{mean, fmt::format("mean {:.4g} arcsec", mean)}, {rms, fmt::format("RMS {:.4g} arcsec", rms)}});
  draw_panels(s.title("Scatter angles"), 1200, 800, 1, {panel}, picture);
}

/// N(z) of each case through its own ring.
void draw_ring(const Scene& s, Picture* picture) {
  constexpr int kPoints = 801;
  std::vector<Panel> all;
  for (const Case& c : s.cases) {
    const double last = 3.5 * c.ring * s.mirror.focal_length / s.radius();
    const Eigen::ArrayXd planes = Eigen::ArrayXd::LinSpaced(kPoints, -last, last);
    const Eigen::ArrayXd share = ring_through_curve(c.rays, Centre::kNominal, c.ring, planes);
    const double width = statistic_of(c.rays, s.shown, RingFwhm{0.9, c.ring});
    const std::string file = fmt::format("ring_through_{}.dat", c.key);
    picture->add_columns(file,
                         {fmt::format("Share of the rays inside a ring of {:.9g} m, {}", c.ring, c.label),
                          "distance from z = f [m], share"},
                         {planes, share});
    const AxisUnit unit = length_unit(last);
    all.push_back(
        {fmt::format("{}: ring {}, FWHM {}", c.label, display(c.ring, Dimension::kLength),
                     display(width, Dimension::kLength)),
         unit.label("distance from z = f"), "share of the rays in the ring",
         "set key off\nset yrange [0:1.05]\n" + symmetric_range("x", last * unit.per_si),
         fmt::format(
             "'{}' using ($1*{:.9g}):2 with lines linetype 2 notitle, {:.9g} with lines linetype 1 notitle",
             file, unit.per_si, 0.5 * share.maxCoeff())});
  }
  draw_panels(s.title("Rays through a ring, half maximum dotted"), 1100, 1300, 1, all, picture);
}

/// Cuts through the height error of the traced terms.
void draw_height(const Scene& s, Picture* picture) {
  constexpr int kPoints = 801;
  const Eigen::ArrayXd across = Eigen::ArrayXd::LinSpaced(kPoints, -s.radius(), s.radius());
  const Eigen::ArrayXd none = Eigen::ArrayXd::Zero(kPoints);
  SurfaceField along_x, along_y;
  const GivenSurface& surface = s.shown.surface;
  SurfaceOperator(surface.terms, across, none).apply(surface.coefficients, &along_x);
  SurfaceOperator(surface.terms, none, across).apply(surface.coefficients, &along_y);
  Eigen::ArrayXd on_x = along_x.height, on_y = along_y.height;
  for (int i = 0; i < kPoints; ++i) {
    if (!aperture_holds(s.aperture, across[i], 0)) on_x[i] = NAN;
    if (!aperture_holds(s.aperture, 0, across[i])) on_y[i] = NAN;
  }
  const Eigen::ArrayXd& h = s.shown.field.height;
  const Eigen::ArrayXd w = s.shown.pupil.weight / s.shown.pupil.weight.sum();
  const double mean = (w * h).sum(), rms = std::sqrt((w * (h - mean).square()).sum());
  const AxisUnit unit = length_unit(3 * rms);
  picture->add_columns("height_profile.dat",
                       {"Height error of the terms through the vertex: position, along x, along y [m]"},
                       {across, on_x, on_y});
  const auto curve = [&](int column, int type, const char* title) {
    return fmt::format(
        "'height_profile.dat' using ($1*{:.9g}):(${}*{:.9g}) with lines linetype {} title '{}'",
        s.lateral.per_si, column, unit.per_si, type, title);
  };
  draw_panels(s.title("Height error of the aberration terms"), 1200, 700, 1,
              {{fmt::format("one draw, RMS over the aperture {}{}", display(rms, Dimension::kLength),
                            s.report.convention == Convention::kPaper
                                ? " (half the specified: convention paper deflects half as much)"
                                : ""),
                s.lateral.label("distance from the vertex"), unit.label("height"),
                symmetric_range("x", s.radius() * s.lateral.per_si) + "set offsets 0,0,graph 0.15,0\n",
                curve(2, 2, "along x (y = 0)") + ", " + curve(3, 3, "along y (x = 0)")}},
              picture);
}

// A line of an image: where its first pixel is, and the step to the next.
struct PixelLine {
  double first, step;
};

// An image of a case: share of its brightest pixel, square root, so that faint parts show.
std::string image_plot(const std::string& file, const PixelLine& x, const PixelLine& y, double largest) {
  return fmt::format("'{}' matrix using ({:.9g}+$1*{:.9g}):({:.9g}+$2*{:.9g}):(sqrt($3/{:.9g})) with image",
                     file, x.first, x.step, y.first, y.step, std::max(largest, 1e-300));
}
constexpr const char* kImageSettings =
    "set key off\nunset grid\nset tics out\nset cbrange [0:1]\n"
    "set palette defined (0 'black', 0.35 '#3b0f70', 0.65 '#de4968', 1 '#fcfdbf')\n";

/// Images of all cases in three planes.
void draw_images(const Scene& s, Picture* picture) {
  constexpr int kPixels = 75;
  constexpr double kHalfWidth = 3.95, kPlanes[] = {-1.4, 0, 1.4};  // of the ring, and of ring f/R
  std::vector<Panel> all;
  for (const Case& c : s.cases) {
    const double half = kHalfWidth * (s.is_ideal(c) ? 3 / kHalfWidth : 1.0) * c.ring;
    const AxisUnit unit = length_unit(half);
    const double pixel = 2 * half / kPixels;
    const PixelLine line{(-half + 0.5 * pixel) * unit.per_si, pixel * unit.per_si};
    const std::string square = "set size ratio -1\n" + symmetric_range("x", half * unit.per_si) +
                               symmetric_range("y", half * unit.per_si);
    for (std::size_t k = 0; k < std::size(kPlanes); ++k) {
      const double dz = kPlanes[k] * c.ring * s.mirror.focal_length / s.radius();
      const std::string offset =
          dz == 0 ? "" : (dz < 0 ? " - " : " + ") + display(std::abs(dz), Dimension::kLength);
      const Eigen::ArrayXXd image = focal_image(c.rays, Centre::kNominal, dz, half, kPixels);
      const std::string file = fmt::format("focal_images_{}_{}.dat", c.key, k);
      picture->add_matrix(file,
                          {fmt::format("Share of the rays per pixel of {:.6g} m, {} at {:.6g} m from z = f",
                                       pixel, c.label, dz)},
                          image);
      all.push_back({c.label + ", z = f" + offset, unit.label("x"), unit.label("y"), kImageSettings + square,
                     image_plot(file, line, line, image.maxCoeff())});
    }
  }
  draw_panels(s.title("Focal images by rays, colour: root of the brightness"), 1500, 1500, 3, all, picture);
}

/// Light along x in planes through the focus.
void draw_volume(const Scene& s, Picture* picture) {
  constexpr int kPixels = 121, kPlanes = 161;
  std::vector<Panel> all;
  for (const Case& c : s.cases) {
    const double last = 3 * c.ring * s.mirror.focal_length / s.radius(), half = 3.5 * c.ring;
    Eigen::ArrayXXd light(kPixels, kPlanes);
    for (int k = 0; k < kPlanes; ++k) {
      const double dz = last * (2.0 * k / (kPlanes - 1) - 1);
      light.col(k) = weighted_density(c.rays.x + dz * c.rays.tx, c.rays.weight, -half, half, kPixels) * 2 *
                     half / kPixels;
    }
    const std::string file = fmt::format("focal_volume_{}.dat", c.key);
    picture->add_matrix(file,
                        {fmt::format("Share of the rays in strips of {:.6g} m along y, {}; rows -x to +x, "
                                     "columns {:.6g} to {:.6g} m from z = f",
                                     2 * half / kPixels, c.label, -last, last)},
                        light);
    const AxisUnit along = length_unit(last), wide = length_unit(half);
    const double dx = 2 * half / kPixels * wide.per_si, dz = 2 * last / (kPlanes - 1) * along.per_si;
    // The ideal focus is one strip, so bright that nothing else would show.
    const double largest = (s.is_ideal(c) ? 0.25 : 1.0) * light.maxCoeff();
    all.push_back(
        {c.label, along.label("distance from z = f"), wide.label("x"),
         kImageSettings + symmetric_range("x", last * along.per_si) +
             symmetric_range("y", half * wide.per_si),
         image_plot(file, {-last * along.per_si, dz}, {-half * wide.per_si + 0.5 * dx, dx}, largest)});
  }
  draw_panels(s.title("Focal volume, colour: root of the brightness"), 1100, 1300, 1, all, picture);
}

using Drawing = void(const Scene&, Picture*);
constexpr std::pair<const char*, Drawing*> kPictures[] = {{"mirror", draw_mirror},
                                                          {"reflected_rays", draw_reflected_rays},
                                                          {"frequency_sampling", draw_frequencies},
                                                          {"phase_gradients", draw_gradients},
                                                          {"deflections", draw_deflections},
                                                          {"scatter_angles", draw_scatter_angles},
                                                          {"ring_through", draw_ring},
                                                          {"height_profile", draw_height},
                                                          {"focal_images", draw_images},
                                                          {"focal_volume", draw_volume}};

}  // namespace

const std::vector<std::string>& verify_picture_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const auto& [name, draw] : kPictures) all.emplace_back(name);
    return all;
  }();
  return names;
}

std::vector<std::string> write_verify_plots(const VerifyReport& report, const Mirror& mirror,
                                            const Aperture& aperture, double wavelength,
                                            const std::string& directory, Warnings* warnings) {
  const VerifyRays& shown = *report.shown;
  const EncircledEnergyRadius ee90;
  // The ideal focus is a point: its ring is chosen, as the paper chose it.
  const std::vector<Case> cases = {
      {"ideal", "ideal mirror", shown.nominal, kIdealRing},
      {"harvey_shack", "Harvey-Shack", shown.harvey_shack, statistic_of(shown.harvey_shack, shown, ee90)},
      {"terms", "aberration terms", shown.terms, statistic_of(shown.terms, shown, ee90)}};
  const Scene scene{report,
                    mirror,
                    aperture,
                    wavelength,
                    shown,
                    cases,
                    length_unit(aperture_radius(aperture)),
                    deflections_of(shown.harvey_shack, shown.nominal),
                    deflections_of(shown.terms, shown.nominal)};
  std::vector<Picture> pictures;
  for (const auto& [name, draw] : kPictures) {
    if (draw == draw_frequencies && shown.published_modes.empty()) continue;
    pictures.push_back({name, "", {}});
    draw(scene, &pictures.back());
  }
  return draw_pictures(pictures, directory, warnings);
}

}  // namespace aberfit
