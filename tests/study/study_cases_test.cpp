// Cases of a study: the studies that they give, and the hash that names them.
#include "aberfit/study/study_cases.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "aberfit/core/content_hash.h"
#include "aberfit/core/errors.h"
#include "aberfit/study/read_study.h"
#include "study/scratch_folder.h"

namespace aberfit {
namespace {

using nlohmann::ordered_json;
using test::ScratchFolder;

ordered_json plain() {
  return ordered_json::parse(R"({ "aberfit": 1, "title": "one", "mirror": { "focal_length": "1 m" },
    "aperture": { "shape": "circle", "diameter": "0.2 m" }, "light": { "wavelength": "500 nm" },
    "roughness": { "psd": { "model": "uniform", "rms": "20 nm", "f_min": "10 /m", "f_max": "100 /m" } },
    "vary": { "over": { "/roughness/psd/rms": ["20 nm", "30 nm"] } } })");
}
StudyCases cases_of(const ordered_json& study) { return {study.dump(), "s.json"}; }
std::string id_at(const ordered_json& study, const CaseValues& values) {
  const StudyCases cases = cases_of(study);
  return cases.id(cases.at(values));
}

// The test vectors of FIPS 180-4, and a long one by sha256sum.
TEST(ContentHash, IsSha256) {
  EXPECT_EQ(content_hash(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(content_hash("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(content_hash("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  std::string bytes;
  for (int k = 0; k < 3 * 256; ++k) bytes += char(k % 256);
  EXPECT_EQ(content_hash(bytes), "f3a25aa93aa2fbba28d79260535bbd6a5eb0fc1c24a8b0f04e12b484c1dfe363");
}

TEST(StudyCases, AreReadAsTheFileWithTheirValuesWouldBe) {
  const StudyCases cases = cases_of(plain());
  const Study one = cases.at({{"/roughness/psd/rms", "\"30 nm\""}, {"/aperture/diameter", "0.3"}});
  ordered_json same = plain();
  same["roughness"]["psd"]["rms"] = "30 nm", same["aperture"]["diameter"] = 0.3;
  same.erase("vary");
  EXPECT_EQ(resolved_study(one), resolved_study(parse_study(same.dump(), "s.json")));
  // Defaults follow the values; for example, a rectangle has no polar pupil.
  EXPECT_EQ(resolved_study(cases.at(
                {{"/aperture", R"({"shape": "rectangle", "width": 1, "height": 1})"}}))["trace"]["pupil"],
            "sobol");
  EXPECT_THROW(cases.at({{"/roughness/psd/rms", "\"-3 nm\""}}), InputError);
  try {
    cases.at({{"/mirror/focal_length/x", "3"}});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(error.file(), "s.json");
    EXPECT_EQ(error.pointer(), "/vary/over/~1mirror~1focal_length~1x");
  }
}

TEST(StudyCases, HaveANameThatSaysWhatIsComputedAndNothingElse) {
  const CaseValues at = {{"/roughness/psd/rms", "\"30 nm\""}};
  const std::string id = id_at(plain(), at);
  EXPECT_EQ(id.size(), 64u);
  // The bytes that FORMATS names, composed anew.
  ordered_json file = plain();
  file["roughness"]["psd"]["rms"] = "30 nm";
  nlohmann::json sorted = resolved_study(parse_study(file.dump(), "s.json"));
  for (const char* block : {"title", "vary", "verify", "output", "solve"}) sorted.erase(block);
  EXPECT_EQ(id, content_hash("check\n" + sorted.dump()));

  EXPECT_EQ(id_at(plain(), {{"/roughness/psd/rms", "3e-8"}}), id) << "another way to write it";
  ordered_json other = plain();
  other["title"] = "two", other["output"] = {{"pictures", "none"}};
  other["vary"]["over"]["/light/wavelength"] = {"400 nm"};
  EXPECT_EQ(id_at(other, at), id);
  other = {{"vary", plain()["vary"]}, {"light", plain()["light"]}};  // keys in another order
  other.update(plain());
  EXPECT_EQ(id_at(other, at), id);
  EXPECT_NE(id_at(plain(), {{"/roughness/psd/rms", "\"31 nm\""}}), id);
  other = plain();
  other["vary"]["run"] = "trace";
  EXPECT_NE(id_at(other, at), id);
  other = plain();
  other["fit"]["seed"] = 2;
  EXPECT_NE(id_at(other, at), id);
}

TEST(StudyCases, KnowAFileByItsContent) {
  const ScratchFolder here, there;
  const auto id_in = [](const ScratchFolder& folder, const std::string& name, const std::string& table) {
    folder.write(name, table);
    ordered_json study = plain();
    study["roughness"]["psd"] = {{"model", "table"}, {"file", name}};
    study["vary"]["over"] = {{"/light/wavelength", {"500 nm", "600 nm"}}};
    const StudyCases cases(study.dump(), folder.file("s.json"));
    EXPECT_FALSE(cases.base().empty());
    return cases.id(cases.at({{"/light/wavelength", "6e-7"}})) + cases.base();
  };
  const std::string table = "f_per_m,psd_m4\n1,1e-18\n10,1e-19\n100,1e-21\n";
  const std::string id = id_in(here, "a.csv", table);
  EXPECT_EQ(id_in(there, "b.csv", table), id);
  EXPECT_NE(id_in(there, "b.csv", "f_per_m,psd_m4\n1,2e-18\n10,1e-19\n100,1e-21\n"), id);
}

TEST(StudyCases, HaveABaseThatChangesWithAllTheyShare) {
  const std::string base = cases_of(plain()).base();
  ordered_json other = plain();
  other["vary"]["over"]["/roughness/psd/rms"] = {"1 nm"};
  EXPECT_EQ(cases_of(other).base(), base) << "what varies is no part of it";
  other["mirror"]["focal_length"] = "2 m";
  EXPECT_NE(cases_of(other).base(), base);
  other = plain();
  other["vary"]["over"] = {{"/roughness/psd/file", {"a.csv", "b.csv"}}};
  EXPECT_EQ(cases_of(other).base(), "") << "the content of such files is not in the values";
}

TEST(StudyCases, RefuseABlockThatCannotBeMeant) {
  const auto refused = [](const char* pointer, const ordered_json& vary) {
    ordered_json study = plain();
    study["vary"] = vary;
    try {
      cases_of(study);
      ADD_FAILURE() << vary;
    } catch (const InputError& error) {
      EXPECT_EQ(error.pointer(), pointer) << error.what();
    }
  };
  const char* rms = "/vary/over/~1roughness~1psd~1rms";
  const auto over = [](const ordered_json& what) {
    return ordered_json{{"over", {{"/roughness/psd/rms", what}}}};
  };
  refused("/vary/over", ordered_json::object());
  refused("/vary/over", {{"over", ordered_json::object()}});
  refused("/vary/over/rms", {{"over", {{"rms", {1, 2}}}}});
  refused(rms, over(3));
  refused(rms, over(ordered_json::array()));
  refused(rms, over({"1 nm", "1 nm"}));
  refused((rms + std::string("/to")).c_str(), over({{"from", 1}, {"count", 3}}));
  refused((rms + std::string("/count")).c_str(), over({{"from", 1}, {"to", 2}}));
  refused((rms + std::string("/count")).c_str(), over({{"from", 1}, {"to", 2}, {"count", 1}}));
  refused((rms + std::string("/step")).c_str(), over({{"from", 1}, {"to", 2}, {"count", 3}, {"step", 1}}));
  refused((rms + std::string("/spacing")).c_str(),
          over({{"from", 1}, {"to", 2}, {"count", 3}, {"spacing", "even"}}));
  refused("/vary/over/~1title", {{"over", {{"/title", {"a", "b"}}}}});
  refused("/vary/realisations", {{"over", {{"/light/wavelength", {"1 um"}}}}, {"realisations", 3}});
  refused("/vary/over/~1fit~1seed",
          {{"over", {{"/fit/seed", {1, 2}}}}, {"realisations", 3}, {"run", "trace"}});
  ordered_json study = plain();
  study.erase("vary");
  EXPECT_THROW(cases_of(study), InputError);
}

// The resolved study repeats the block.
TEST(StudyCases, TheBlockIsWrittenAsItWasRead) {
  ordered_json study = plain();
  study["vary"] = ordered_json::parse(R"({"over": {"/terms": ["auto", {"zernike": {"n_max": 4}}],
    "/light/wavelength": {"from": "400 nm", "to": "1 um", "count": 3, "spacing": "log"}},
    "design": "grid", "realisations": 4, "run": "fit"})");
  const ordered_json resolved = resolved_study(parse_study(study.dump(), "s.json"));
  EXPECT_EQ(resolved["vary"]["over"], study["vary"]["over"]);
  EXPECT_EQ(resolved["vary"]["run"], "fit");
  EXPECT_EQ(resolved_study(parse_study(resolved.dump(), "s.json")), resolved);
}

}  // namespace
}  // namespace aberfit
