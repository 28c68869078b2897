// Recognises a file that a command cannot use, and names the command that can.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "aberfit/commands/program.h"
#include "aberfit/core/errors.h"
#include "aberfit/core/text.h"
#include "aberfit/measured/read_measurement.h"

namespace aberfit {
namespace {

enum class FileKind {
  kStudy,
  kResult,
  kRoughnessBlock,
  kMeasurement,
  kCoefficients,
  kPsdTable,
  kEmpty,
  kUnknown
};

struct KnownFile {
  FileKind kind = FileKind::kUnknown;
  std::string word;  // the kind of a result, the format of a measurement
  bool has_study = false;
};

KnownFile of_kind(FileKind kind) {
  KnownFile file;
  file.kind = kind;
  return file;
}

// A study has none of the keys by which results and single blocks are known. If the text is not JSON, the
// study's reader explains it.
KnownFile known_json(const std::string& text) {
  const auto json =
      nlohmann::json::parse(text, nullptr, false, true);  // comments are allowed here; the reader judges them
  if (!json.is_object()) return {};
  if (json.contains("FILE_FORMAT")) return {FileKind::kMeasurement, "dabam", false};
  if (const auto kind = json.find("kind");
      kind != json.end() && kind->is_string() && json.contains("aberfit"))
    return {FileKind::kResult, kind->get<std::string>(), json.contains("study")};
  if (json.contains("psd") && !json.contains("aberfit") && !json.contains("mirror"))
    return of_kind(FileKind::kRoughnessBlock);
  return of_kind(FileKind::kStudy);
}

KnownFile known_text(const std::string& path, const std::string& text) {
  for (const std::string_view line : words(text, "\r\n")) {
    if (line.starts_with('#') || trimmed(line).empty()) continue;
    if (line.starts_with("kind,n,m,noll,")) return of_kind(FileKind::kCoefficients);
    const std::string lower = lower_case(line);
    if (lower.find("psd") != std::string::npos && lower.front() == 'f') return of_kind(FileKind::kPsdTable);
    break;
  }
  const MeasuredFormat format = detect_format(path);
  if (format == MeasuredFormat::kAuto) return {};
  return {FileKind::kMeasurement, to_string(format), false};
}

KnownFile known_file(const std::string& path) {
  constexpr std::uintmax_t kHead = 65536;
  const std::optional<std::string> head = file_bytes(path, kHead);
  if (!head) return {};
  std::string text = utf8_text(*head);
  if (text.starts_with("\xef\xbb\xbf")) text.erase(0, 3);
  const std::string_view content = trimmed(text);
  if (content.empty()) return of_kind(FileKind::kEmpty);
  try {
    const bool is_json = content.starts_with('{') || content.starts_with("//") || content.starts_with("/*");
    if (!is_json) return known_text(path, text);
    const std::optional<std::string> whole = file_bytes(path);
    return whole ? known_json(utf8_text(*whole)) : KnownFile{};
  } catch (const std::exception&) {
    return {};  // the reader reports the error
  }
}

std::string beside(const std::string& path) { return std::filesystem::path(path).filename().string(); }

[[noreturn]] void refuse_file(const std::string& path, const KnownFile& file, const std::string& command) {
  const std::string name = beside(path);
  switch (file.kind) {
    case FileKind::kMeasurement:
      throw InputError(
          path, "", fmt::format("a measured file (format {}), not a study", file.word),
          fmt::format("`aberfit psd {}`, which estimates its PSD; or a study (JSON) that names it, as a psd "
                      "of \"model\": \"measured\" or (for a height map) as target.map",
                      path));
    case FileKind::kCoefficients:
      throw InputError(
          path, "",
          "coefficients of a surface, not a " + std::string(command == "psd" ? "measurement" : "study"),
          fmt::format("`aberfit trace STUDY --coefficients {}`, with the study that they belong to", path));
    case FileKind::kPsdTable:
      throw InputError(
          path, "", "a table of a PSD, not a " + std::string(command == "psd" ? "measurement" : "study"),
          fmt::format("a study whose roughness is {{\"psd\": {{\"model\": \"table\", \"file\": \"{}\"}}}}",
                      name));
    case FileKind::kResult:
      throw InputError(path, "", fmt::format("a result of kind {}, not a study", file.word),
                       file.has_study
                           ? "a study; the block \"study\" of this result is one"
                           : "a study; the block \"roughness\" of this result can be pasted into one");
    case FileKind::kRoughnessBlock:
      throw InputError(
          path, "", "a block of roughness, not a whole study",
          "a study that contains it as \"roughness\", with \"mirror\", \"aperture\" and \"light\"");
    case FileKind::kEmpty:
      throw InputError(path, "", "an empty file",
                       command == "psd" ? "a measured file" : "a study file (JSON), see `aberfit schema`");
    case FileKind::kStudy:
    case FileKind::kUnknown:
      break;
  }
  throw InputError(path, "", "a study", fmt::format("a file other than a study for `aberfit {}`", command));
}

}  // namespace

void require_right_file(const std::string& path, const std::string& command) {
  if (path == "-") return;
  const KnownFile file = known_file(path);
  const bool of_psd = command == "psd" && file.kind == FileKind::kMeasurement;
  if (file.kind != FileKind::kStudy && file.kind != FileKind::kUnknown && !of_psd)
    refuse_file(path, file, command);
}

std::string command_for(const std::string& path) {
  switch (known_file(path).kind) {
    case FileKind::kMeasurement:
      return "psd " + path;
    case FileKind::kStudy:
      return "check " + path;
    case FileKind::kCoefficients:
      return "trace STUDY --coefficients " + path;
    default:
      return "";
  }
}

}  // namespace aberfit
