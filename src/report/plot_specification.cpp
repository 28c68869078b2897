#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "aberfit/core/errors.h"
#include "aberfit/theory/scatter_function.h"
#include "fit_pictures.h"

namespace aberfit::internal {
namespace {

// Number of decades of the axis below the largest value; fainter values are useless.
constexpr double kDecades = 10;

PictureColumns bins_of(const Character& character) {
  PictureColumns columns(6, Eigen::ArrayXd(Eigen::Index(character.psd.size())));
  for (std::size_t i = 0; i < character.psd.size(); ++i) {
    const CharacterBin& bin = character.psd[i];
    const auto k = Eigen::Index(i);
    columns[0][k] = bin.low, columns[1][k] = bin.high, columns[2][k] = bin.specification;
    columns[3][k] = bin.specification * bin.ratio.value;
    columns[4][k] = bin.specification * bin.ratio.low, columns[5][k] = bin.specification * bin.ratio.high;
  }
  return columns;
}

void add_scatter(const std::string& name, const ScatterTable& table, Picture* picture) {
  picture->add_columns("bsdf_" + name + ".dat",
                       {fmt::format("Scatter function of RMS height {:.9g} m in the band {:.9g} to {:.9g} /m",
                                    table.rms_height, table.f_min, table.f_max),
                        "columns: theta_rad bsdf_per_sr"},
                       {table.theta, table.bsdf_per_sr});
  picture->set(name + "_text", fmt::format(", TIS {:.3g}", table.tis));
}

// Sets axes from a tenth of the resolved angle to the angle where all functions are below kDecades.
void set_scatter_axes(const std::vector<const ScatterTable*>& tables, double resolved, Picture* picture) {
  double high = 0, last = 0;
  for (const ScatterTable* table : tables)
    for (Eigen::Index k = 0; k < table->theta.size(); ++k)
      if (table->theta[k] > 0.1 * resolved) high = std::max(high, table->bsdf_per_sr[k]);
  double low = high;
  for (const ScatterTable* table : tables)
    for (Eigen::Index k = 0; k < table->theta.size(); ++k)
      if (table->bsdf_per_sr[k] > high * std::pow(10, -kDecades) && table->theta[k] > 0.1 * resolved) {
        low = std::min(low, table->bsdf_per_sr[k]);
        last = std::max(last, table->theta[k]);
      }
  constexpr double kDegree = std::numbers::pi / 180;
  picture->set("x_axis", log_axis("x", 0.1 * resolved / kDegree, 1.2 * last / kDegree));
  picture->set("y_axis", log_axis("y", 0.5 * low, 2 * high));
}

}  // namespace

std::optional<Picture> specified_psd_picture(const FitPictures& fit) {
  constexpr Eigen::Index kPoints = 400;
  if (!fit.psd) return std::nullopt;
  const double across = 0.5 / aperture_radius(fit.aperture), longest = 1 / fit.wavelength;
  const double low = std::max(fit.psd->f_min(), 0.1 * across), high = std::min(fit.psd->f_max(), longest);
  if (!(high > low)) return std::nullopt;
  PictureColumns curve(2, Eigen::ArrayXd::LinSpaced(kPoints, std::log(low), std::log(high)).exp());
  curve[0][0] = low, curve[0][kPoints - 1] = high;  // inside the band to the last bit
  curve[1] = curve[0].unaryExpr([&](double f) { return (*fit.psd)(f); });
  const double largest = largest_size(curve[1]);
  if (!(largest > 0)) return std::nullopt;
  double smallest = largest;
  for (const double s : curve[1])
    if (s > largest * std::pow(10, -kDecades)) smallest = std::min(smallest, s);
  Picture picture("specified_psd", fit.result.title);
  picture.add_columns("specified_psd.dat",
                      {"Specified two-sided 2-D PSD", "columns: frequency_per_m psd_2d_m4"}, curve);
  const bool has_bins = fit.result.judgement.character && !fit.result.judgement.character->psd.empty();
  if (has_bins) {
    const PictureColumns bins = bins_of(*fit.result.judgement.character);
    picture.add_columns(
        "specified_psd_terms.dat",
        {"PSD of the fitted surface in bins of frequency [1/m], in m^4, and the band of 99 % of "
         "realisations",
         "columns: low edge, high edge, specification, fitted surface, band low, band high"},
        bins);
    smallest = std::min(smallest, bins[3].minCoeff());
  }
  const double cut =
      fit.result.band.shares && fit.result.band.shares->cut > low && fit.result.band.shares->cut < high
          ? fit.result.band.shares->cut
          : 0;
  picture.set("bins", int(has_bins));
  picture.set("cut", cut);
  picture.set("cut_text", display(cut, Dimension::kSpatialFrequency));
  picture.set("across", across);
  picture.set("f_axis", log_axis("x", 1e-3 * std::min(low, 0.7 * across), 1.1e-3 * high));
  picture.set("s_axis", log_axis("y", 1e24 / 5 * smallest, 1e24 * 5 * largest));
  return picture;
}

std::optional<Picture> bsdf_picture(const FitPictures& fit) {
  if (!fit.psd && !fit.result.band.scatter) return std::nullopt;
  Picture picture("bsdf", fit.result.title);
  std::optional<ScatterTable> whole;
  if (fit.psd) {
    try {
      whole = scatter_table(ScatterFunction(*fit.psd, fit.wavelength));
    } catch (const ComputationError&) {  // infinite structure function: only a part scatters
    }
  }
  std::vector<const ScatterTable*> tables;
  if (whole) {
    tables.push_back(&*whole);
    add_scatter("whole", *whole, &picture);
  }
  if (fit.result.band.scatter) {
    tables.push_back(&fit.result.band.scatter->table);
    add_scatter("rest", fit.result.band.scatter->table, &picture);
  }
  const double resolved = 0.5 * fit.wavelength / aperture_radius(fit.aperture);
  if (std::none_of(tables.begin(), tables.end(), [&](const ScatterTable* table) {
        return (table->theta > 0.1 * resolved && table->bsdf_per_sr > 0).any();
      }))
    return std::nullopt;
  set_scatter_axes(tables, resolved, &picture);
  picture.set("has_whole", int(whole.has_value()));
  picture.set("has_rest", int(fit.result.band.scatter.has_value()));
  picture.set("rest_label",
              fit.result.fitted.terms.size() > 0 ? "beside the terms" : "as scatter, without terms");
  return picture;
}

}  // namespace aberfit::internal
