#pragma once
#define H5_USE_18_API  // links and objects have addresses; from 1.12 on tokens
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

// HDF5 files in memory, looked at before the library does: it takes sizes of nodes, headers and attributes
// unlooked, and would follow links into other files.

namespace aberfit::internal {

/// HDF5 is not made for several threads, and prints its errors unless it is told not to; also at the end of
/// the program, where it finds that it lost count of its objects in damaged files, unless it is told before
/// its first use to leave its end out. All that is opened is closed while one of these lives.
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

/// An object of the library, closed with this.
class Hdf5Id {
 public:
  using Close = herr_t (*)(hid_t);
  Hdf5Id(const std::string& path, const std::string& place, hid_t id, Close close) : id_(id), close_(close) {
    if (id < 0) throw InputError(path, place, "damage, HDF5 cannot read it", "an undamaged HDF5 file");
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

/// A file and what is read of it. `place` of an object: how messages name it, "/Data/Surface". Everything
/// throws InputError for damage, and for what lies in other files. One at a time in the program.
class Hdf5File {
 public:
  explicit Hdf5File(const std::string& path);
  Hdf5File(const Hdf5File&) = delete;
  Hdf5File& operator=(const Hdf5File&) = delete;

  const std::string& path() const { return path_; }
  const FileBytes& bytes() const { return file_bytes_; }
  const Hdf5Id& root() const { return root_; }

  /// True for a member of the file itself, not for links to others.
  bool has(const Hdf5Id& group, const std::string& name) const;
  /// Its members' names, at most `most`, in the order of the alphabet.
  std::vector<std::string> names(const Hdf5Id& group, std::size_t most) const;
  std::size_t count(const Hdf5Id& group) const;
  Hdf5Id group(const Hdf5Id& parent, const std::string& name, const std::string& place) const;
  Hdf5Id data_set(const Hdf5Id& parent, const std::string& name, const std::string& place) const;
  /// See hdf5_attributes.
  std::map<std::string, Hdf5Value> attributes(const Hdf5Id& object) const;
  /// The numbers of a data set of rows and columns, no more than the file can hold, row 0 first.
  Grid matrix(const Hdf5Id& data, const std::string& place) const;

  /// Throws the InputError of a file of a layout that is not known, which says what its top level holds.
  [[noreturn]] void refuse_layout() const;

 private:
  Hdf5Id member(const Hdf5Id& parent, const std::string& name, const std::string& place, H5I_type_t kind,
                const char* allowed) const;

  std::string path_, contents_;
  FileBytes file_bytes_;
  QuietHdf5 quiet_;
  Hdf5Id root_;
};

/// True for an HDF5 file with the groups of 4D Technology; false for others and for damaged ones.
bool is_4d_hdf5(const std::string& path);

}  // namespace aberfit::internal
