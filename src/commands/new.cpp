// `aberfit new` writes a starter study, a file with comments, from which the user can begin.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "aberfit/commands/program.h"
#include "aberfit/commands/terminal_text.h"
#include "aberfit/core/embedded_texts.h"
#include "aberfit/core/errors.h"
#include "aberfit/core/text.h"
#include "aberfit/report/result.h"

namespace aberfit {
using namespace internal;

namespace {

namespace fs = std::filesystem;

// A commented study, starters/<kind>.jsonc.
struct Starter {
  std::string_view kind, text;
};

std::vector<Starter> starters() {
  std::vector<Starter> all;
  for (const char* kind : {"specification", "profile", "map", "budget", "sweep", "paper"})
    all.push_back({kind, embedded_text(std::string(kind) + ".jsonc")});
  return all;
}

// The first line of a starter, "// PURPOSE", which is a sentence.
std::string purpose(const Starter& starter) {
  return std::string(trimmed(starter.text.substr(2, starter.text.find('\n') - 2)));
}

void list_starters() {
  fmt::print("aberfit new KIND [FILE] writes a commented study to start from. Kinds:\n");
  for (const Starter& starter : starters())
    fmt::print("  {:<13} {}\n", starter.kind,
               wrapped("............. " + purpose(starter), text_width() - 2, 16).substr(14));
}

Starter starter_of(const std::string& kind) {
  for (const Starter& starter : starters())
    if (starter.kind == kind) return starter;
  const std::vector<std::string> kinds = starter_kinds();
  const std::vector<std::string> near = near_words(kind, kinds);
  throw InputError("command line", "", fmt::format("the kind \"{}\"", kind),
                   (near.empty() ? "" : fmt::format("did you mean \"{}\"? ", near.front())) +
                       fmt::format("one of {}", fmt::join(kinds, ", ")));
}

void replace_all(std::string* text, const std::string& what, const std::string& with) {
  for (std::size_t at = 0; (at = text->find(what, at)) != std::string::npos; at += with.size())
    text->replace(at, what.size(), with);
}

// The place of "file": "my_..." in a starter that needs a measurement; npos in others.
std::size_t place_of_file(const std::string& text) { return text.find("\"file\": \"my_"); }

void name_measurement(const fs::path& file, const fs::path& study, std::string* text) {
  const fs::path folder = fs::absolute(study).parent_path();
  const std::string whole = fs::absolute(file).lexically_normal().generic_string();
  const std::string beside = fs::path(whole).lexically_proximate(folder).generic_string();
  const std::string& name = beside.size() < whole.size() ? beside : whole;
  const std::size_t begin = place_of_file(*text), value = text->find("\"my_", begin);
  const std::string placeholder = text->substr(value, text->find('"', value + 1) + 1 - value);
  replace_all(text, placeholder, nlohmann::json(name).dump());
}

}  // namespace

std::vector<std::string> starter_kinds() {
  std::vector<std::string> kinds;
  for (const Starter& starter : starters()) kinds.emplace_back(starter.kind);
  return kinds;
}

ExitCode new_command(CommandLine line) {
  if (line.starter_kind.empty()) {
    list_starters();
    return ExitCode::kDone;
  }
  const Starter starter = starter_of(line.starter_kind);
  std::string text(starter.text);
  const std::string& given = line.starter_file;
  fs::path target = std::string(starter.kind) + ".jsonc";
  const bool is_measurement = !given.empty() && !given.ends_with(".jsonc");
  if (is_measurement) {
    if (given.ends_with(".json") || place_of_file(text) == std::string::npos)
      throw InputError("command line", "", fmt::format("the file \"{}\"", given),
                       "the name of a new study, ending in .jsonc because it has comments; for the kinds "
                       "profile and map also the measured file that the study is about");
    if (!fs::is_regular_file(given))
      throw InputError(given, "", "a file that cannot be read", "a measured file");
    target = fs::path(given).filename().replace_extension(".jsonc");
    name_measurement(given, target, &text);
  } else if (!given.empty()) {
    target = given;
  }
  if (fs::exists(target) && !line.force)
    throw InputError(target.string(), "", "a file that is already there",
                     "another name, or --force to overwrite it");
  replace_all(&text, std::string(starter.kind) + ".jsonc", target.string());
  replace_all(&text, fmt::format("out/{}/", starter.kind), fmt::format("out/{}/", target.stem().string()));
  write_file(target.string(), text);
  if (!line.quiet)
    fmt::print(stderr, "wrote {}; its comments say what to change and which command to run\n",
               target.string());
  return ExitCode::kDone;
}

}  // namespace aberfit
