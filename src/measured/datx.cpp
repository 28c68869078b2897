// Zygo Mx .datx, an HDF5 file with unpublished layout. This reader follows what prysm (prysm/io.py),
// SurfaceTopography (IO/DATX.py and its tests, after Gwyddion) and Superflat of LEAPS (ZygoDatx.py) agree on.
#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "hdf5_file.h"
#include "hdf5_values.h"
#include "map_reading.h"

namespace aberfit {
using namespace internal;

namespace {

// Opens the data set of the heights: the single one in /Data/Surface, or /Measurement/Surface.
Hdf5Id surface_data(const Hdf5File& file) {
  if (!file.has(file.root(), "Data") && file.has(file.root(), "Measurement"))
    return file.data_set(file.group(file.root(), "Measurement", "/Measurement"), "Surface",
                         "/Measurement/Surface");
  if (!file.has(file.root(), "Data")) file.refuse_layout();
  const Hdf5Id data = file.group(file.root(), "Data", "/Data");
  const std::string place = "/Data/Surface";
  const Hdf5Id surfaces = file.group(data, "Surface", place);
  if (const std::size_t count = file.count(surfaces); count != 1)
    throw InputError(file.path(), place, fmt::format("{} surfaces", count), "one surface");
  return file.data_set(surfaces, file.names(surfaces, 1).front(), place);
}

// An X, Y or Z Converter, which maps indices or values to lengths.
struct DatxConverter {
  std::string category, unit;
  std::vector<double> parameters;
};

class DatxAttributes {
 public:
  DatxAttributes(const Hdf5File& file, const Hdf5Id& object)
      : file_(file.bytes()), path_(file.path()), values_(file.attributes(object)) {}

  std::optional<double> number(const std::string& name) const {
    const auto found = values_.find(name);
    if (found == values_.end()) return std::nullopt;
    return known(name, hdf5_number(file_, found->second), "a number");
  }
  std::optional<std::string> text(const std::string& name) const {
    const auto found = values_.find(name);
    if (found == values_.end()) return std::nullopt;
    return text_of(name, found->second);
  }
  std::optional<DatxConverter> converter(const std::string& name) const {
    const auto found = values_.find(name);
    if (found == values_.end()) return std::nullopt;
    const auto member = [&](const char* key) {
      return known(name, hdf5_member(file_, found->second, key), key);
    };
    return DatxConverter{text_of(name, member("Category")), text_of(name, member("BaseUnit")),
                         known(name, hdf5_numbers(file_, member("Parameters")), "a sequence of numbers")};
  }

 private:
  template <class Value>
  Value known(const std::string& name, std::optional<Value> value, const char* wanted) const {
    if (!value) throw InputError(path_, fmt::format("attribute '{}'", name), "another type", wanted);
    return *std::move(value);
  }
  std::string text_of(const std::string& name, const Hdf5Value& value) const {
    return one_line(known(name, hdf5_text(file_, value), "a text"), 80);
  }

  const FileBytes& file_;
  const std::string& path_;
  std::map<std::string, Hdf5Value> values_;
};

// Returns the attribute, otherwise the parameter of the Z Converter. If both exist they must agree.
double datx_factor(const std::string& path, const DatxAttributes& attributes, const std::string& name,
                   const DatxConverter& z, std::size_t parameter, double least, double most) {
  const std::optional<double> said = attributes.number(name);
  const std::optional<double> beside =
      z.parameters.size() > parameter ? std::optional(z.parameters[parameter]) : std::nullopt;
  const std::optional<double> value = said ? said : beside;
  if (!value || !(std::abs(*value) >= least && std::abs(*value) <= most))
    throw InputError(path, fmt::format("attribute '{}'", name), value ? fmt::format("{}", *value) : "nothing",
                     fmt::format("{:g} to {:g}", least, most));
  if (said && beside && !(std::abs(*beside / *said - 1) <= kSameUnit))
    throw InputError(path, fmt::format("attribute '{}'", name), fmt::format("{}", *said),
                     fmt::format("{}, as the attribute 'Z Converter' says", *beside));
  return *value;
}

// Returns the wavelength [m] from the file, otherwise from the option.
double datx_wavelength(const MeasuredSource& source, const DatxAttributes& attributes,
                       const DatxConverter& z) {
  constexpr const char* kName = "Wavelength";
  constexpr std::size_t kParameter = 1;
  const bool said = attributes.number(kName) || z.parameters.size() > kParameter;
  if (!said && !source.wavelength)
    throw MissingFact("wavelength", source.path, "attribute 'Wavelength'", "nothing",
                      "a length, or option 'wavelength'");
  return *agreed_length(
      source.path, "wavelength", source.wavelength,
      said ? std::optional(datx_factor(source.path, attributes, kName, z, kParameter, 1e-9, 1e-3))
           : std::nullopt,
      kSameWavelength);
}

// Returns the surface height [m] of one unit of the data.
double datx_metres(const MeasuredSource& source, const DatxAttributes& attributes) {
  const DatxConverter z = attributes.converter("Z Converter").value_or(DatxConverter());
  const std::string unit = attributes.text("Unit").value_or(z.unit);
  if (!z.unit.empty() && lower_case(z.unit) != lower_case(unit))
    throw InputError(source.path, "attribute 'Unit'", in_quotes(unit),
                     "that of 'Z Converter', " + in_quotes(z.unit));
  if (lower_case(unit) == "fringes") {
    if (source.value_factor || source.value_in_waves)
      refuse_option(source.path, "value_unit", source.value_in_waves ? "waves" : "a length", in_quotes(unit));
    // The scale factor is in waves of surface height per fringe, so the result is the surface.
    return datx_wavelength(source, attributes, z) *
           datx_factor(source.path, attributes, "Interferometric Scale Factor", z, 2, 1e-6, 1e6) *
           datx_factor(source.path, attributes, "Obliquity Factor", z, 3, 1e-6, 1e6);
  }
  const std::optional<double> metres = metres_per_unit(unit);
  if (metres) return agreed_value_factor(source, *metres, unit);
  constexpr const char *kPlace = "attribute 'Unit'",
                       *kAllowed =
                           "Fringes, NanoMeters, MicroMeters, MilliMeters or Meters, or option 'value_unit'";
  if (!unit.empty() && !source.value_factor && !source.value_in_waves)
    throw InputError(source.path, kPlace, in_quotes(unit), kAllowed);
  return given_value_factor(source, kPlace, "nothing", kAllowed);
}

double datx_pitch(const MeasuredSource& source, const DatxAttributes& attributes, const std::string& name) {
  const std::optional<DatxConverter> converter = attributes.converter(name);
  if (!converter) return agreed_pitch(source, 0);
  if (converter->category != "LateralCat" || converter->unit != "Pixels" || converter->parameters.size() < 2)
    throw InputError(source.path, fmt::format("attribute '{}'", name),
                     fmt::format("{} of {} with {} parameters", in_quotes(converter->category),
                                 in_quotes(converter->unit), converter->parameters.size()),
                     "LateralCat of Pixels with two parameters or more, the second the pitch [m]");
  return agreed_pitch(source, converter->parameters[1]);
}

}  // namespace

HeightMap read_datx(const MeasuredSource& source) {
  require_sane_options(source);
  const std::string& path = source.path;
  const Hdf5File file(path);
  const Hdf5Id data = surface_data(file);
  const Grid values = file.matrix(data, "surface");
  const DatxAttributes attributes(file, data);
  agreed_wavefront(path, source.wavefront, false);
  const double factor = datx_metres(source, attributes);
  const std::optional<double> no_data = attributes.number("No Data");
  if (!no_data) throw InputError(path, "attribute 'No Data'", "nothing", "the number that means no data");
  const Eigen::Index rows = values.rows(), columns = values.cols();
  HeightMap map = empty_map(rows, columns, datx_pitch(source, attributes, "X Converter"),
                            datx_pitch(source, attributes, "Y Converter"));
  for (Eigen::Index row = 0; row < rows; ++row)
    for (Eigen::Index column = 0; column < columns; ++column) {
      const double value = values(row, column);
      // The file starts with the top row.
      if (std::isfinite(value) && !(value >= *no_data)) map.height(rows - 1 - row, column) = factor * value;
    }
  return map;
}

}  // namespace aberfit
