#include "hdf5_file.h"

#include <fmt/format.h>

#include <algorithm>

#include "is_4d_hdf5.h"

namespace aberfit::internal {
namespace {

std::mutex& hdf5_mutex() {
  static std::mutex one;
  [[maybe_unused]] static const herr_t said = H5dont_atexit();
  return one;
}

// Checks the superblock and the headers that the library reads on opening without a check of their sizes.
void require_superblock(const FileBytes& file) {
  constexpr std::uint64_t kNowhere = ~std::uint64_t(0);
  if (file.text(0, 8) != "\x89HDF\r\n\x1a\n") file.fail(0, "other bytes", "the signature of HDF5");
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
  constexpr unsigned kLargest = 1024;  // the defaults are 4 and 16
  for (const std::uint64_t place : {16, 18})
    if (const unsigned k = file.at<std::uint16_t>(place); k < 1 || k > kLargest)
      file.fail(place, fmt::format("nodes of order {}", k), fmt::format("1 to {}", kLargest));
  if (file.at<std::uint64_t>(base + 24) != kNowhere)
    file.fail(base + 24, "a file in several parts", "one file");
  require_hdf5_group(file, root);
}

// Opens the file from memory, so that the library opens no other file.
Hdf5Id open_image(const std::string& path, std::string& bytes) {
  const Hdf5Id access(path, "", H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_fapl_core(access.get(), 1 << 16, false);
  H5Pset_fclose_degree(access.get(), H5F_CLOSE_STRONG);
  H5Pset_file_image(access.get(), bytes.data(), bytes.size());
  // The library first looks for a file of this name. Below a regular file there is none.
  const std::string name = path + "/image";
  return Hdf5Id(path, "", H5Fopen(name.c_str(), H5F_ACC_RDONLY, access.get()), H5Fclose);
}

std::uint64_t address_of(const Hdf5Id& object) {
  H5O_info_t info{};
  return H5Oget_info_by_name2(object.get(), ".", &info, H5O_INFO_BASIC, H5P_DEFAULT) < 0 ? HADDR_UNDEF
                                                                                         : info.addr;
}

// Returns the header address of a member in this file; nothing for a link to another file. Only the link is
// read, because the library allocates whatever a header claims.
std::optional<std::uint64_t> member_address(const Hdf5Id& group, const std::string& name) {
  H5L_info_t link{};
  if (H5Lexists(group.get(), name.c_str(), H5P_DEFAULT) <= 0 ||
      H5Lget_info(group.get(), name.c_str(), &link, H5P_DEFAULT) < 0 || link.type != H5L_TYPE_HARD)
    return std::nullopt;
  return link.u.address;
}

// Throws InputError for data in other files, data that need a plug-in, or data larger than the file can hold.
void require_bounded(const std::string& path, const std::string& place, std::uint64_t file_bytes,
                     const Hdf5Id& data, std::uint64_t points) {
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

// Returns the bytes after checking what the library reads on opening.
const FileBytes& checked(const FileBytes& bytes) {
  require_superblock(bytes);
  return bytes;
}

}  // namespace

QuietHdf5::QuietHdf5() : lock_(hdf5_mutex()) {
  H5Eget_auto2(H5E_DEFAULT, &print_, &data_);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}
QuietHdf5::~QuietHdf5() { H5Eset_auto2(H5E_DEFAULT, print_, data_); }

Hdf5File::Hdf5File(const std::string& path)
    : path_(path),
      contents_(read_map_bytes(path)),
      file_bytes_(checked(FileBytes(path_, contents_, std::endian::little))),
      root_(open_image(path_, contents_)) {}

bool Hdf5File::has(const Hdf5Id& group, const std::string& name) const {
  return member_address(group, name).has_value();
}

std::size_t Hdf5File::count(const Hdf5Id& group) const {
  H5G_info_t about{};
  return H5Gget_info(group.get(), &about) < 0 ? 0 : std::size_t(about.nlinks);
}

std::vector<std::string> Hdf5File::names(const Hdf5Id& group, std::size_t most) const {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < std::min(count(group), most); ++i) {
    char name[256] = "";
    H5Lget_name_by_idx(group.get(), ".", H5_INDEX_NAME, H5_ITER_INC, i, name, sizeof name, H5P_DEFAULT);
    names.emplace_back(name);
  }
  return names;
}

Hdf5Id Hdf5File::member(const Hdf5Id& parent, const std::string& name, const std::string& place,
                        H5I_type_t kind, const char* allowed) const {
  const std::optional<std::uint64_t> header = member_address(parent, name);
  if (!header)
    throw InputError(path_, place,
                     H5Lexists(parent.get(), name.c_str(), H5P_DEFAULT) > 0 ? "a link" : "nothing",
                     fmt::format("{} of the file itself, as the instrument writes it", allowed));
  if (hdf5_data_outside(file_bytes_, *header))
    throw InputError(path_, place, "data that lie in other files", "data in the file itself");
  Hdf5Id object(path_, place, H5Oopen(parent.get(), name.c_str(), H5P_DEFAULT), H5Oclose);
  if (H5Iget_type(object.get()) != kind) throw InputError(path_, place, "an object of another kind", allowed);
  return object;
}

Hdf5Id Hdf5File::group(const Hdf5Id& parent, const std::string& name, const std::string& place) const {
  Hdf5Id object = member(parent, name, place, H5I_GROUP, "a group");
  require_hdf5_group(file_bytes_, address_of(object));
  return object;
}

Hdf5Id Hdf5File::data_set(const Hdf5Id& parent, const std::string& name, const std::string& place) const {
  return member(parent, name, place, H5I_DATASET, "a data set");
}

std::map<std::string, Hdf5Value> Hdf5File::attributes(const Hdf5Id& object) const {
  return hdf5_attributes(file_bytes_, address_of(object));
}

Grid Hdf5File::matrix(const Hdf5Id& data, const std::string& place) const {
  const Hdf5Id space(path_, place, H5Dget_space(data.get()), H5Sclose);
  hsize_t size[2] = {0, 0};
  if (H5Sget_simple_extent_ndims(space.get()) != 2 ||
      H5Sget_simple_extent_dims(space.get(), size, nullptr) != 2)
    throw InputError(path_, place, "data that are not a matrix", "rows and columns");
  const auto count = [](hsize_t n) { return std::int64_t(std::min<hsize_t>(n, 2 * kMostMapPoints)); };
  const std::int64_t rows = count(size[0]), columns = count(size[1]);
  require_map_size(path_, place, columns, rows);
  require_bounded(path_, place, contents_.size(), data, std::uint64_t(rows * columns));
  Grid values(rows, columns);
  if (H5Dread(data.get(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) < 0)
    throw InputError(path_, place, "data that HDF5 cannot read", "an undamaged file");
  return values;
}

void Hdf5File::refuse_layout() const {
  constexpr std::size_t kMostNamed = 6;
  std::string held;
  for (const std::string& name : names(root_, kMostNamed))
    held += (held.empty() ? "" : ", ") + one_line(name, 60);
  if (count(root_) > kMostNamed) held += fmt::format(" and {} more", count(root_) - kMostNamed);
  throw InputError(
      path_, "",
      fmt::format("an HDF5 file, not of Zygo Mx or 4D: its top level holds {}",
                  held.empty() ? "nothing" : held),
      "/Data/Surface of Zygo Mx or /measurement0/genraw of 4D; or save the map as text or as .npy of NumPy");
}

bool is_4d_hdf5(const std::string& path) {
  try {
    const Hdf5File file(path);
    if (file.has(file.root(), "measurement0")) return true;
    if (!file.has(file.root(), "Measurement")) return false;
    return file.has(file.group(file.root(), "Measurement", "/Measurement"), "SurfaceInWaves");
  } catch (const InputError&) {  // the reader of the format reports what is wrong
    return false;
  }
}

}  // namespace aberfit::internal
