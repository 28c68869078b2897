// Zygo Mx .datx, an HDF5 file. The layout is not published; this is what prysm (prysm/io.py),
// SurfaceTopography (IO/DATX.py and its tests, which follow Gwyddion) and the Superflat scripts of LEAPS
// (ZygoDatx.py) agree on.
#include <fmt/format.h>
#define H5_USE_18_API  // links and objects have addresses; from 1.12 on tokens
#include <hdf5.h>

#include <cmath>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "hdf5_values.h"
#include "map_reading.h"

namespace aberfit {
using namespace internal;

namespace {

// HDF5 is not made for several threads, and prints its errors unless it is told not to; also at the end of
// the program, where it finds that it lost count of its objects in damaged files, unless it is told before
// its first use to leave its end out. All that is opened here is closed here.
class QuietHdf5 {
 public:
  QuietHdf5() : lock_(mutex()) {
    H5Eget_auto2(H5E_DEFAULT, &print_, &data_);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  }
  ~QuietHdf5() { H5Eset_auto2(H5E_DEFAULT, print_, data_); }
  QuietHdf5(const QuietHdf5&) = delete;
  QuietHdf5& operator=(const QuietHdf5&) = delete;

 private:
  static std::mutex& mutex() {
    static std::mutex one;
    [[maybe_unused]] static const herr_t said = H5dont_atexit();
    return one;
  }

  std::lock_guard<std::mutex> lock_;
  H5E_auto2_t print_ = nullptr;
  void* data_ = nullptr;
};

// An object of the library, closed with this.
class Hdf5Id {
 public:
  using Close = herr_t (*)(hid_t);
  Hdf5Id(const std::string& path, const std::string& place, hid_t id, Close close) : id_(id), close_(close) {
    if (id < 0) throw InputError(path, place, "damage, HDF5 cannot read it", "a .datx, an HDF5 file");
  }
  Hdf5Id(Hdf5Id&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Hdf5Id& operator=(Hdf5Id&&) = delete;
  ~Hdf5Id() {
    if (id_ >= 0) close_(id_);
  }
  hid_t get() const { return id_; }

 private:
  hid_t id_;
  Close close_;
};

// What the begin of the file says of all of it, and the headers that it leads to, which the library reads as
// it opens the file. It takes sizes of nodes and headers unlooked.
void require_superblock(const FileBytes& file) {
  constexpr std::uint64_t kNowhere = ~std::uint64_t(0);
  if (file.text(0, 8) != "\x89HDF\r\n\x1a\n")
    file.fail(0, "other bytes", "the signature of HDF5, as a .datx has it");
  const unsigned version = file.at<std::uint8_t>(8);
  if (version > 3) file.fail(8, fmt::format("version {}", version), "0 to 3");
  const bool first = version < 2;
  const std::uint64_t widths = first ? 13 : 9, base = version == 0 ? 24 : version == 1 ? 28 : 12;
  for (const std::uint64_t place : {widths, widths + 1})
    if (file.at<std::uint8_t>(place) != 8)
      file.fail(place, "another width of addresses or lengths", "8 bytes");
  if (file.at<std::uint64_t>(base) != 0) file.fail(base, "another base of addresses", "0");
  const std::uint64_t end = file.at<std::uint64_t>(base + 16);
  if (end > file.size())
    file.fail(base + 16, fmt::format("an end of the file at {}", end), fmt::format("{}", file.size()));
  const std::uint64_t root = file.at<std::uint64_t>(base + (first ? 40 : 24));
  if (!first) {
    const std::uint64_t extension = file.at<std::uint64_t>(base + 8);
    if (extension != kNowhere) require_hdf5_group(file, extension);
    require_hdf5_group(file, root);
    return;
  }
  constexpr unsigned kLargest = 1024;  // 4 and 16 unless somebody wants others
  for (const std::uint64_t place : {16, 18})
    if (const unsigned k = file.at<std::uint16_t>(place); k < 1 || k > kLargest)
      file.fail(place, fmt::format("nodes of order {}", k), fmt::format("1 to {}", kLargest));
  if (file.at<std::uint64_t>(base + 24) != kNowhere)
    file.fail(base + 24, "a file of several parts", "one file");
  require_hdf5_group(file, root);
}

// The file as the library sees it: bytes in memory, so that it opens no other one.
Hdf5Id open_image(const std::string& path, std::string& bytes) {
  const Hdf5Id access(path, "", H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_fapl_core(access.get(), 1 << 16, false);
  H5Pset_fclose_degree(access.get(), H5F_CLOSE_STRONG);
  H5Pset_file_image(access.get(), bytes.data(), bytes.size());
  // The library looks for a file of that name first; below a regular file there is none.
  const std::string name = path + "/image";
  return Hdf5Id(path, "", H5Fopen(name.c_str(), H5F_ACC_RDONLY, access.get()), H5Fclose);
}

// Where the object header begins.
std::uint64_t address_of(const Hdf5Id& object) {
  H5O_info_t info{};
  return H5Oget_info_by_name2(object.get(), ".", &info, H5O_INFO_BASIC, H5P_DEFAULT) < 0 ? HADDR_UNDEF
                                                                                         : info.addr;
}

// Where the header of a member of the file itself begins; nothing for links to other files, which are not
// followed. The link alone is read: the library asks for as much memory as a header claims, unlooked.
std::optional<std::uint64_t> member_address(const Hdf5Id& group, const std::string& name) {
  H5L_info_t link{};
  if (H5Lexists(group.get(), name.c_str(), H5P_DEFAULT) <= 0 ||
      H5Lget_info(group.get(), name.c_str(), &link, H5P_DEFAULT) < 0 || link.type != H5L_TYPE_HARD)
    return std::nullopt;
  return link.u.address;
}

Hdf5Id open_member(const FileBytes& bytes, const std::string& path, const Hdf5Id& group,
                   const std::string& name, const std::string& place) {
  const std::optional<std::uint64_t> header = member_address(group, name);
  if (!header)
    throw InputError(path, place,
                     H5Lexists(group.get(), name.c_str(), H5P_DEFAULT) > 0 ? "a link" : "nothing",
                     "a member of the file itself, as Zygo Mx writes it");
  if (hdf5_data_outside(bytes, *header))
    throw InputError(path, place, "data that lie in other files", "data in the file itself");
  return Hdf5Id(path, place, H5Oopen(group.get(), name.c_str(), H5P_DEFAULT), H5Oclose);
}

Hdf5Id open_kind(H5I_type_t kind, const FileBytes& bytes, const std::string& path, const Hdf5Id& group,
                 const std::string& name, const std::string& place) {
  Hdf5Id object = open_member(bytes, path, group, name, place);
  if (H5Iget_type(object.get()) != kind)
    throw InputError(path, place, "an object of another kind", kind == H5I_GROUP ? "a group" : "a data set");
  return object;
}

Hdf5Id open_group(const FileBytes& bytes, const std::string& path, const Hdf5Id& group,
                  const std::string& name, const std::string& place) {
  Hdf5Id object = open_kind(H5I_GROUP, bytes, path, group, name, place);
  require_hdf5_group(bytes, address_of(object));
  return object;
}

// The data set of the heights: the one in /Data/Surface, in other files /Measurement/Surface.
Hdf5Id surface_data(const FileBytes& bytes, const std::string& path, const Hdf5Id& file) {
  if (!member_address(file, "Data") && member_address(file, "Measurement")) {
    const Hdf5Id group = open_group(bytes, path, file, "Measurement", "/Measurement");
    return open_kind(H5I_DATASET, bytes, path, group, "Surface", "/Measurement/Surface");
  }
  const Hdf5Id data = open_group(bytes, path, file, "Data", "/Data");
  const std::string place = "/Data/Surface";
  const Hdf5Id surfaces = open_group(bytes, path, data, "Surface", place);
  H5G_info_t about{};
  if (H5Gget_info(surfaces.get(), &about) < 0 || about.nlinks != 1)
    throw InputError(path, place, fmt::format("{} surfaces", about.nlinks), "one surface");
  char name[256] = "";
  H5Lget_name_by_idx(surfaces.get(), ".", H5_INDEX_NAME, H5_ITER_INC, 0, name, sizeof name, H5P_DEFAULT);
  return open_kind(H5I_DATASET, bytes, path, surfaces, name, place);
}

// X, Y and Z Converter: how indices and values become lengths.
struct DatxConverter {
  std::string category, unit;
  std::vector<double> parameters;
};

// What the attributes of the data set say; nothing where there is no such attribute.
class DatxAttributes {
 public:
  DatxAttributes(const FileBytes& file, const std::string& path, const Hdf5Id& object)
      : file_(file), path_(path), values_(hdf5_attributes(file, address_of(object))) {}

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

// The attribute where it is there, else the parameter of the Z Converter; both have to say the same.
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

// Where the file does not say it, the option's.
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

// [m] of the surface in one unit of the data.
double datx_metres(const MeasuredSource& source, const DatxAttributes& attributes) {
  const DatxConverter z = attributes.converter("Z Converter").value_or(DatxConverter());
  const std::string unit = attributes.text("Unit").value_or(z.unit);
  if (!z.unit.empty() && lower_case(z.unit) != lower_case(unit))
    throw InputError(source.path, "attribute 'Unit'", in_quotes(unit),
                     "that of 'Z Converter', " + in_quotes(z.unit));
  if (lower_case(unit) == "fringes") {
    if (source.value_factor || source.value_in_waves)
      refuse_option(source.path, "value_unit", source.value_in_waves ? "waves" : "a length", in_quotes(unit));
    // The scale factor, waves of the surface in a fringe, makes it a surface already.
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

// Refuses data that are not in the file itself, that need a plug-in, or that take more memory than the file
// can hold.
void require_bounded(const std::string& path, std::uint64_t file_bytes, const Hdf5Id& data,
                     std::uint64_t points) {
  const std::string place = "surface";
  const Hdf5Id type(path, place, H5Dget_type(data.get()), H5Tclose);
  const H5T_class_t kind = H5Tget_class(type.get());
  const std::uint64_t width = H5Tget_size(type.get());
  if ((kind != H5T_FLOAT && kind != H5T_INTEGER) || width > 8)
    throw InputError(path, place, "data of another type", "numbers of up to 8 bytes");
  const Hdf5Id creation(path, place, H5Dget_create_plist(data.get()), H5Pclose);
  const H5D_layout_t layout = H5Pget_layout(creation.get());
  if (layout != H5D_COMPACT && layout != H5D_CONTIGUOUS && layout != H5D_CHUNKED)
    throw InputError(path, place, "data that lie in other files", "data in the file itself");
  bool packed = false;
  const int filters = H5Pget_nfilters(creation.get());
  for (int i = 0; i < filters; ++i) {
    unsigned flags = 0, config = 0;
    std::size_t values = 0;
    const H5Z_filter_t filter =
        H5Pget_filter2(creation.get(), unsigned(i), &flags, &values, nullptr, 0, nullptr, &config);
    if (filter < H5Z_FILTER_DEFLATE || filter > H5Z_FILTER_SCALEOFFSET)
      throw InputError(path, place, fmt::format("filter {}", filter), "filters that HDF5 has itself");
    packed = packed || (filter != H5Z_FILTER_SHUFFLE && filter != H5Z_FILTER_FLETCHER32);
  }
  const std::uint64_t most = packed ? file_bytes * kMostByDeflate : file_bytes;
  std::uint64_t needed = points * width;
  if (layout == H5D_CHUNKED) {
    hsize_t chunk[2] = {0, 0};
    if (H5Pget_chunk(creation.get(), 2, chunk) != 2 || chunk[0] > kMostMapPoints || chunk[1] > kMostMapPoints)
      throw InputError(path, place, "chunks of no map", "chunks of rows and columns");
    needed = std::max<std::uint64_t>(needed, chunk[0] * chunk[1] * width);
  }
  if (needed > most || H5Dget_storage_size(data.get()) == 0)
    throw InputError(path, place, fmt::format("{} bytes in a file of {}", needed, file_bytes),
                     fmt::format("1 to {} bytes", most));
}

}  // namespace

HeightMap read_datx(const MeasuredSource& source) {
  require_sane_options(source);
  const std::string& path = source.path;
  std::string bytes = read_map_bytes(path);
  const FileBytes file_bytes(path, bytes, std::endian::little);
  require_superblock(file_bytes);
  const QuietHdf5 quiet;
  const Hdf5Id file = open_image(path, bytes);
  const Hdf5Id data = surface_data(file_bytes, path, file);
  const Hdf5Id space(path, "surface", H5Dget_space(data.get()), H5Sclose);
  hsize_t size[2] = {0, 0};
  if (H5Sget_simple_extent_ndims(space.get()) != 2 ||
      H5Sget_simple_extent_dims(space.get(), size, nullptr) != 2)
    throw InputError(path, "surface", "data that are no matrix", "rows and columns");
  const auto count = [](hsize_t n) { return std::int64_t(std::min<hsize_t>(n, 2 * kMostMapPoints)); };
  const std::int64_t rows = count(size[0]), columns = count(size[1]);
  require_map_size(path, "surface", columns, rows);
  require_bounded(path, bytes.size(), data, std::uint64_t(rows * columns));

  const DatxAttributes attributes(file_bytes, path, data);
  agreed_wavefront(path, source.wavefront, false);
  const double factor = datx_metres(source, attributes);
  const std::optional<double> no_data = attributes.number("No Data");
  if (!no_data) throw InputError(path, "attribute 'No Data'", "nothing", "the number that means no data");
  HeightMap map = empty_map(rows, columns, datx_pitch(source, attributes, "X Converter"),
                            datx_pitch(source, attributes, "Y Converter"));
  Grid values(rows, columns);
  if (H5Dread(data.get(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) < 0)
    throw InputError(path, "surface", "data that HDF5 cannot read", "an undamaged file");
  for (Eigen::Index row = 0; row < rows; ++row)
    for (Eigen::Index column = 0; column < columns; ++column) {
      const double value = values(row, column);
      // The top row comes first.
      if (std::isfinite(value) && !(value >= *no_data)) map.height(rows - 1 - row, column) = factor * value;
    }
  return map;
}

}  // namespace aberfit
