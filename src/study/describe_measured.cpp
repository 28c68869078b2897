#include <fmt/format.h>

#include <cmath>

#include "aberfit/core/text.h"
#include "describe.h"

namespace aberfit::internal {
namespace {

// Describes a choice that may be absent; then the file decides.
void describe_open_choice(Visitor& v, const Field& field, std::string& value,
                          std::vector<std::string> names) {
  names.insert(names.begin(), "auto");
  if (value.empty()) value = "auto";
  v.word(field, value, names);
  if (value == "auto") value.clear();
}

void describe_extent(Visitor& v, const Field& field, Extent& extent) {
  Visitor::WordOrQuantity held = extent.value;
  if (extent.percent) held = fmt::format("{} %", extent.value);
  v.word_or_quantity(field, held, R"([0-9]+(\.[0-9]*)?\s*%)", kLength, Range::positive());
  const auto* text = std::get_if<std::string>(&held);
  extent.percent = text != nullptr;
  extent.value = text ? parse_finite(words(*text, " %").front()).value_or(0) : std::get<double>(held);
  v.check(!extent.percent || (extent.value > 0 && extent.value <= 100), field.key,
          fmt::format("{} %", extent.value), "above 0 %, at most 100 %");
}

struct DescribedShape {
  Visitor& v;
  void operator()(ClearCircle& circle) const {
    describe_extent(v,
                    {"diameter", "length, or percent of the diameter of the circle around all valid points",
                     kRequired, "\"95 %\""},
                    circle.diameter);
  }
  void operator()(ClearAnnulus& annulus) const {
    describe_extent(v,
                    {"diameter", "length, or percent of the diameter of the circle around all valid points",
                     kRequired, "\"95 %\""},
                    annulus.diameter);
    describe_extent(
        v,
        {"inner_diameter", "diameter of the hole: length, or percent of the diameter of that circle",
         kRequired, "\"30 %\""},
        annulus.inner_diameter);
    v.check(annulus.diameter.percent != annulus.inner_diameter.percent ||
                annulus.inner_diameter.value < annulus.diameter.value,
            "inner_diameter", "not less than the outer diameter", "less than the outer diameter");
  }
  void operator()(ClearRectangle& rectangle) const {
    describe_extent(
        v, {"width", "length along x, or percent of the extent of the valid points", kRequired, "\"90 %\""},
        rectangle.width);
    describe_extent(
        v, {"height", "length along y, or percent of the extent of the valid points", kRequired, "\"80 %\""},
        rectangle.height);
  }
  void operator()(ClearInterval& interval) const {
    describe_extent(v, {"length", "length, or percent of the length of the profile", kRequired, "\"90 %\""},
                    interval.length);
  }
};

void describe_clear_aperture(Visitor& v, ClearAperture& aperture) {
  v.kind({"shape", "for maps circle, annulus or rectangle; for profiles interval", kRequired}, aperture.shape,
         {{"circle", ClearCircle{}},
          {"annulus", ClearAnnulus{}},
          {"rectangle", ClearRectangle{}},
          {"interval", ClearInterval{}}});
  std::visit([&](auto& shape) { DescribedShape{v}(shape); }, aperture.shape);
  v.quantities(
      {"centre", "x and y (for an interval only x) from the middle of the valid data [m]; absent: the middle",
       kOptional, "[\"1 mm\", \"0 mm\"]"},
      aperture.centre, kLength, Range::any(), false);
  const std::size_t numbers = std::holds_alternative<ClearInterval>(aperture.shape) ? 1 : 2;
  v.check(aperture.centre.empty() || aperture.centre.size() == numbers, "centre",
          fmt::format("{} numbers", aperture.centre.size()),
          numbers == 1 ? "one length" : "two lengths, x and y");
}

void describe_clear_part(Visitor& v, ClearPart& clear) {
  v.optional_object(
      {"aperture",
       "clear aperture; data outside are left out before anything else; absent: all data are used"},
      clear.aperture, describe_clear_aperture);
  v.text({"mask",
          "for maps: text or FITS map of the same size whose zeros and NaN are left out; relative to the "
          "study file",
          kOptional, "\"mask.csv\""},
         clear.mask, true);
  v.integer({"erode", "number of samples removed along the rim of the valid data and of its holes"},
            clear.erode, 0, 100000);
}

// Describes the name of an image, or its number.
void describe_hdu(Visitor& v, std::string& hdu) {
  Visitor::WordOrQuantity held = hdu;
  v.word_or_quantity({"hdu",
                      "for FITS: name (EXTNAME) or number of the image (0: primary, 1: first extension); "
                      "absent: the only image, or the only one with a unit of heights",
                      kOptional, "\"OPD\""},
                     held, R"(.*[^0-9].*)", kNumber, Range::non_negative());
  if (const auto* number = std::get_if<double>(&held)) {
    v.check(*number == std::floor(*number) && *number < 1e9, "hdu", fmt::format("{}", *number),
            "a name or a whole number");
    hdu = fmt::format("{:.0f}", *number);
  } else {
    hdu = std::get<std::string>(held);
  }
}

void describe_source(Visitor& v, MeasuredFile& m) {
  v.text({"file", "measured profile or map; relative to the study file", kRequired, "\"m3.fits\""}, m.file,
         false);
  v.choice_of({"format", "format of the file; auto: by content"}, m.format, measured_format_names());
  v.integer({"column", "for profiles: number of the scan line, from 1"}, m.column, 1, 100000);
  describe_open_choice(v, {"quantity", "for profiles in columns: kind of values; auto: as the file says"},
                       m.quantity, {"height", "slope"});
  describe_open_choice(v,
                       {"of", "measured quantity; a wavefront is twice the surface; auto: as the file says"},
                       m.of, {"surface", "wavefront"});
  v.text({"x_unit", "unit of the positions, where the file does not say", kOptional, "\"mm\""}, m.x_unit,
         true);
  if (!m.x_unit.empty()) check_unit(v, "x_unit", m.x_unit, kLength);
  v.text({"value_unit",
          "unit of heights or slopes, where the file does not say; heights may be in waves (of wavelength)",
          kOptional, "\"nm\""},
         m.value_unit, true);
  const bool slopes = m.quantity == "slope";
  if (!m.value_unit.empty() && (slopes || !is_waves(m.value_unit)))
    check_unit(v, "value_unit", m.value_unit, slopes ? kAngle : kLength, slopes ? "" : ", waves");
  v.quantity({"pitch",
              "distance between neighbouring points [m]: for maps where the file does not say, for profiles "
              "whose positions are rounded or missing",
              kOptional, "\"0.1 mm\""},
             m.pitch, kLength, Range::positive());
  v.integer(
      {"columns", "for text maps: samples per row, where rows continue over several lines", kOptional, "512"},
      m.columns, 2, 1000000);
  v.word({"first_row", "for text maps and NumPy: position of the file's first row on the surface"},
         m.first_row, {"top", "bottom"});
  v.quantity({"wavelength",
              "wavelength of the instrument [m], for values in waves or radians; absent: as the file says",
              kOptional, "\"632.8 nm\""},
             m.wavelength, kLength, Range{1e-12, 1e-2});
  describe_hdu(v, m.hdu);
  v.integer({"plane", "for FITS and NumPy: plane of a cube, from 1", kOptional, "1"}, m.plane, 1, 1000000000);
  v.quantity({"scale", "factor on the heights, to use a measured shape for another mirror"}, m.scale, kNumber,
             Range::positive());
  v.quantities({"invalid",
                "values that mark a missing sample, in the unit of the file's values (for instrument "
                "formats: [m] of the surface); such samples become holes",
                kOptional, "[0, -9999]"},
               m.invalid, kNumber, Range::any(), false);
  describe_clear_part(v, m.clear);
}

void describe_outliers(Visitor& v, OutlierTreatment& outliers) {
  v.choice_of({"outliers",
               "samples that differ from their surroundings: warn of them, reject them (they become holes), "
               "or keep them without a search"},
              outliers, {"warn", "reject", "keep"});
}

void describe_estimator(Visitor& v, PsdEstimatorOptions& e) {
  v.choice_of({"detrend", "shape that is removed first"}, e.detrend.shape,
              {"none", "polynomial", "ellipse", "zernike"});
  v.integer({"degree", "degree of the polynomial, or highest radial order of the Zernikes"}, e.detrend.degree,
            0, 30);
  v.choice_of({"window", "window against spectral leakage"}, e.window,
              {"none", "hann", "hamming", "blackman-harris", "welch", "tukey"});
  v.integer({"bins_per_decade", "logarithmic bins"}, e.bins_per_decade, 1, 100);
  v.boolean({"find_lines",
             "whether periodic structure (turning marks) is removed from the bins and reported as lines"},
            e.find_lines);
  v.quantity({"confidence", "confidence of the intervals"}, e.confidence, kFraction,
             Range{0.5, 1, true, true});
}

void describe_model_fit(Visitor& v, PsdFitOptions& f) {
  v.choice_of({"family", "model to fit; auto: chosen by the information criterion"}, f.family,
              {"auto", "power-law", "k-correlation", "uniform", "power-law-and-floor",
               "k-correlation-and-floor", "two-k-correlations"});
  v.quantity_or({"f_min", "lower edge of the band to fit and to use [cycles/m]; absent: that of the data",
                 kOptional, "\"20 /m\""},
                f.f_min, 0, kFrequency, Range::positive());
  v.quantity_or({"f_max", "upper edge of the band to fit and to use [cycles/m]; absent: that of the data",
                 kOptional, "\"1 /mm\""},
                f.f_max, 0, kFrequency, Range::positive());
  v.check(f.f_min == 0 || f.f_max == 0 || f.f_min < f.f_max, "f_max", format_quantity(f.f_max, kFrequency),
          "a spatial frequency above f_min");
}

}  // namespace

void check_unit(Visitor& v, const char* key, const std::string& unit, Dimension dimension,
                const std::string& more) {
  if (!v.reading()) return;
  try {
    unit_factor(unit, dimension);
  } catch (const UnitError&) {
    v.check(false, key, '"' + unit + '"', allowed_units(dimension) + more);
  }
}

void describe_measured_psd(Visitor& v, MeasuredPsd& m) {
  describe_source(v, m.source);
  v.list(
      {"further",
       "measurements of the same surface by other instruments; their bands are stitched to this one"},
      m.further.size(), 0, [&](std::size_t count) { m.further.resize(count); },
      [&](Visitor& f, std::size_t i) { describe_source(f, m.further[i]); });
  describe_outliers(v, m.outliers);
  describe_estimator(v, m.estimator);
  describe_model_fit(v, m.fit);
  v.list(
      {"bands", "bands in which RMS height and slope of the bins and of the model are reported"},
      m.bands.size(), 0, [&](std::size_t count) { m.bands.resize(count); },
      [&](Visitor& b, std::size_t i) {
        b.text({"name", "name of the band", kRequired, "\"mid\""}, m.bands[i].name, false);
        b.quantity({"f_min", "lower edge [cycles/m]", kRequired, "\"0.1 /mm\""}, m.bands[i].f_min, kFrequency,
                   Range::positive());
        b.quantity({"f_max", "upper edge [cycles/m]", kRequired, "\"1 /mm\""}, m.bands[i].f_max, kFrequency,
                   Range::positive());
        require_band(b, m.bands[i].f_min, m.bands[i].f_max);
      });
  m.fit.confidence = m.estimator.confidence;
}

void describe_map_target(Visitor& v, MapTarget& target) {
  describe_source(v, target.source);
  v.word({"origin",
          "position of the axis on the map: middle of the smallest circle around the valid points, middle of "
          "the grid, or the file's own origin"},
         target.origin, {"circle", "grid", "file"});
  describe_outliers(v, target.outliers);
  v.quantity({"held_out", "fraction of the valid points kept back for judging"}, target.fit.held_out,
             kFraction, Range{0, 0.9});
  v.seed({"seed", "seed of the choice of these points"}, target.fit.seed);
}

}  // namespace aberfit::internal
