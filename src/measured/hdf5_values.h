#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "map_reading.h"

// Attributes from the bytes of an HDF5 file, every length checked. The library trusts the lengths that it
// finds in attributes: of a damaged file it reads beyond its buffers, and allocates what the file asks for.
// After the HDF5 File Format Specification 3.0, sections III.E (global heap), IV.A (object headers, datatype
// and attribute messages).

namespace aberfit::internal {

/// A datatype, as far as attributes of numbers, texts and compounds need it.
struct Hdf5Type {
  /// As in the file.
  enum Kind : unsigned { kInteger = 0, kFloat = 1, kText = 3, kCompound = 6, kVariable = 9, kArray = 10 };
  unsigned kind = 0;
  bool variable_text = false;  ///< kVariable: a text, not a sequence
  bool big_endian = false;
  std::uint64_t bytes = 0;  ///< what a value takes; kVariable: count, address and index of what it points to
  std::vector<Hdf5Type> base;  ///< kVariable, kArray: the type of the elements
  struct Member;
  std::vector<Member> members;  ///< kCompound
};
struct Hdf5Type::Member {
  std::string name;
  std::uint64_t place = 0;
  Hdf5Type type;
};

/// A value in the file.
struct Hdf5Value {
  Hdf5Type type;
  std::string_view bytes;
};

/// The attributes of an object that have one value, by name. header: where its object header begins.
/// Addresses and lengths in the file have eight bytes. Attributes outside the header (many or large ones of
/// newer files), of several values and of other types are not among them. Throws InputError for damage.
std::map<std::string, Hdf5Value> hdf5_attributes(const FileBytes& file, std::uint64_t header);

/// Throws InputError unless the nodes that a group of the older kind has, and the links of the newer kind,
/// lie in the file, where the library looks for them unasked.
void require_hdf5_group(const FileBytes& file, std::uint64_t header);

/// True for a data set whose data lie in other files; to be asked before the library opens it.
bool hdf5_data_outside(const FileBytes& file, std::uint64_t header);

/// What a value is; nothing where it is of another type: an integer of 32 bits or a floating-point number, a
/// text up to its end or a NUL, doubles in an array or a sequence, a member of a compound. Little-endian.
/// Throws InputError for damage.
std::optional<double> hdf5_number(const FileBytes& file, const Hdf5Value& value);
std::optional<std::string_view> hdf5_text(const FileBytes& file, const Hdf5Value& value);
std::optional<std::vector<double>> hdf5_numbers(const FileBytes& file, const Hdf5Value& value);
std::optional<Hdf5Value> hdf5_member(const FileBytes& file, const Hdf5Value& value, std::string_view name);

}  // namespace aberfit::internal
