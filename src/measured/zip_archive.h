#pragma once
#include <zip.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace aberfit::internal {

/// A zip archive in memory; `path` and `bytes` must outlive it. what: description for messages, "an x3p file,
/// a zip archive". Throws InputError if the bytes are not an archive.
class ZipArchive {
 public:
  ZipArchive(const std::string& path, std::string_view bytes, const std::string& what);
  ~ZipArchive();
  ZipArchive(const ZipArchive&) = delete;
  ZipArchive& operator=(const ZipArchive&) = delete;

  /// Returns the names of the first ten thousand members, with their folders, in the order of the archive.
  std::vector<std::string> names() const;

  /// Returns the content of a member, at most `most` bytes, checked by its CRC. Memory grows with the
  /// content, because the stated length may be wrong. Throws InputError that names the member.
  std::string content(const std::string& name, std::uint64_t most) const;

 private:
  [[noreturn]] void fail(const std::string& name, const std::string& found, const std::string& allowed) const;

  const std::string& path_;
  std::uint64_t size_;
  zip_t* archive_ = nullptr;
};

/// Throws InputError for an archive that is not an X3P. The message tells what it is by the names of its
/// members (an Excel workbook and so on), or lists them, and how to proceed.
[[noreturn]] void refuse_other_zip(const std::string& path, const std::vector<std::string>& names);

}  // namespace aberfit::internal
