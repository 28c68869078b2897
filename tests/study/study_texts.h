#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

// Studies as text, good and bad, for the tests of the reader, the program and the schema.
namespace aberfit::test {

/// No more than a study must have.
inline const char* const kMinimalStudy = R"({
  "aberfit": 1,
  "mirror": { "focal_length": "2.8 m" },
  "aperture": { "shape": "circle", "diameter": "0.4 m" },
  "light": { "wavelength": "632.8 nm" },
  "roughness": { "psd": { "model": "uniform", "rms": "100 nm", "f_min": "2.5 /m", "f_max": "39.92 /m" } }
})";

/// Every block, with what this version has.
inline const char* const kFullStudy = R"json({
  "aberfit": 1, "title": "every block",
  "mirror": { "focal_length": "2.8 m", "conic": -1, "spherical": { "c4": 1e-9, "c6": 0, "c8": 0, "c10": 0, "c12": 2.5 } },
  "aperture": { "shape": "circle", "diameter": "0.4 m", "margin": "1 mm" },
  "light": { "wavelength": "632.8 nm" },
  "roughness": { "psd": { "model": "uniform", "rms": "100 nm", "f_min": "2.5 /m", "f_max": "39.92 /m" } },
  "target": { "theory": "rays", "convention": "paper",
    "statistics": { "ee50": { "planes": ["0 mm", "-1 mm"] }, "ee97.5": { "tolerance": "0.2 %" },
      "ring_fwhm": { "ring": "ee90" }, "ring_fwhm@ee50": { "tolerance": 0.003 },
      "ring_profile": { "ring": "76 um", "dz": ["-1 mm", 0, "1 mm"], "values": [0.4, "90 %", 0.4], "tolerance": "1 %" },
      "scatter_rms": { "value": "36 urad", "standard_error": "0.1 urad" }, "scatter_mean": {},
      "spot_fwhm": { "bandwidth": "5 um" }, "rms_radius": { "planes": ["2 mm"], "value": "60 um" }, "rms_height": {} } },
  "terms": { "zernike": { "n_min": 1, "n_max": 20 }, "fourier": { "count": 400, "sampling": "grid" },
    "spherical": ["c4", "c6"], "covariance": "diagonal" },
  "trace": { "pupil": "sobol", "rays": 1e4, "seed": 18446744073709551615,
    "normals": { "central_difference": { "step": "1 um" } }, "centre": "centroid" },
  "fit": { "start": "zero", "seed": 7, "prior": "zero-mean", "max_iterations": 50, "starts": 3, "spherical_rms": "2 um",
    "bound_sigmas": 4 },
  "equivalence": { "margin": "1 %", "confidence": 0.9 },
  "output": { "plots": false },
  "verify": { "published_phase": { "psd_level": 1e-20, "modes": 5000, "f_min": "2.5 /m", "f_max": "1 /um" },
    "independent_terms": { "n_max": 8, "rms": "100 nm", "draws": 20 },
    "published": [ { "label": "EE90 (HS)",
                         "quantity" : "harvey_shack.ee90_radius_m",
                         "value" : 76,
                         "unit" : "um",
                         "scale" : 1e-6,
                         "reading" : "reproduced"
},
      { "label": "mean deflection", "formula": "mean_deflection", "value": 1.57e-5,
        "inputs": { "gradient_x": 244.3, "gradient_y": 253.7, "rms": "100 nm", "f_max": "1e6 /m" } } ]
}
})json";

/// kMinimalStudy with the value at `pointer` set to the JSON text `value`; empty text: removed.
inline std::string changed(const std::string& pointer, const std::string& value,
                           const char* base = kMinimalStudy) {
  nlohmann::ordered_json study = nlohmann::ordered_json::parse(base);
  const nlohmann::ordered_json::json_pointer at(pointer);
  if (value.empty())
    study.at(at.parent_pointer()).erase(at.back());
  else
    study[at] = nlohmann::ordered_json::parse(value);
  return study.dump(1);
}

inline std::string with_psd(const std::string& psd) { return changed("/roughness/psd", psd); }

/// A study that the reader has to refuse.
struct MalformedStudy {
  std::string name;
  std::string text;
  std::string pointer;   ///< where the fault is
  std::string fragment;  ///< in the message
  bool against_schema;   ///< whether the shape alone is wrong, so that a schema validator refuses it, too
};

inline std::vector<MalformedStudy> malformed_studies() {
  const std::string uniform = R"({"model": "uniform", "rms": "100 nm", "f_min": "2.5 /m", "f_max": "40 /m")";
  const std::string values_only = R"({
    "aberfit": 1, "mirror": { "focal_length": "2.8 m" }, "aperture": { "shape": "circle", "diameter": "0.4 m" },
    "light": { "wavelength": "632.8 nm" }, "target": { "statistics": { "ee90": { "value": "76 um" } } },
    "terms": { "spherical": ["c4"] }, "fit": { "prior": "zero-mean" } })";
  return {
      // Not JSON, or not quite.
      {"EmptyFile", "", "", "line 1, column 1", false},
      {"CutOff", "{\n  \"aberfit\": 1,\n  \"mirror\": {", "", "line 3, column", false},
      {"TrailingComma", "{\n  \"aberfit\": 1,\n}", "", "line 3, column 1", false},
      {"Comment", "{\n  // mine\n  \"aberfit\": 1 }", "", "line 2, column 3", false},
      {"NanLiteral", "{\n  \"aberfit\": 1,\n  \"light\": { \"wavelength\": NaN } }", "", "line 3, column 28",
       false},
      {"InfinityLiteral", "{ \"aberfit\": 1, \"light\": { \"wavelength\": Infinity } }", "", "line 1", false},
      {"MinusInfinityLiteral", "{ \"aberfit\": 1, \"light\": { \"wavelength\": -Infinity } }", "", "line 1",
       false},
      {"NumberBeyondDouble", "{ \"aberfit\": 1e999 }", "", "line 1", false},
      {"NotUtf8", "{ \"aberfit\": 1, \"title\": \"\xff\" }", "", "line 1, column", false},
      {"TextAfterTheEnd", std::string(kMinimalStudy) + " x", "", "line 7", false},
      {"TooDeep", std::string(100, '['), "/0/0/0", "nesting", false},
      {"ArrayAtTheTop", "[1]", "", "an object", true},
      {"DuplicateKeyAtTheTop", R"({"aberfit": 1, "title": "a", "title": "b"})", "/title", "twice", false},
      {"DuplicateKeyInside", R"({"aberfit": 1, "light": {"wavelength": "1 um", "wavelength": "2 um"}})",
       "/light/wavelength", "\"wavelength\" twice", false},
      {"DuplicateKeyInAList", R"({"aberfit": 1, "verify": {"published": [{}, {"unit": "m", "unit": "mm"}]}})",
       "/verify/published/1/unit", "twice", false},
      // Keys.
      {"WrongVersion", changed("/aberfit", "2"), "/aberfit", "the integer 1", true},
      {"VersionMissing", changed("/aberfit", ""), "/aberfit", "required", true},
      {"MirrorMissing", changed("/mirror", ""), "/mirror", "required", true},
      {"ApertureMissing", changed("/aperture", ""), "/aperture", "required", true},
      {"LightMissing", changed("/light", ""), "/light", "required", true},
      {"FocalLengthMissing", changed("/mirror/focal_length", ""), "/mirror/focal_length", "2.8 m", true},
      {"ShapeMissing", changed("/aperture/shape", ""), "/aperture/shape", "required", true},
      {"RmsMissing", changed("/roughness/psd/rms", ""), "/roughness/psd/rms", "required", true},
      {"MisspeltKey", changed("/mirror/focal_lenght", "1"), "/mirror/focal_lenght",
       "did you mean \"focal_length\"?", true},
      {"MisspeltBlock", changed("/rougness", "{}"), "/rougness", "did you mean \"roughness\"?", true},
      {"KeyWithSlash", changed("/mirror/a~1b~0c", "1"), "/mirror/a~1b~0c", "unknown key \"a/b~c\"", true},
      {"KeyOfAnotherModel", changed("/roughness/psd/B", "\"1 mm\""), "/roughness/psd/B", "unknown key \"B\"",
       true},
      {"KeyOfAnotherShape", changed("/aperture/inner_diameter", "0.1"), "/aperture/inner_diameter",
       "unknown key", true},
      {"UnknownStatistic", changed("/target/statistics/ring_fwmh", "{}"), "/target/statistics/ring_fwmh",
       "did you mean \"ring_fwhm\"?", true},
      {"ExportIsNotThere", changed("/output/export", "[\"zemax-grid-sag\"]"), "/output/export",
       "\"export\" is not part of this version", true},
      {"UnknownKeyInAList", changed("/verify/published", R"([{"label": "a", "value": 1, "vlaue": 2}])"),
       "/verify/published/0/vlaue", "did you mean \"value\"?", true},
      // Types.
      {"MirrorIsNumber", changed("/mirror", "1"), "/mirror", "an object", true},
      {"FocalLengthIsBoolean", changed("/mirror/focal_length", "true"), "/mirror/focal_length", "unit", true},
      {"FocalLengthIsNull", changed("/mirror/focal_length", "null"), "/mirror/focal_length", "unit", true},
      {"ConicIsText", changed("/mirror/conic", "\"-1\""), "/mirror/conic", "a number", true},
      {"TitleIsNumber", changed("/title", "5"), "/title", "a string", true},
      {"PlotsIsText", changed("/output/plots", "\"no\""), "/output/plots", "true or false", true},
      {"PlanesIsText", changed("/target/statistics/ee50/planes", "\"0 mm\""),
       "/target/statistics/ee50/planes", "an array", true},
      {"StatisticIsNumber", changed("/target/statistics/ee50", "0.5"), "/target/statistics/ee50", "an object",
       true},
      {"RaysHalf", changed("/trace/rays", "0.5"), "/trace/rays", "an integer", true},
      {"SeedNegative", changed("/fit/seed", "-1"), "/fit/seed", "an integer from 0", true},
      {"PublishedIsObject", changed("/verify/published", "{}"), "/verify/published", "an array", true},
      // Units.
      {"NoUnit", changed("/light/wavelength", "\"632.8\""), "/light/wavelength", "has no unit", true},
      {"UnknownUnit", changed("/light/wavelength", "\"632.8 nanometres\""), "/light/wavelength", "pm, nm, um",
       false},
      {"AngleForLength", changed("/mirror/focal_length", "\"2.8 arcsec\""), "/mirror/focal_length",
       "\"arcsec\"", false},
      {"RadiansPerMetre", changed("/roughness/psd/f_min", "\"2.5 rad/m\""), "/roughness/psd/f_min",
       "a cycle is 1, not 2 pi", false},
      {"WavelengthInPlainNanometres", changed("/light/wavelength", "632.8"), "/light/wavelength",
       "at most 10 mm", true},
      {"RmsInPlainNanometres", changed("/roughness/psd/rms", "100"), "/roughness/psd/rms", "at most 10 mm",
       true},
      {"MarginInPercentAsText", changed("/equivalence/margin", "\"1\""), "/equivalence/margin", "has no unit",
       true},
      // Ranges.
      {"FocalLengthZero", changed("/mirror/focal_length", "0"), "/mirror/focal_length", "above 0 m", true},
      {"FocalLengthNegative", changed("/mirror/focal_length", "\"-2.8 m\""), "/mirror/focal_length",
       "above 0 m", false},
      {"DiameterZero", changed("/aperture/diameter", "\"0 m\""), "/aperture/diameter", "above 0 m", false},
      {"MarginTooWide", changed("/aperture/margin", "\"0.2 m\""), "/aperture/margin", "less than 200 mm",
       false},
      {"ApertureBeyondTheSag", changed("/mirror/conic", "1000"), "/aperture/diameter", "sag of this mirror",
       false},
      {"InnerDiameterTooLarge",
       changed("/aperture", R"({"shape": "annulus", "diameter": "0.4 m", "inner_diameter": "0.4 m"})"),
       "/aperture/inner_diameter", "less than the outer diameter", false},
      {"TwoVertices",
       changed("/aperture", R"({"shape": "polygon", "vertices": [["0 m", "0 m"], ["1 m", "0 m"]]})"),
       "/aperture/vertices", "at least 3 points", true},
      {"VertexOfThree",
       changed("/aperture", R"({"shape": "polygon", "vertices": [[0, 0], [1, 0, 0], [0, 1]]})"),
       "/aperture/vertices/1", "[x, y]", true},
      {"CrossingPolygon",
       changed("/aperture", R"({"shape": "polygon", "vertices": [[0,0],[1,1],[1,0],[0,1]]})"),
       "/aperture/vertices", "edges 0 and 2 that meet", false},
      {"FlatPolygon", changed("/aperture", R"({"shape": "polygon", "vertices": [[0,0],[1,0],[2,0]]})"),
       "/aperture/vertices", "fold back", false},
      {"PolarRectangle",
       changed(
           "/trace/pupil", "\"polar\"",
           changed("/aperture", R"({"shape": "rectangle", "width": "0.2 m", "height": "0.1 m"})").c_str()),
       "/trace/pupil", "circles and annuli", false},
      {"UnknownShape", changed("/aperture/shape", "\"hexagon\""), "/aperture/shape", "\"polygon\"", true},
      {"BandUpsideDown", changed("/roughness/psd/f_min", "\"40 /m\""), "/roughness/psd/f_max",
       "f_min = 40 /m", false},
      {"BandEmpty", changed("/roughness/psd/f_min", "\"39.92 /m\""), "/roughness/psd/f_max",
       "f_min = 39.92 /m", false},
      {"RmsNegative", changed("/roughness/psd/rms", "\"-100 nm\""), "/roughness/psd/rms", "above 0 m", false},
      {"RaysZero", changed("/trace/rays", "0"), "/trace/rays", "from 1 to 1000000000", true},
      {"TooManyRays", changed("/trace/rays", "1000000001"), "/trace/rays", "from 1 to 1000000000", true},
      {"OrderTooHigh", changed("/terms/zernike/n_max", "301"), "/terms/zernike/n_max", "from 0 to 300", true},
      {"OrdersUpsideDown", changed("/terms/zernike", R"({"n_min": 5, "n_max": 4})"), "/terms/zernike/n_max",
       "n_min = 5", false},
      {"NoTerms", changed("/terms", "{}"), "/terms", "at least one of zernike", false},
      {"NoSpherical", changed("/terms/spherical", "[]"), "/terms", "at least one of zernike", false},
      {"SphericalTwice", changed("/terms/spherical", R"(["c4", "c4"])"), "/terms/spherical/1", "at most once",
       true},
      {"SphericalC5", changed("/terms/spherical", R"(["c5"])"), "/terms/spherical/0", "\"c4\"", true},
      {"AutoTerms", changed("/terms", "\"auto\""), "/terms", "\"auto\" is not part of this version", true},
      {"ConfidenceOne", changed("/equivalence/confidence", "1"), "/equivalence/confidence", "below 100 %",
       true},
      {"ToleranceZero", changed("/target/statistics/ee50/tolerance", "0"),
       "/target/statistics/ee50/tolerance", "above 0 %", true},
      // Choices.
      {"GhsTheory", changed("/target/theory", "\"ghs\""), "/target/theory",
       "\"auto\", \"geometric\", \"rays\"", true},
      {"UnknownConvention", changed("/target/convention", "\"book\""), "/target/convention", "\"paper\"",
       true},
      {"MeasuredRoughness", with_psd(R"({"model": "measured", "file": "a.fits"})"), "/roughness/psd/model",
       "\"table\"", true},
      {"UnknownModel", with_psd(R"({"model": "white"})"), "/roughness/psd/model", "\"k-correlation\"", true},
      {"ModelMissing", with_psd(R"({"rms": "1 nm"})"), "/roughness/psd/model", "required", true},
      {"UnknownNormals", changed("/trace/normals", "\"exact\""), "/trace/normals",
       "\"analytic\" or an object", true},
      {"NormalsWithoutStep", changed("/trace/normals", R"({"central_difference": {}})"),
       "/trace/normals/central_difference/step", "required", true},
      {"UnknownPrior", changed("/fit/prior", "\"flat\""), "/fit/prior", "\"near-start\", \"zero-mean\"",
       true},
      // PSD models.
      {"PowerLawWithBoth",
       with_psd(
           R"({"model": "power-law", "rms": "1 nm", "amplitude": "1 nm^4", "exponent": 3, "f_min": 1, "f_max": 9})"),
       "/roughness/psd/amplitude", "exactly one", false},
      {"PowerLawWithNeither", with_psd(R"({"model": "power-law", "exponent": 3, "f_min": 1, "f_max": 9})"),
       "/roughness/psd/rms", "exactly one", false},
      {"PowerLawWithoutHeightVariance",
       with_psd(R"({"model": "power-law", "rms": "1 nm", "exponent": 1.5, "f_min": 1})"), "/roughness/psd",
       "f_max", false},
      {"PowerLawOfInfiniteHeight",
       with_psd(R"({"model": "power-law", "amplitude": "1 nm^4", "exponent": 1.5, "f_min": 1})"),
       "/roughness/psd", "height variance is infinite", false},
      {"KCorrelationWithoutSlopeVariance",
       with_psd(R"({"model": "k-correlation", "rms": "1 nm", "B": "1 mm", "exponent": 3.5})"),
       "/roughness/psd", "slope variance is infinite", false},
      {"EmptySum", with_psd(R"({"model": "sum", "parts": []})"), "/roughness/psd/parts", "at least 1", true},
      {"BadPartOfASum",
       with_psd(R"({"model": "sum", "parts": [)" + uniform + R"(}, )" + uniform + R"(, "B": 1}]})"),
       "/roughness/psd/parts/1/B", "unknown key", true},
      {"BadBandInASum",
       with_psd(R"({"model": "sum", "parts": [)" + uniform +
                R"(}, {"model": "power-law", "rms": "1 nm", "exponent": 1, "f_min": 1}]})"),
       "/roughness/psd/parts/1", "f_max", false},
      {"TableMissing", with_psd(R"({"model": "table", "file": "no-such-table.csv"})"), "/roughness/psd/file",
       "\"no-such-table.csv\", which is no readable file", false},
      {"TableIsFolder", with_psd(R"({"model": "table", "file": "."})"), "/roughness/psd/file",
       "no readable file", false},
      {"TableThatIsNone", with_psd(R"({"model": "table", "file": "words.csv"})"), "/roughness/psd/file",
       "line 3", false},
      {"TableInWrongUnit", with_psd(R"({"model": "table", "file": "words.csv", "psd_unit": "nm^3"})"),
       "/roughness/psd/psd_unit", "nm^2 mm^2", false},
      {"TableOfWrongKind", with_psd(R"({"model": "table", "file": "words.csv", "kind": "3d"})"),
       "/roughness/psd/kind", "\"2d\", \"1d\"", true},
      {"TableOutsideItsBand", with_psd(R"({"model": "table", "file": "psd.csv", "f_min": "1 /mm"})"),
       "/roughness/psd/file", "band", false},
      // Statistics.
      {"EnergyOfEverything", changed("/target/statistics/ee100", "{}"), "/target/statistics/ee100",
       "unknown key", true},
      {"EnergyOfNothing", changed("/target/statistics/ee0", "{}"), "/target/statistics/ee0", "unknown key",
       true},
      {"EnergySpeltTwice", changed("/target/statistics/ee50.0", "{}"), "/target/statistics/ee50.0",
       "\"ee50\"", true},
      {"PlanesOfScatter", changed("/target/statistics/scatter_rms/planes", "[0]"),
       "/target/statistics/scatter_rms/planes", "unknown key", true},
      {"NoPlanes", changed("/target/statistics/ee50/planes", "[]"), "/target/statistics/ee50/planes",
       "at least one", true},
      {"PlaneTwice", changed("/target/statistics/ee50/planes", R"([0, "0 mm"])"),
       "/target/statistics/ee50/planes/1", "every plane once", false},
      {"ValueForTwoPlanes", changed("/target/statistics/ee50", R"({"planes": [0, 1], "value": "1 um"})"),
       "/target/statistics/ee50/planes", "one plane where value is given", false},
      {"AngleAsRadius", changed("/target/statistics/ee50/value", "\"3 arcsec\""),
       "/target/statistics/ee50/value", "a length", false},
      {"RadiusAsAngle", changed("/target/statistics/scatter_rms/value", "\"3 um\""),
       "/target/statistics/scatter_rms/value", "an angle", false},
      {"ErrorWithoutValue", changed("/target/statistics/ee50/standard_error", "\"1 um\""),
       "/target/statistics/ee50/standard_error", "beside a value", false},
      {"RingOfEverything", changed("/target/statistics/ring_fwhm/ring", "\"ee100\""),
       "/target/statistics/ring_fwhm/ring", "\"ee90\"", true},
      {"RingTwice", changed("/target/statistics", R"({"ring_fwhm": {}, "ring_fwhm@ee90": {}})"),
       "/target/statistics/ring_fwhm@ee90", "\"ring_fwhm\" again", false},
      {"RingInKeyAndValue", changed("/target/statistics/ring_fwhm@ee50", R"({"ring": "ee50"})"),
       "/target/statistics/ring_fwhm@ee50/ring", "unknown key", true},
      {"EmptyProfile", changed("/target/statistics/ring_profile", "{}"),
       "/target/statistics/ring_profile/values", "either file, or dz and values", false},
      {"UnevenProfile", changed("/target/statistics/ring_profile", R"({"dz": [0, 1], "values": [1]})"),
       "/target/statistics/ring_profile/values", "as many as dz", false},
      {"UnsortedProfile", changed("/target/statistics/ring_profile", R"({"dz": [1, 0], "values": [1, 1]})"),
       "/target/statistics/ring_profile/dz/1", "ascending", false},
      {"ProfileAboveOne", changed("/target/statistics/ring_profile", R"({"dz": [0, 1], "values": [1, 1.5]})"),
       "/target/statistics/ring_profile/values/1", "at most 100 %", true},
      {"ProfileFileMissing", changed("/target/statistics/ring_profile", R"({"file": "no.csv"})"),
       "/target/statistics/ring_profile/file", "no readable file", false},
      {"ProfileFileOfWords", changed("/target/statistics/ring_profile", R"({"file": "words.csv"})"),
       "/target/statistics/ring_profile/file", "line 3", false},
      {"ProfileTwice",
       changed("/target/statistics/ring_profile", R"({"file": "a.csv", "dz": [0, 1], "values": [1, 1]})"),
       "/target/statistics/ring_profile/file", "either file", false},
      // Without roughness.
      {"NothingToFit", changed("/roughness", ""), "/roughness", "required", false},
      {"ValueMissing", changed("/target/statistics/scatter_rms", "{}", values_only.c_str()),
       "/target/statistics/scatter_rms/value", "required", false},
      {"NearStartWithoutRoughness", changed("/fit/prior", "", values_only.c_str()), "/fit/prior",
       "\"zero-mean\"", false},
      {"FourierWithoutRoughness", changed("/terms/fourier", "{}", values_only.c_str()), "/terms/fourier",
       "no roughness", false},
      {"DefaultTermsWithoutRoughness", changed("/terms", "", values_only.c_str()), "/terms/zernike/n_max",
       "no roughness", false},
      {"EnergyRingWithoutRoughness",
       changed("/target/statistics/ring_profile", R"({"dz": [0, 1], "values": [1, 1]})", values_only.c_str()),
       "/target/statistics/ring_profile/ring", "a length", false},
      // Published numbers.
      {"UnknownFormula", changed("/verify/published", R"([{"label": "a", "value": 1, "formula": "x"}])"),
       "/verify/published/0/formula", "mean_deflection", false},
      {"LabelEmpty", changed("/verify/published", R"([{"label": "", "value": 1}])"),
       "/verify/published/0/label", "a string with text", true},
      {"ScaleZero", changed("/verify/published", R"([{"label": "a", "value": 1, "scale": 0}])"),
       "/verify/published/0/scale", "other than 0", false},
  };
}

}  // namespace aberfit::test
