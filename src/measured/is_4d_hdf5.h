#pragma once
#include <string>

namespace aberfit::internal {

/// Returns true for an HDF5 file with the groups of 4D Technology; false for others and for damaged ones.
bool is_4d_hdf5(const std::string& path);

}  // namespace aberfit::internal
