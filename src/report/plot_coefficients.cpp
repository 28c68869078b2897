#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "aberfit/scene/zernike.h"
#include "fit_pictures.h"

namespace aberfit::internal {
namespace {

// Standard deviation of coefficient i; 0 if none was computed, so that the band vanishes.
double deviation(const ResultDocument& result, Eigen::Index i) {
  const Eigen::VectorXd& std = result.fitted.fit.coefficient_std;
  return i < std.size() && std::isfinite(std[i]) ? std[i] : 0.0;
}

void zernike_panels(const ResultDocument& result, Picture* picture) {
  const std::vector<ZernikeMode>& modes = result.fitted.terms.zernike;
  const Eigen::Index count = Eigen::Index(modes.size());
  std::vector<Eigen::Index> order(modes.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](Eigen::Index a, Eigen::Index b) {
    return noll_index(modes[std::size_t(a)]) < noll_index(modes[std::size_t(b)]);
  });
  Eigen::ArrayXd noll(count), n(count), m(count), value(count), std(count);
  struct Sum {
    double value2 = 0, std2 = 0;
  };
  std::map<int, Sum> orders;
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::Index k = order[std::size_t(i)];
    const ZernikeMode& mode = modes[std::size_t(k)];
    noll[i] = noll_index(mode);
    n[i] = mode.n;
    m[i] = mode.m;
    value[i] = result.fitted.fit.coefficients[k];
    std[i] = deviation(result, k);
    orders[mode.n].value2 += value[i] * value[i];
    orders[mode.n].std2 += std[i] * std[i];
  }
  picture->add_columns("coefficients_zernike.dat",
                       {"Orthonormal Zernike coefficients of the fitted surface, by Noll index",
                        "columns: noll n m value_m std_m"},
                       {noll, n, m, value, std});
  Eigen::ArrayXd radial(Eigen::Index(orders.size())), rms(radial.size()), spread(radial.size());
  Eigen::Index row = 0;
  for (const auto& [degree, sum] : orders) {
    radial[row] = degree;
    rms[row] = std::sqrt(sum.value2);
    spread[row++] = std::sqrt(sum.std2);
  }
  picture->add_columns("coefficients_orders.dat",
                       {"Root sum of squares over the Zernike coefficients of one radial order",
                        "columns: n rms_height_m rms_std_m"},
                       {radial, rms, spread});

  // Axes are linear as long as all orders are legible.
  const bool steep = rms.minCoeff() > 0 && largest_size(rms) > 30 * rms.minCoeff();
  picture->set("steep", int(steep));
  // A coefficient that is nearly 0 by chance must not stretch the axis.
  picture->set("lowest", rms.minCoeff() / 300);
  picture->set("mark", count > 400 ? 0.35 : 0.7);
  picture->set("first_noll", noll.minCoeff());
  picture->set("last_noll", noll.maxCoeff());
  picture->set("first_order", radial.minCoeff());
  picture->set("last_order", radial.maxCoeff());
  picture->set("z", length_unit(std::max(largest_size(value), largest_size(std))));
  picture->set("o", length_unit(std::max(largest_size(rms), largest_size(spread))));
}

void fourier_panel(const ResultDocument& result, Picture* picture) {
  const std::vector<FourierMode>& modes = result.fitted.terms.fourier;
  const Eigen::Index count = Eigen::Index(modes.size());
  Eigen::ArrayXd fx(count), fy(count), f(count), amplitude(count), std(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::Index k = result.fitted.terms.fourier_begin() + 2 * i;
    fx[i] = modes[std::size_t(i)].fx;
    fy[i] = modes[std::size_t(i)].fy;
    f[i] = std::hypot(fx[i], fy[i]);
    amplitude[i] = std::hypot(result.fitted.fit.coefficients[k], result.fitted.fit.coefficients[k + 1]);
    std[i] = std::hypot(deviation(result, k), deviation(result, k + 1));
  }
  picture->add_columns("coefficients_fourier.dat",
                       {"Amplitudes of the plane waves of the fitted surface",
                        "columns: frequency_per_m fx_per_m fy_per_m amplitude_m std_m"},
                       {f, fx, fy, amplitude, std});
  picture->set("first_frequency", f.minCoeff() / 1.05);
  picture->set("last_frequency", f.maxCoeff() * 1.05);
  picture->set("f", length_unit(std::max(largest_size(amplitude), largest_size(std))));
}

void spherical_panel(const ResultDocument& result, Picture* picture) {
  const std::vector<int>& powers = result.fitted.terms.spherical;
  const Eigen::Index count = Eigen::Index(powers.size());
  Eigen::ArrayXd power(count), value(count), std(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::Index k = result.fitted.terms.spherical_begin() + i;
    power[i] = powers[std::size_t(i)];
    value[i] = result.fitted.fit.coefficients[k];
    std[i] = deviation(result, k);
  }
  picture->add_columns(
      "coefficients_spherical.dat",
      {"Spherical terms of the fitted surface: height at the rim", "columns: power_of_rho value_m std_m"},
      {power, value, std});
  picture->set("p", length_unit(std::max(largest_size(value), largest_size(std))));
}

}  // namespace

Picture coefficients_picture(const FitPictures& fit) {
  constexpr Eigen::Index kFewPoints = 1200;
  const ResultDocument& result = fit.result;
  Picture picture("coefficients", result.title);
  const int zernikes = !result.fitted.terms.zernike.empty(), waves = !result.fitted.terms.fourier.empty(),
            sphericals = !result.fitted.terms.spherical.empty();
  if (zernikes) zernike_panels(result, &picture);
  if (waves) fourier_panel(result, &picture);
  if (sphericals) spherical_panel(result, &picture);
  const int panels = 2 * zernikes + waves + sphericals;
  picture.has_cloud = result.fitted.terms.size() > kFewPoints;
  picture.set("zernikes", zernikes);
  picture.set("waves", waves);
  picture.set("sphericals", sphericals);
  picture.set("deviations", int(result.fitted.fit.coefficient_std.size() > 0));
  picture.set("rows", std::min(panels, 2));
  picture.set("columns", panels > 2 ? 2 : 1);
  picture.set("width", panels > 2 ? 1500 : 1200);
  picture.set("height", panels > 1 ? 1000 : 700);
  return picture;
}

}  // namespace aberfit::internal
