#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "map_reading.h"

// Values of attributes from the bytes of an HDF5 file, every length checked: the library trusts the lengths
// of texts and sequences in the file, allocates them, and writes beyond them where the heap says another one.
// After the HDF5 File Format Specification 3.0, sections III.E (global heap) and IV.A (object headers).

namespace aberfit::internal {

/// What an attribute of variable length, text or sequence, takes in an attribute: count, address, index.
inline constexpr std::uint64_t kHdf5PointerBytes = 16;

/// The stored values of the attributes of an object by their names, padding behind them included. header:
/// where its object header begins. Addresses and lengths in the file have eight bytes. Attributes that are
/// stored outside the header (many or large ones of newer files) are not among them. Throws InputError for a
/// damaged header.
std::map<std::string, std::string_view> hdf5_attribute_values(const FileBytes& file, std::uint64_t header);

/// The elements that a pointer of kHdf5PointerBytes means, of `element_bytes` each. Throws InputError.
std::string_view hdf5_heap_value(const FileBytes& file, std::string_view pointer,
                                 std::uint64_t element_bytes);

}  // namespace aberfit::internal
