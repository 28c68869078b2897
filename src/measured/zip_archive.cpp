#include "zip_archive.h"

#include <fmt/format.h>

#include <algorithm>

#include "gzip.h"
#include "map_reading.h"

namespace aberfit::internal {

ZipArchive::ZipArchive(const std::string& path, std::string_view bytes, const std::string& what)
    : path_(path), size_(bytes.size()) {
  zip_error_t error;
  zip_error_init(&error);
  zip_source_t* const source = zip_source_buffer_create(bytes.data(), bytes.size(), 0, &error);
  if (source != nullptr) archive_ = zip_open_from_source(source, ZIP_RDONLY, &error);
  const std::string message = one_line(zip_error_strerror(&error), 200);
  if (archive_ == nullptr && source != nullptr) zip_source_free(source);
  zip_error_fini(&error);
  if (archive_ == nullptr) throw InputError(path_, "", message, what);
}

ZipArchive::~ZipArchive() { zip_discard(archive_); }

std::vector<std::string> ZipArchive::names() const {
  constexpr zip_int64_t kMost = 10000;
  std::vector<std::string> names;
  for (zip_int64_t i = 0; i < std::min(zip_get_num_entries(archive_, 0), kMost); ++i)
    if (const char* const name = zip_get_name(archive_, zip_uint64_t(i), 0)) names.emplace_back(name);
  return names;
}

std::string ZipArchive::content(const std::string& name, std::uint64_t most) const {
  zip_stat_t about;
  zip_stat_init(&about);
  if (zip_stat(archive_, name.c_str(), 0, &about) != 0)
    throw InputError(path_, one_line(name, 80), "nothing", "a file of that name in the archive");
  constexpr zip_uint64_t kWanted =
      ZIP_STAT_SIZE | ZIP_STAT_COMP_SIZE | ZIP_STAT_COMP_METHOD | ZIP_STAT_ENCRYPTION_METHOD;
  if ((about.valid & kWanted) != kWanted)
    fail(name, "an incomplete entry", "size and method of the packed file");
  if (about.encryption_method != ZIP_EM_NONE) fail(name, "encrypted content", "content without a password");
  if (about.comp_method != ZIP_CM_STORE && about.comp_method != ZIP_CM_DEFLATE)
    fail(name, fmt::format("compression method {}", about.comp_method), "0 (stored) or 8 (deflate)");
  const std::uint64_t packed = std::min<std::uint64_t>(about.comp_size, size_);
  if (about.size > most || about.size / kMostByDeflate > packed)
    fail(name, fmt::format("{} bytes, packed in {}", about.size, packed),
         fmt::format("at most {} bytes", most));
  zip_file_t* const file = zip_fopen(archive_, name.c_str(), 0);
  if (file == nullptr) fail(name, one_line(zip_strerror(archive_), 200), "content that can be unpacked");
  constexpr std::uint64_t kFirst = 1 << 20;
  std::string bytes;
  std::size_t got = 0;
  zip_int64_t read = 1;
  while (read > 0 && got < about.size) {
    bytes.resize(std::size_t(std::min<std::uint64_t>(about.size, std::max<std::uint64_t>(kFirst, 2 * got))));
    read = zip_fread(file, bytes.data() + got, bytes.size() - got);
    if (read > 0) got += std::size_t(read);
  }
  bytes.resize(got);
  // libzip checks the CRC when reading reaches the end of the content.
  char beyond = 0;
  const zip_int64_t after = read < 0 ? read : zip_fread(file, &beyond, 1);
  const std::string message = after < 0 ? one_line(zip_file_strerror(file), 200) : "another length";
  zip_fclose(file);
  if (after != 0 || got < about.size)
    fail(name, fmt::format("{} after {} bytes", message, got), fmt::format("{} bytes", about.size));
  return bytes;
}

void ZipArchive::fail(const std::string& name, const std::string& found, const std::string& allowed) const {
  throw InputError(path_, one_line(name, 80), found, allowed);
}

bool is_gzip(std::string_view bytes) { return bytes.starts_with("\x1f\x8b"); }

namespace {

// Returns the number of bytes before the packed data of a gzip file (RFC 1952, section 2.3).
std::uint64_t gzip_header(const FileBytes& file) {
  enum Flags : unsigned { kHeaderCrc = 2, kExtra = 4, kName = 8, kComment = 16 };
  constexpr unsigned kDeflateMethod = 8;
  if (file.at<std::uint8_t>(2) != kDeflateMethod) file.fail(2, "another method of packing", "deflate, 8");
  const unsigned flags = file.at<std::uint8_t>(3);
  std::uint64_t place = 10;
  if (flags & kExtra) place += 2 + file.at<std::uint16_t>(place);
  for (const unsigned text : {unsigned(kName), unsigned(kComment)})
    if (flags & text)
      while (file.at<std::uint8_t>(place++) != 0) {
      }
  return place + (flags & kHeaderCrc ? 2 : 0);
}

std::string little(std::uint64_t value, int width) {
  std::string text;
  for (int i = 0; i < width; ++i) text += char(value >> (8 * i));
  return text;
}

}  // namespace

std::string unpacked_gzip(const std::string& path, std::string_view bytes) {
  const FileBytes file(path, bytes, std::endian::little);
  constexpr std::uint64_t kTrailer = 8, kLongest = 0xffffffff;
  const std::uint64_t begin = gzip_header(file);
  if (!file.holds(begin, kTrailer) || file.size() > kLongest)
    file.fail(begin, fmt::format("a file compressed with gzip of {} bytes", file.size()),
              "a complete gzip file of less than 4 GiB; gunzip unpacks it");
  const std::uint64_t length = file.size() - begin - kTrailer;
  // gzip and zip use the same compression, CRC and length: the zip reader reads an archive of one member.
  const std::string name = "content";
  const std::string entry = little(20, 2) + little(0, 2) + little(ZIP_CM_DEFLATE, 2) + little(0, 4) +
                            std::string(file.text(file.size() - kTrailer, 4)) + little(length, 4) +
                            std::string(file.text(file.size() - 4, 4)) + little(name.size(), 2) +
                            little(0, 2);
  std::string archive = "PK\x03\x04" + entry + name;
  archive += file.text(begin, length);
  const std::string central = "PK\x01\x02" + little(20, 2) + entry + std::string(14, '\0') + name;
  const std::size_t end = archive.size();
  archive += central + "PK\x05\x06" + little(0, 4) + little(1, 2) + little(1, 2) + little(central.size(), 4) +
             little(end, 4) + little(0, 2);
  return ZipArchive(path, archive, "an undamaged file compressed with gzip").content(name, kLongest);
}

void refuse_other_zip(const std::string& path, const std::vector<std::string>& names) {
  struct Kind {
    const char *member, *what, *way;  // member: beginning of a name, or its end after '*'
  };
  constexpr const char* kGwyddion = "open it in Gwyddion and save it as text with its header";
  static constexpr Kind kKinds[] = {
      {"xl/", "an Excel workbook", "export the sheet as CSV"},
      {"word/", "a Word document", "save its numbers as CSV"},
      {"ppt/", "a PowerPoint presentation", "save its numbers as CSV"},
      {"META-INF/manifest.xml", "an OpenDocument file", "export the sheet as CSV"},
      {"Index/", "a document of Apple Numbers or Pages", "export it as CSV"},
      {"*.npy", "a NumPy archive (.npz)", "save the one array with numpy.save, as .npy"},
      {"LAYER_", "a Sensofar .plux", kGwyddion},
      {"recipe.txt", "a Sensofar .plux", kGwyddion}};
  const std::string found = "a zip archive that is not an X3P file";
  for (const Kind& kind : kKinds)
    for (const std::string& name : names) {
      const std::string_view member = kind.member;
      if (member.starts_with('*') ? name.ends_with(member.substr(1)) : name.starts_with(member))
        throw InputError(path, "", fmt::format("{}: it holds {}, {}", found, one_line(name, 80), kind.what),
                         fmt::format("a measured map or profile; {}", kind.way));
    }
  constexpr std::size_t kMostNamed = 4;
  std::string held;
  for (std::size_t i = 0; i < std::min(names.size(), kMostNamed); ++i)
    held += (held.empty() ? "" : ", ") + one_line(names[i], 80);
  if (names.size() > kMostNamed) held += fmt::format(" and {} more", names.size() - kMostNamed);
  throw InputError(
      path, "", fmt::format("{}: it holds {}", found, held.empty() ? "nothing" : held),
      "an X3P file, in which main.xml describes the surface; or the measured file itself, unpacked");
}

}  // namespace aberfit::internal
