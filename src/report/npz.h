#pragma once
#include <Eigen/Core>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace aberfit::internal {

/// An array of any number of axes in C order: the last axis changes fastest.
struct NpyArray {
  std::string name;  ///< name with unit
  std::vector<Eigen::Index> shape;
  std::vector<double> values;
};

/// The bytes of an .npy file, format 1.0: little-endian doubles (NumPy, "NEP 1").
std::string npy_bytes(const NpyArray& array);

/// A zip archive of the files (name, bytes) without compression (PKWARE, APPNOTE.TXT 4.3). All dates are
/// 1980, so that equal contents give equal bytes. Throws std::runtime_error above the 4 GiB of its 32-bit
/// fields.
std::string stored_zip(const std::vector<std::pair<std::string, std::string>>& files);

/// CRC-32 of zip: polynomial 0xEDB88320, reflected.
std::uint32_t crc32_of(std::string_view bytes);

}  // namespace aberfit::internal
