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

// The ideal mirror, the Harvey-Shack branch or the aberration terms.
struct Case {
  std::string key, label;
  const RayBundle& rays;
  double ring;  // radius of the ring of its curve [m]
};

// Data of all pictures.
struct Scene {
  const VerifyPictures& of;
  const VerifyRays& shown;
  std::vector<Case> cases;
  double radius;  // radius of the aperture [m]

  double focal_length() const { return of.mirror.focal_length; }
  /// Distance from z = f at which a cone of light is as wide as a ring [m].
  double depth(const Case& c) const { return c.ring * focal_length() / radius; }
  Picture picture(const std::string& name, const std::string& script = "") const {
    Picture made(name, of.report.title, script);
    std::vector<std::string> labels, keys;
    for (const Case& c : cases) labels.push_back(c.label), keys.push_back(c.key);
    made.set("label", labels);
    made.set("key", keys);
    return made;
  }
};

double statistic_of(const RayBundle& rays, const VerifyRays& shown, const Statistic& statistic) {
  return ray_statistic(rays, shown.nominal, Centre::kNominal, statistic);
}

// Variables with one value per case.
struct PerCase {
  std::vector<double> per_si, size;
  std::vector<std::string> unit;
  void add(const AxisUnit& of, double value) {
    per_si.push_back(of.per_si), unit.push_back(of.name), size.push_back(value);
  }
  void set(const std::string& axis, const std::string& name, Picture* picture) const {
    picture->set(axis + "_scale", per_si);
    picture->set(axis + "_unit", unit);
    picture->set(name, size);
  }
};

// About `count` of n indices at even steps. The order must be random or regular, not sorted by the quantity
// shown.
std::vector<Eigen::Index> some_of(Eigen::Index n, Eigen::Index count) {
  std::vector<Eigen::Index> chosen;
  const double step = std::max(1.0, double(n) / double(count));
  for (double at = 0; at < double(n); at += step) chosen.push_back(Eigen::Index(at));
  return chosen;
}

Picture rays_picture(const Scene& s) {
  constexpr Eigen::Index kRays = 60;
  constexpr double kBeyond = 0.08, kReach = 2.5;  // fractions of the focal length and of the depth
  const double f = s.focal_length();
  const std::vector<Eigen::Index> some = some_of(s.shown.pupil.size(), kRays);
  Picture picture = s.picture("reflected_rays");
  const auto line = [](double z1, double x1, double z2, double x2) {
    return PictureColumns{Eigen::Array2d(z1, z2), Eigen::Array2d(x1, x2)};
  };
  std::vector<PictureColumns> fan;
  for (const Eigen::Index i : some) {
    const RayBundle& r = s.shown.nominal;
    const double x = s.shown.pupil.x[i], y = s.shown.pupil.y[i];
    fan.push_back(
        line(base_surface(s.of.mirror, x, y).height, x, (1 + kBeyond) * f, r.x[i] + kBeyond * f * r.tx[i]));
  }
  picture.add_blocks("reflected_rays_fan.dat",
                     {"Reflected rays of the ideal mirror, z [m] and x [m] of hit point and far end"}, fan);
  PerCase along, across;
  for (const Case& c : s.cases) {
    const double reach = kReach * s.depth(c);
    std::vector<PictureColumns> lines;
    for (const Eigen::Index i : some)
      lines.push_back(
          line(-reach, c.rays.x[i] - reach * c.rays.tx[i], reach, c.rays.x[i] + reach * c.rays.tx[i]));
    picture.add_blocks(fmt::format("reflected_rays_{}.dat", c.key),
                       {"Rays near the focus, " + c.label + ": distance from z = f [m], x [m]"}, lines);
    along.add(length_unit(reach), reach);
    across.add(length_unit(3 * c.ring), c.ring);
  }
  along.set("z", "reach", &picture);
  across.set("w", "ring", &picture);
  picture.set("rays", int(some.size()));
  picture.set("focal_length", f);
  picture.set("x", length_unit(s.radius));
  return picture;
}

// The values of the Harvey-Shack branch should follow these laws.
double gauss(double x, double sigma) {
  return std::exp(-0.5 * x * x / (sigma * sigma)) / (sigma * std::sqrt(2 * kPi));
}
double rayleigh(double r, double sigma) {
  return r <= 0 ? 0.0 : r / (sigma * sigma) * std::exp(-0.5 * r * r / (sigma * sigma));
}

// Components of the deflections and their magnitude, with their laws.
Picture deflections_picture(const Scene& s) {
  constexpr int kBins = 61;
  const Deflections hs = deflections_of(s.shown.harvey_shack, s.shown.nominal),
                    terms = deflections_of(s.shown.terms, s.shown.nominal);
  const double per_axis = hs.rms / std::numbers::sqrt2, far = 4 * std::max(hs.rms_x, hs.rms_y);
  struct Panel {
    const Eigen::ArrayXd &hs, &terms;
    double low, high, sigma;
    double (*law)(double, double);
  };
  const Panel panels[] = {{hs.x, terms.x, -far, far, hs.rms_x, gauss},
                          {hs.y, terms.y, -far, far, hs.rms_y, gauss},
                          {hs.z, terms.z, -4 * hs.rms_z, 4 * hs.rms_z, hs.rms_z, gauss},
                          {hs.magnitude, terms.magnitude, 0, far, per_axis, rayleigh}};
  Picture picture = s.picture("deflections");
  std::vector<PictureColumns> blocks;
  PerCase of_panels;
  std::vector<double> low, high;
  for (const Panel& p : panels) {
    Eigen::ArrayXd middle(kBins);
    for (int b = 0; b < kBins; ++b) middle[b] = p.low + (p.high - p.low) * (b + 0.5) / kBins;
    blocks.push_back({middle, weighted_density(p.hs, hs.weight, p.low, p.high, kBins),
                      middle.unaryExpr([&](double x) { return p.law(x, p.sigma); }),
                      weighted_density(p.terms, terms.weight, p.low, p.high, kBins)});
    of_panels.add(angle_unit(0.75 * p.high), p.sigma);
    low.push_back(p.low), high.push_back(p.high);
  }
  picture.add_blocks("deflections.dat",
                     {"Deflections of the rays along x, y and z and their magnitude, one block each: middle "
                      "of the bin [rad], density of Harvey-Shack, law, terms [1/rad]"},
                     blocks);
  of_panels.set("d", "sigma", &picture);
  picture.set("low", low);
  picture.set("high", high);
  picture.set("rms", hs.rms);
  picture.set("mean", std::sqrt(kPi / 2) * per_axis);
  return picture;
}

// N(z) of each case through its own ring.
Picture ring_picture(const Scene& s) {
  constexpr int kPoints = 401;
  Picture picture = s.picture("ring_through", "verify_ring_through");
  std::vector<PictureColumns> blocks;
  std::vector<std::string> texts;
  std::vector<double> half;
  PerCase along;
  for (const Case& c : s.cases) {
    const double last = 3.5 * s.depth(c);
    const Eigen::ArrayXd planes = Eigen::ArrayXd::LinSpaced(kPoints, -last, last);
    blocks.push_back({planes, ring_through_curve(c.rays, Centre::kNominal, c.ring, planes)});
    half.push_back(0.5 * blocks.back()[1].maxCoeff());
    texts.push_back(
        fmt::format("{}: ring {}, FWHM {}", c.label, display(c.ring, Dimension::kLength),
                    display(statistic_of(c.rays, s.shown, RingFwhm{0.9, c.ring}), Dimension::kLength)));
    along.add(length_unit(last), last);
  }
  picture.add_blocks(
      "ring_through.dat",
      {"Fraction of the rays inside a ring of each case, one block each: distance from z = f [m], fraction"},
      blocks);
  along.set("z", "last", &picture);
  picture.set("ring_title", texts);
  picture.set("half_maximum", half);
  return picture;
}

// Cuts through the height error of the traced terms.
Picture height_picture(const Scene& s) {
  constexpr int kPoints = 801;
  const Eigen::ArrayXd across = Eigen::ArrayXd::LinSpaced(kPoints, -s.radius, s.radius);
  const Eigen::ArrayXd none = Eigen::ArrayXd::Zero(kPoints);
  SurfaceField along_x, along_y;
  const GivenSurface& surface = s.shown.surface;
  SurfaceOperator(surface.terms, across, none).apply(surface.coefficients, &along_x);
  SurfaceOperator(surface.terms, none, across).apply(surface.coefficients, &along_y);
  for (int i = 0; i < kPoints; ++i) {
    if (!aperture_holds(s.of.aperture, across[i], 0)) along_x.height[i] = NAN;
    if (!aperture_holds(s.of.aperture, 0, across[i])) along_y.height[i] = NAN;
  }
  const Eigen::ArrayXd& h = s.shown.field.height;
  const Eigen::ArrayXd w = s.shown.pupil.weight / s.shown.pupil.weight.sum();
  const double mean = (w * h).sum(), rms = std::sqrt((w * (h - mean).square()).sum());
  Picture picture = s.picture("height_profile");
  picture.add_columns("height_profile.dat",
                      {"Height error of the terms through the vertex: position, along x, along y [m]"},
                      {across, along_x.height, along_y.height});
  picture.set("radius", s.radius);
  picture.set("x", length_unit(s.radius));
  picture.set("h", length_unit(3 * rms));
  picture.set("rms", display(rms, Dimension::kLength));
  picture.set("halved", int(s.of.report.convention == Convention::kPaper));
  return picture;
}

// Images of all cases in three planes.
Picture images_picture(const Scene& s) {
  constexpr int kPixels = 75;
  constexpr double kHalfWidth = 3.5, kPlanes[] = {-1.4, 0, 1.4};  // in units of the ring and of the depth
  Picture picture = s.picture("focal_images", "verify_focal_images");
  std::vector<std::string> planes;
  std::vector<double> brightest;
  PerCase across;
  for (const Case& c : s.cases) {
    const double half = kHalfWidth * c.ring, pixel = 2 * half / kPixels;
    across.add(length_unit(half), half);
    for (std::size_t k = 0; k < std::size(kPlanes); ++k) {
      const double dz = kPlanes[k] * s.depth(c);
      const Eigen::ArrayXXd image = focal_image(c.rays, Centre::kNominal, dz, half, kPixels);
      picture.add_matrix(fmt::format("focal_images_{}_{}.dat", c.key, k + 1),
                         {fmt::format("Fraction of the rays per pixel of {:.6g} m, {} at {:.6g} m from z = f",
                                      pixel, c.label, dz)},
                         image);
      planes.push_back(
          fmt::format("{}, z = f{}", c.label,
                      dz == 0 ? "" : (dz < 0 ? " - " : " + ") + display(std::abs(dz), Dimension::kLength)));
      brightest.push_back(std::max(image.maxCoeff(), 1e-300));
    }
  }
  across.set("x", "half", &picture);
  picture.set("pixels", kPixels);
  picture.set("plane", planes);
  picture.set("brightest", brightest);
  return picture;
}

// Irradiance along x in planes through the focus.
Picture volume_picture(const Scene& s) {
  constexpr int kPixels = 121, kPlanes = 161;
  Picture picture = s.picture("focal_volume");
  std::vector<double> brightest;
  PerCase along, across;
  for (const Case& c : s.cases) {
    const double last = 3 * s.depth(c), half = 3.5 * c.ring;
    Eigen::ArrayXXd light(kPixels, kPlanes);
    for (int k = 0; k < kPlanes; ++k) {
      const double dz = last * (2.0 * k / (kPlanes - 1) - 1);
      light.col(k) = weighted_density(c.rays.x + dz * c.rays.tx, c.rays.weight, -half, half, kPixels) * 2 *
                     half / kPixels;
    }
    picture.add_matrix(
        fmt::format("focal_volume_{}.dat", c.key),
        {fmt::format("Fraction of the rays in strips of {:.6g} m along y, {}; rows -x to +x, columns "
                     "{:.6g} to {:.6g} m from z = f",
                     2 * half / kPixels, c.label, -last, last)},
        light);
    // The ideal focus is one strip, so bright that it would hide everything else.
    brightest.push_back((&c.rays == &s.shown.nominal ? 0.25 : 1.0) * light.maxCoeff());
    along.add(length_unit(last), last);
    across.add(length_unit(half), half);
  }
  along.set("z", "last", &picture);
  across.set("x", "half", &picture);
  picture.set("pixels", kPixels);
  picture.set("planes", kPlanes);
  picture.set("brightest", brightest);
  return picture;
}

}  // namespace

const std::vector<std::string>& verify_picture_names() {
  static const std::vector<std::string> names = {"reflected_rays", "deflections",  "ring_through",
                                                 "height_profile", "focal_images", "focal_volume"};
  return names;
}

std::vector<DrawnPicture> draw_pictures(const VerifyPictures& of, const std::string& directory,
                                        const PictureOptions& options, Warnings* warnings) {
  if (options.format == PictureFormat::kNone) return {};
  const VerifyRays& shown = *of.report.shown;
  const EncircledEnergyRadius ee90;
  // The ideal focus is a point, so its ring is the one chosen in the paper.
  const Scene scene{
      of,
      shown,
      {{"ideal", "ideal mirror", shown.nominal, kIdealRing},
       {"harvey_shack", "Harvey-Shack", shown.harvey_shack, statistic_of(shown.harvey_shack, shown, ee90)},
       {"terms", "aberration terms", shown.terms, statistic_of(shown.terms, shown, ee90)}},
      aperture_radius(of.aperture)};
  return draw({images_picture(scene), volume_picture(scene), ring_picture(scene), deflections_picture(scene),
               height_picture(scene), rays_picture(scene)},
              directory, options, warnings);
}

}  // namespace aberfit
