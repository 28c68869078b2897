#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "map_reading.h"

// Reads attributes from the bytes of an HDF5 file and checks every length; the library would read or allocate
// whatever a damaged file claims. Source: HDF5 File Format Specification 3.0, sections III.E (global heap),
// IV.A (object headers, datatype and attribute messages).

namespace aberfit::internal {

/// A datatype, as far as attributes of numbers, texts and compounds need it.
struct Hdf5Type {
  /// Codes of the file format.
  enum Kind : unsigned { kInteger = 0, kFloat = 1, kText = 3, kCompound = 6, kVariable = 9, kArray = 10 };
  unsigned kind = 0;
  bool variable_text = false;  ///< kVariable: text rather than a sequence
  bool big_endian = false;
  std::uint64_t bytes = 0;     ///< size of a value; kVariable: of count, address and index of its elements
  std::vector<Hdf5Type> base;  ///< kVariable, kArray: type of the elements
  struct Member;
  std::vector<Member> members;  ///< kCompound
};
struct Hdf5Type::Member {
  std::string name;
  std::uint64_t place = 0;
  Hdf5Type type;
};

struct Hdf5Value {
  Hdf5Type type;
  std::string_view bytes;
};

/// Returns the attributes of an object that have one value, by name. header: its object header; addresses and
/// lengths must have eight bytes. Attributes outside the header (many or large ones in newer files), with
/// several values or of other types are omitted. Throws InputError for damage.
std::map<std::string, Hdf5Value> hdf5_attributes(const FileBytes& file, std::uint64_t header);

/// Throws InputError unless the nodes of an older group, or the links of a newer one, lie in the file.
void require_hdf5_group(const FileBytes& file, std::uint64_t header);

/// Returns true for a data set whose data lie in other files; to be called before the library opens it.
bool hdf5_data_outside(const FileBytes& file, std::uint64_t header);

/// Return the value; nothing if it is of another type. Accepted are an integer of 32 bits or a floating-point
/// number, a text up to its end or a NUL, doubles in an array or a sequence, and a member of a compound.
/// Little-endian only. Throw InputError for damage.
std::optional<double> hdf5_number(const FileBytes& file, const Hdf5Value& value);
std::optional<std::string_view> hdf5_text(const FileBytes& file, const Hdf5Value& value);
std::optional<std::vector<double>> hdf5_numbers(const FileBytes& file, const Hdf5Value& value);
std::optional<Hdf5Value> hdf5_member(const FileBytes& file, const Hdf5Value& value, std::string_view name);

}  // namespace aberfit::internal
