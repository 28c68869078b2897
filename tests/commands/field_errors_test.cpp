// An error of the method about a field reaches the user with file and pointer, whatever the command.
#include "aberfit/study/field_errors.h"

#include <gtest/gtest.h>

#include <functional>

#include "aberfit/commands/run.h"
#include "aberfit/study/read_study.h"

namespace aberfit {
namespace {

// A wave theory with the paper's rule for rays; only the method detects this.
const char* const kStudy = R"({"aberfit": 1, "mirror": {"focal_length": "2.8 m"},
    "aperture": {"shape": "circle", "diameter": "0.4 m"}, "light": {"wavelength": "632.8 nm"},
    "roughness": {"psd": {"model": "uniform", "rms": "200 nm", "f_min": "2.5 /m", "f_max": "12 /m"}},
    "target": {"theory": "ghs", "convention": "paper"}, "terms": {"zernike": {"n_max": 4}}})";

TEST(FieldErrors, AFieldOfTheTaskIsAPointerOfTheFile) {
  Study study;
  study.path = "mine/study.json";
  const InputError error = input_error(study, FieldError("target.psd.method", "\"x\"", "\"y\""));
  EXPECT_EQ(error.file(), "mine/study.json");
  EXPECT_EQ(error.pointer(), "/target/psd/method");
  EXPECT_EQ(error.found(), "\"x\"");
  EXPECT_EQ(error.allowed(), "\"y\"");
  EXPECT_EQ(with_fields_of(study, [] { return 7; }), 7);
  EXPECT_THROW(with_fields_of(study, []() -> int { throw ComputationError("other"); }), ComputationError);
}

TEST(FieldErrors, EveryCommandNamesTheFile) {
  const Study study = parse_study(kStudy, "mine/study.json");
  const std::pair<const char*, std::function<void()>> commands[] = {
      {"fit", [&] { run_fit(study, {}); }},
      {"check", [&] { run_check(study, {}); }},
      {"trace", [&] { run_trace(study, {}); }},
      {"verify", [&] { run_verify(study, {}); }},
  };
  for (const auto& [name, run] : commands) {
    SCOPED_TRACE(name);
    try {
      run();
      ADD_FAILURE() << "nothing thrown";
    } catch (const InputError& error) {
      EXPECT_EQ(error.file(), "mine/study.json");
      EXPECT_EQ(error.pointer(), "/target/theory");
    }
  }
}

}  // namespace
}  // namespace aberfit
