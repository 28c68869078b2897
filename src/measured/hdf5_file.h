#pragma once
#define H5_USE_18_API  // this API has addresses of links and objects; that of 1.12 has tokens
#include <hdf5.h>

#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "aberfit/measured/height_map.h"
#include "hdf5_values.h"
#include "map_reading.h"

// HDF5 files in memory, checked before the library reads them. The library trusts the sizes of nodes, headers
// and attributes, and would follow links into other files.

namespace aberfit::internal {

/// Locks HDF5, which is not thread-safe, silences its messages, and disables its exit handler, which would
/// report errors for damaged files at program end. All open objects must be closed while this one exists.
class QuietHdf5 {
 public:
  QuietHdf5();
  ~QuietHdf5();
  QuietHdf5(const QuietHdf5&) = delete;
  QuietHdf5& operator=(const QuietHdf5&) = delete;

 private:
  std::lock_guard<std::mutex> lock_;
  H5E_auto2_t print_ = nullptr;
  void* data_ = nullptr;
};

/// An object of the library, closed by the destructor.
class Hdf5Id {
 public:
  using Close = herr_t (*)(hid_t);
  Hdf5Id(const std::string& path, const std::string& place, hid_t id, Close close) : id_(id), close_(close) {
    if (id < 0) throw InputError(path, place, "damage, so HDF5 cannot read it", "an undamaged HDF5 file");
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

/// A file and its parts. `place` names an object in messages, for example "/Data/Surface". All functions
/// throw InputError for damage and for data in other files. Only one such object may exist at a time.
class Hdf5File {
 public:
  explicit Hdf5File(const std::string& path);
  Hdf5File(const Hdf5File&) = delete;
  Hdf5File& operator=(const Hdf5File&) = delete;

  const std::string& path() const { return path_; }
  const FileBytes& bytes() const { return file_bytes_; }
  const Hdf5Id& root() const { return root_; }

  /// Returns true for a member in this file, false for a link to another file.
  bool has(const Hdf5Id& group, const std::string& name) const;
  /// Returns the names of its members in alphabetical order, at most `most`.
  std::vector<std::string> names(const Hdf5Id& group, std::size_t most) const;
  std::size_t count(const Hdf5Id& group) const;
  Hdf5Id group(const Hdf5Id& parent, const std::string& name, const std::string& place) const;
  Hdf5Id data_set(const Hdf5Id& parent, const std::string& name, const std::string& place) const;
  /// See hdf5_attributes.
  std::map<std::string, Hdf5Value> attributes(const Hdf5Id& object) const;
  /// Returns the numbers of a two-dimensional data set, row 0 first, limited by the size of the file.
  Grid matrix(const Hdf5Id& data, const std::string& place) const;

  /// Throws InputError for an unknown layout; the message lists the top level of the file.
  [[noreturn]] void refuse_layout() const;

 private:
  Hdf5Id member(const Hdf5Id& parent, const std::string& name, const std::string& place, H5I_type_t kind,
                const char* allowed) const;

  std::string path_, contents_;
  FileBytes file_bytes_;
  QuietHdf5 quiet_;
  Hdf5Id root_;
};

}  // namespace aberfit::internal
