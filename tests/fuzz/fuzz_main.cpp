// The entry point for libFuzzer. One program has all targets: `fuzz --target=NAME [OPTIONS OF LIBFUZZER]
// FOLDER`; `fuzz --list` and `fuzz --target=NAME --write-seeds=FOLDER` do not fuzz.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>

#include "harness.h"
#include "targets.h"

namespace {

using aberfit::test::FuzzTarget;

FuzzTarget chosen;

std::string_view option(std::string_view argument, std::string_view name) {
  return argument.starts_with(name) ? argument.substr(name.size()) : std::string_view();
}

void write_seeds(const FuzzTarget& target, const std::string& folder) {
  std::filesystem::create_directories(folder);
  std::size_t number = 0;
  for (const std::string& seed : target.seeds()) {
    std::ofstream(std::filesystem::path(folder) / ("seed-" + std::to_string(number++)), std::ios::binary)
        .write(seed.data(), std::streamsize(seed.size()));
  }
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int* count, char*** values) {
  std::string name, folder;
  bool list = false;
  for (int i = 1; i < *count; ++i) {
    const std::string_view argument = (*values)[i];
    if (const auto text = option(argument, "--target="); !text.empty()) name = text;
    if (const auto text = option(argument, "--write-seeds="); !text.empty()) folder = text;
    list = list || argument == "--list";
  }
  for (const FuzzTarget& target : aberfit::test::fuzz_targets()) {
    if (list) std::printf("%s %zu\n", target.name.c_str(), target.longest);
    if (target.name == name) chosen = target;
  }
  if (list) std::exit(0);
  if (!chosen.read) {
    std::fprintf(stderr, "--target=NAME is missing or unknown; --list shows the names\n");
    std::exit(2);
  }
  if (!folder.empty()) {
    write_seeds(chosen, folder);
    std::exit(0);
  }
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  chosen.read(std::string_view(reinterpret_cast<const char*>(data), size));
  return 0;
}
