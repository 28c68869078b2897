// HDF5 files of 4D Technology's interferometers: data in /measurement0/genraw/data with attributes (4Sight),
// or in /Measurement/SurfaceInWaves/Data (4Sight Focus). The layouts are not published. This reader follows
// what readers of observatories agree on (opticalib of INAF, catkit of STScI, FizCam scripts): values in
// waves, top row first, no data as a huge number, attributes such as wavelength = "632.8 nm" and xpix = "0.1
// mm".
// An instrument setting outside the file determines whether values are surface or wavefront, so the option
// must state it.
#include <cmath>
#include <map>
#include <optional>
#include <string>

#include "aberfit/core/units.h"
#include "hdf5_file.h"
#include "map_reading.h"

namespace aberfit {
using namespace internal;

namespace {

// Returns an attribute that is a length with its unit; nothing if it is missing, zero or has no unit.
std::optional<double> length_attribute(const Hdf5File& file, const std::map<std::string, Hdf5Value>& values,
                                       const std::string& name) {
  const auto found = values.find(name);
  const auto text = found == values.end() ? std::nullopt : hdf5_text(file.bytes(), found->second);
  if (!text) return std::nullopt;
  // parse_quantity would read a plain number as metres.
  if (parse_finite(trimmed(*text))) return std::nullopt;
  try {
    const double length = parse_quantity(one_line(*text, 80), Dimension::kLength);
    return length > 0 ? std::optional(length) : std::nullopt;
  } catch (const UnitError&) {  // a unit such as "1 pix": not calibrated
    return std::nullopt;
  }
}

struct FourDPlace {
  const char *top, *group, *data;
};
constexpr FourDPlace kPlaces[] = {{"measurement0", "genraw", "data"},
                                  {"Measurement", "SurfaceInWaves", "Data"}};

}  // namespace

HeightMap read_4d(const MeasuredSource& source) {
  require_sane_options(source);
  const Hdf5File file(source.path);
  const FourDPlace* place = nullptr;
  for (const FourDPlace& one : kPlaces)
    if (!place && file.has(file.root(), one.top)) place = &one;
  if (!place) file.refuse_layout();
  const std::string top = std::string("/") + place->top, inner = top + "/" + place->group;
  const Hdf5Id group = file.group(file.group(file.root(), place->top, top), place->group, inner);
  const std::map<std::string, Hdf5Value> attributes = file.attributes(group);
  const Hdf5Id data = file.data_set(group, place->data, inner + "/" + place->data);

  if (!source.wavefront)
    throw MissingFact(
        "of", source.path, "option 'of'", "nothing",
        "surface or wavefront, as the instrument was set (in 4Sight the wedge factor is 0.5 for a surface)");
  if (source.value_factor) refuse_option(source.path, "value_unit", "a length", "waves");
  const std::optional<double> wavelength =
      agreed_length(source.path, "wavelength", source.wavelength,
                    length_attribute(file, attributes, "wavelength"), kSameWavelength);
  if (!wavelength)
    throw MissingFact("wavelength", source.path, inner + ", attribute 'wavelength'", "no length",
                      "a length, or option 'wavelength'");
  const double factor = surface_per_height(*source.wavefront) * *wavelength;
  const double pitch = agreed_pitch(source, length_attribute(file, attributes, "xpix").value_or(0));
  const Grid values = file.matrix(data, inner + "/" + place->data);
  HeightMap map = empty_map(values.rows(), values.cols(), pitch, pitch);
  map.file_unit = factor;
  // 1e10 waves are kilometres. Such values, for example the largest float, mark missing data.
  constexpr double kNoData = 1e10;
  for (Eigen::Index row = 0; row < values.rows(); ++row)
    for (Eigen::Index column = 0; column < values.cols(); ++column)
      if (const double value = values(row, column); std::abs(value) < kNoData)
        map.height(values.rows() - 1 - row, column) = factor * value;
  return map;
}

}  // namespace aberfit
