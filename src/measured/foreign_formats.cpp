#include "foreign_formats.h"

#include <fmt/format.h>

#include <filesystem>
#include <string_view>

#include "map_reading.h"

namespace aberfit::internal {
namespace {

enum class Way { kGwyddion, kTable, kPicture, kNumPy };

// magic: first bytes of the file; suffix: end of its name; either may be empty.
struct Foreign {
  std::string_view magic;
  const char *suffix, *what;
  Way way = Way::kGwyddion;
};

// Surface formats that Gwyddion opens (its "Supported file formats"), and other common files.
constexpr Foreign kForeign[] = {
    {"DIGITAL SURF", ".sur", "a Digital Surf surface (.sur, MountainsMap)"},
    {"DSCOMPRESSED", ".sur", "a Digital Surf surface (.sur, MountainsMap)"},
    {"", ".mnt", "a MountainsMap document (.mnt)"},
    {"", ".plu", "a Sensofar surface (.plu)"},
    {"", ".plux", "a Sensofar surface (.plux)"},
    {"", ".nms", "a NanoFocus surface (.nms)"},
    {"GWYP", ".gwy", "a Gwyddion file (.gwy)"},
    {"GWYO", ".gwy", "a Gwyddion file (.gwy)"},
    {"AliconaImaging", ".al3d", "an Alicona surface (.al3d)"},
    {"VCA DATA", ".opdx", "a Bruker or Dektak surface (.opdx)"},
    {"VK3", ".vk3", "a Keyence surface (.vk3)"},
    {"VK4", ".vk4", "a Keyence surface (.vk4)"},
    {"VK6", ".vk6", "a Keyence surface (.vk6)"},
    {"VK7", ".vk7", "a Keyence surface (.vk7)"},
    {"KPK0", ".zon", "a Keyence surface (.zon)"},
    {"", ".lext", "an Olympus surface (.lext)"},
    {"\\*File list", ".spm", "a Bruker Nanoscope file (.spm)"},
    {"", ".nid", "a Nanosurf file (.nid)"},
    {"", ".ibw", "an Igor binary wave (.ibw)"},
    {"", ".sxm", "a Nanonis file (.sxm)"},
    {"", ".jpk", "a JPK file (.jpk)"},
    {"", ".frt", "an FRT surface (.frt)"},
    {"FRTM_GLIDERV", "", "an FRT surface (.frt)"},
    {"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", ".xls", "an old Excel or Word file", Way::kTable},
    {"%PDF-", ".pdf", "a PDF document", Way::kTable},
    {"MATLAB 5.0 MAT-file", ".mat", "a MATLAB file (.mat)", Way::kNumPy},
    {{"II*\0", 4}, ".tif", "a TIFF picture", Way::kPicture},
    {{"MM\0*", 4}, ".tiff", "a TIFF picture", Way::kPicture},
    {"\x89PNG", ".png", "a PNG picture", Way::kPicture},
    {"\xff\xd8\xff", ".jpg", "a JPEG picture", Way::kPicture},
    {"BM", ".bmp", "a BMP picture", Way::kPicture}};

std::string way_of(Way way) {
  switch (way) {
    case Way::kGwyddion:
      return "its heights as text (Gwyddion opens such files and saves text with a header: File, Save As, "
             ".txt)";
    case Way::kTable:
      return "its numbers as CSV, exported by the program that wrote it";
    case Way::kPicture:
      return "heights as numbers, not as grey levels (the data that the instrument saved with the picture)";
    case Way::kNumPy:
      break;
  }
  return "its array as .npy of NumPy (numpy.save), as text or as FITS";
}

}  // namespace

void refuse_foreign_format(const std::string& path) {
  constexpr std::size_t kMagic = 64;
  const std::string head = file_bytes(path, kMagic).value_or("");
  const std::string suffix = lower_case(std::filesystem::path(path).extension().string());
  const auto refuse = [&](const Foreign& foreign, const char* known) {
    throw InputError(path, "", fmt::format("{}{}, which aberfit cannot read", foreign.what, known),
                     way_of(foreign.way));
  };
  // A magic number of two letters is not conclusive, so the name must agree as well.
  constexpr std::size_t kTooShort = 2;
  for (const Foreign& foreign : kForeign)
    if (foreign.magic.size() > kTooShort && head.starts_with(foreign.magic)) refuse(foreign, "");
  for (const Foreign& foreign : kForeign)
    if (!suffix.empty() && suffix == foreign.suffix) refuse(foreign, " by its name");
}

}  // namespace aberfit::internal
