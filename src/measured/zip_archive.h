#pragma once
#include <zip.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace aberfit::internal {

/// A zip archive in memory; `path`, its file, and `bytes` have to outlive it. what: for messages, "an x3p
/// file, a zip archive". Throws InputError where the bytes are no archive.
class ZipArchive {
 public:
  ZipArchive(const std::string& path, std::string_view bytes, const std::string& what);
  ~ZipArchive();
  ZipArchive(const ZipArchive&) = delete;
  ZipArchive& operator=(const ZipArchive&) = delete;

  /// Names of its members in the order of the archive, folders before them, the first ten thousand.
  std::vector<std::string> names() const;

  /// The content of a member, of at most `most` bytes; checked by its CRC. Memory is taken as the content
  /// comes, not as its length is said to be. Throws InputError that names the member.
  std::string content(const std::string& name, std::uint64_t most) const;

 private:
  [[noreturn]] void fail(const std::string& name, const std::string& found, const std::string& allowed) const;

  const std::string& path_;
  std::uint64_t size_;
  zip_t* archive_ = nullptr;
};

/// True for bytes that begin as gzip does.
bool is_gzip(std::string_view bytes);

/// What gzip packed, checked by its CRC; less than 4 GiB, and one file (not several behind each other).
/// Throws InputError.
std::string unpacked_gzip(const std::string& path, std::string_view bytes);

/// Throws the InputError of an archive that is no X3P: what it is by the names of its members, an Excel
/// workbook and so on, else what it holds; and what to do.
[[noreturn]] void refuse_other_zip(const std::string& path, const std::vector<std::string>& names);

}  // namespace aberfit::internal
