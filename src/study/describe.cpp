#include "describe.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "aberfit/core/errors.h"
#include "clear_of.h"
#include "polygon.h"

namespace aberfit::internal {
namespace {

constexpr int kLargestOrder = 300;
constexpr std::int64_t kMostRays = 1000000000;

// This is Noll's index of the last mode with n = 100. Up to there one recurrence keeps 12 digits
// (scene/zernike.h).
constexpr int kLargestNoll = 5151;

void describe_known_zernikes(Visitor& v, Mirror& mirror) {
  bool given = !mirror.zernike.empty();
  v.object({"zernike", "known Zernike terms of the design or of a measurement, part of the nominal mirror"},
           &given, [&](Visitor& z) {
             z.quantity_or({"radius",
                            "radius of the disc on which they are orthonormal [m], at least that of the "
                            "aperture; absent: that of the aperture",
                            kOptional, "\"0.2 m\""},
                           mirror.zernike_radius, 0, kLength, Range::positive());
             std::size_t of = 0;
             z.choice({"of",
                       "whether the heights are of the surface or of the wavefront (twice the surface); both "
                       "are positive where the mirror is too high, towards the incoming light"},
                      of, {"surface", "wavefront"});
             std::map<int, double> heights;
             for (const KnownZernike& term : mirror.zernike) heights[noll_index(term.mode)] += term.height;
             z.numbered_quantities({"noll",
                                    "RMS over the disc [m] by Noll's index, 1 to 5151 (n <= 100), "
                                    "orthonormal; even indices are cosines. Indices 2 and 3 tilt the image "
                                    "away from the nominal focus, which stays the centre of all statistics",
                                    kRequired, R"({"4": "120 nm", "7": "-30 nm"})"},
                                   heights, 1, kLargestNoll, kLength, Range::any());
             if (!z.reading()) return;
             mirror.zernike.clear();
             for (const auto& [index, height] : heights)
               mirror.zernike.push_back({zernike_from_noll(index), of == 1 ? 0.5 * height : height});
           });
}

void describe_mirror(Visitor& v, Mirror& mirror) {
  v.object(
      {"mirror", "the mirror without roughness: a conic, even powers, known Zernikes", kRequired,
       R"({"focal_length": "2.8 m"})"},
      nullptr, [&](Visitor& m) {
        m.quantity({"focal_length", "paraxial focal length [m]", kRequired, "\"2.8 m\""}, mirror.focal_length,
                   kLength, Range::positive());
        m.quantity({"conic", "conic constant: -1 parabola, 0 sphere"}, mirror.conic, kNumber, Range::any());
        m.object({"spherical", "even powers added to the sag: sum of c_2n rho^2n, plain SI numbers"}, nullptr,
                 [&](Visitor& s) {
                   static const char* const kKeys[] = {"c4", "c6", "c8", "c10", "c12"};
                   static const char* const kMeanings[] = {"[m^-3]", "[m^-5]", "[m^-7]", "[m^-9]", "[m^-11]"};
                   for (std::size_t i = 0; i < mirror.spherical.size(); ++i)
                     s.quantity({kKeys[i], kMeanings[i]}, mirror.spherical[i], kNumber, Range::any());
                 });
        describe_known_zernikes(m, mirror);
      });
}

void describe_margin(Visitor& v, double& margin, double limit) {
  v.quantity(
      {"margin", "width along every edge without random, Sobol or grid points [m]", kOptional, "\"1 mm\""},
      margin, kLength, Range::non_negative());
  v.check(margin < limit, "margin", format_quantity(margin, kLength),
          "less than " + format_quantity(limit, kLength));
}

void describe_diameter(Visitor& v, double& diameter) {
  v.quantity({"diameter", "outer diameter [m]", kRequired, "\"0.4 m\""}, diameter, kLength,
             Range::positive());
}

void describe(Visitor& v, CircleAperture& a) {
  describe_diameter(v, a.diameter);
  describe_margin(v, a.margin, a.diameter / 2);
}

void describe(Visitor& v, AnnulusAperture& a) {
  describe_diameter(v, a.diameter);
  v.quantity({"inner_diameter", "diameter of the hole [m]", kRequired, "\"0.1 m\""}, a.inner_diameter,
             kLength, Range::positive());
  v.check(a.inner_diameter < a.diameter, "inner_diameter", format_quantity(a.inner_diameter, kLength),
          "less than the outer diameter, " + format_quantity(a.diameter, kLength));
  describe_margin(v, a.margin, (a.diameter - a.inner_diameter) / 4);
}

void describe(Visitor& v, RectangleAperture& a) {
  v.quantity({"width", "size along x [m]", kRequired, "\"0.3 m\""}, a.width, kLength, Range::positive());
  v.quantity({"height", "size along y [m]", kRequired, "\"0.2 m\""}, a.height, kLength, Range::positive());
  describe_margin(v, a.margin, std::min(a.width, a.height) / 2);
}

void describe_vertices(Visitor& v, Outline& vertices, const char* example) {
  v.points(
      {"vertices", "corners [x, y] [m] in order, clockwise or not; edges must not cross", kRequired, example},
      vertices, 3);
  const std::string problem = v.reading() ? polygon_problem(vertices) : "";
  v.check(problem.empty(), "vertices", problem, "a polygon with an area whose edges do not cross");
}

void describe(Visitor& v, PolygonAperture& a) {
  describe_vertices(v, a.vertices, R"([["-0.1 m", "-0.1 m"], ["0.1 m", "-0.1 m"], ["0 m", "0.15 m"]])");
  describe_margin(v, a.margin, std::numeric_limits<double>::infinity());
}

struct Hexagons {
  int rings = 1;
  double flat_to_flat = 0, gap = 0, angle = 0;
  bool centre = false;
};

void describe(Visitor& v, Hexagons& h) {
  v.integer({"rings", "rings of hexagons about the axis", kRequired, "3"}, h.rings, 1, 30);
  v.quantity({"flat_to_flat", "flat-to-flat width of a hexagon [m]", kRequired, "\"1.3 m\""}, h.flat_to_flat,
             kLength, Range::positive());
  v.quantity({"gap", "width of the gap between two hexagons [m]", kOptional, "\"3 mm\""}, h.gap, kLength,
             Range::non_negative());
  v.boolean({"centre", "whether there is a hexagon on the axis"}, h.centre);
  v.quantity({"angle", "angle of a corner from the x axis [rad]", kOptional, "\"30 deg\""}, h.angle, kAngle,
             Range::any());
}

void describe(Visitor& v, SegmentedAperture& a) {
  std::optional<Hexagons> hexagons;
  v.optional_object({"hexagons", "hexagons in rings; instead of polygons"}, hexagons, describe);
  std::vector<Outline> polygons = v.reading() ? std::vector<Outline>{} : a.outlines;
  v.list(
      {"polygons", "outline of each segment; instead of hexagons"}, polygons.size(), 0,
      [&](std::size_t count) { polygons.resize(count); },
      [&](Visitor& one, std::size_t i) { describe_vertices(one, polygons[i], nullptr); });
  describe_margin(v, a.margin, std::numeric_limits<double>::infinity());
  v.quantity({"piston",
              "standard deviation of the height of each segment [m]; it is part of the target, and in a fit "
              "each segment has it as a term",
              kOptional, "\"30 nm\""},
             a.piston, kLength, Range::non_negative());
  v.quantity({"tip_tilt", "standard deviation of the slope of each segment along x and along y [rad]",
              kOptional, "\"20 nrad\""},
             a.tip_tilt, kAngle, Range::non_negative());
  if (!v.reading()) return;
  v.check(hexagons.has_value() == polygons.empty(), hexagons ? "polygons" : "hexagons",
          hexagons ? "polygons beside hexagons" : "neither hexagons nor polygons",
          "one of hexagons and polygons");
  a.outlines = counter_clockwise(polygons);
  if (hexagons)
    a.outlines = hexagonal_segments(hexagons->rings, hexagons->flat_to_flat, hexagons->gap, hexagons->centre,
                                    hexagons->angle)
                     .outlines;
  else
    v.check(!overlap(a.outlines), "polygons", "polygons that overlap", "segments side by side");
}

void describe(Visitor& v, Vane& vane) {
  v.quantity({"width", "width of the vane [m]", kRequired, "\"25 mm\""}, vane.width, kLength,
             Range::positive());
  v.quantity(
      {"angle", "direction of the vane from the axis, from x towards y [rad]", kRequired, "\"45 deg\""},
      vane.angle, kAngle, Range::any());
  v.quantity({"offset", "offset of its centre line from the axis, to the left [m]", kOptional, "\"10 mm\""},
             vane.offset, kLength, Range::any());
}

void describe(Visitor& v, MaskFile& mask) {
  v.text({"file",
          "FITS (row 0 at the lowest y) or text image (first line is the top row), relative to the study. A "
          "value from 0 to 1 is the clear fraction of a pixel, which is clear above one half. The middle is "
          "on the axis",
          kRequired, "\"pupil.fits\""},
         mask.file, false);
  v.quantity({"pitch", "pitch of its pixels [m]", kRequired, "\"5 mm\""}, mask.pitch, kLength,
             Range::positive());
  describe_margin(v, mask.margin, std::numeric_limits<double>::infinity());
}

// The schema visitor goes through all shapes, so we keep only what a reader sets.
void describe_aperture(Visitor& v, Study& study) {
  ApertureSpec spec;
  if (study.obstructed)
    spec = *study.obstructed;
  else
    std::visit([&](const auto& shape) { spec.shape = shape; }, study.aperture);
  v.object({"aperture", "clear aperture, centred on the axis unless a polygon says otherwise", kRequired,
            R"({"shape": "circle", "diameter": "0.4 m"})"},
           nullptr, [&](Visitor& a) {
             a.kind({"shape", "shape of the outline; the keys beside it belong to the shape", kRequired},
                    spec.shape,
                    {{"circle", CircleAperture{}},
                     {"annulus", AnnulusAperture{}},
                     {"rectangle", RectangleAperture{}},
                     {"polygon", PolygonAperture{}},
                     {"segments", SegmentedAperture{}},
                     {"mask", MaskFile{}}});
             std::visit([&](auto& held) { describe(a, held); }, spec.shape);
             a.list(
                 {"spiders", "vanes from the axis outwards, which cover a part of any shape"},
                 spec.spiders.size(), 0, [&](std::size_t count) { spec.spiders.resize(count); },
                 [&](Visitor& vane, std::size_t k) { describe(vane, spec.spiders[k]); });
           });
  if (!v.reading()) return;
  study.obstructed.reset();
  const bool is_file = std::holds_alternative<MaskFile>(spec.shape);
  if (is_file || !spec.spiders.empty()) study.obstructed = spec;
  const std::optional<Aperture> clear = is_file ? SegmentedAperture{} : clear_of(spec, {});
  v.check(clear.has_value(), "aperture", "spiders that cover the aperture",
          "vanes that leave a part of it clear");
  study.aperture = clear.value_or(SegmentedAperture{});
}

// A wavelength in nanometres written as a plain number would pass any looser check.
const Range kWavelengths{1e-12, 1e-2};

struct Band {
  std::optional<double> from, to;
  std::optional<int> count;
  std::vector<LightLine> lines;
};

void describe(Visitor& v, Band& band) {
  v.quantity({"from", "shortest wavelength [m]", kOptional, "\"500 nm\""}, band.from, kLength, kWavelengths);
  v.quantity({"to", "longest wavelength [m]", kOptional, "\"600 nm\""}, band.to, kLength, kWavelengths);
  v.integer({"count",
             "number of wavelengths of equal weight, in the middles of as many parts of the band; absent: 5",
             kOptional, "5"},
            band.count, 2, 100);
  v.list(
      {"lines", "wavelengths and their shares, instead of from, to and count"}, band.lines.size(), 0,
      [&](std::size_t count) {
        band.lines.resize(count, {0, 1});
      },
      [&](Visitor& line, std::size_t k) {
        line.quantity({"wavelength", "[m]", kRequired, "\"550 nm\""}, band.lines[k].wavelength, kLength,
                      kWavelengths);
        line.quantity({"share", "relative energy of the line; shares are divided by their sum"},
                      band.lines[k].share, kNumber, Range::positive());
      });
  const bool by_ends = band.from && band.to;
  v.check(by_ends == band.lines.empty(), by_ends ? "lines" : "from",
          by_ends ? "lines beside from and to" : "neither from and to nor lines", "from and to, or lines");
  v.check(!by_ends || *band.from < *band.to, "to", by_ends ? format_quantity(*band.to, kLength) : "",
          "a wavelength above from");
}

void describe_light(Visitor& v, Light& light) {
  v.object({"light", "collimated light along the axis, of one wavelength or of a band", kRequired,
            R"({"wavelength": "632.8 nm"})"},
           nullptr, [&](Visitor& l) {
             std::optional<double> wavelength;
             std::optional<Band> band;
             if (!l.reading() && light.is_band()) band = Band{{}, {}, {}, light.lines()};
             if (!l.reading() && !light.is_band() && light > 0) wavelength = double(light);
             l.quantity({"wavelength", "wavelength [m]; this or band", kOptional, "\"632.8 nm\""}, wavelength,
                        kLength, kWavelengths);
             l.optional_object({"band", "a filter; the irradiances of its wavelengths add"}, band, describe);
             if (!l.reading()) return;
             l.check(wavelength.has_value() != band.has_value(), wavelength ? "band" : "wavelength",
                     wavelength ? "a band beside wavelength" : kMissing,
                     wavelength ? "a wavelength, or a band"
                                : "light needs \"wavelength\": \"632.8 nm\", or a \"band\"");
             if (wavelength) light = *wavelength;
             if (band && band->from && band->to)
               light = band_of_light(*band->from, *band->to, band->count.value_or(5));
             if (band && !band->lines.empty()) light = Light(band->lines);
           });
}

void describe_band(Visitor& t, BandSpec& band) {
  std::variant<std::string, double> value = std::string();  // absent
  if (band.rule == BandRule::kCut)
    value = band.cut;
  else if (band.rule != BandRule::kDefault || !t.reading())
    value = std::string(band.rule == BandRule::kAuto ? "auto" : "all");
  const std::variant<std::string, double> before = value;
  t.word_or_quantity({"band",
                      "frequency where terms end and scatter begins [cycles/m]; higher frequencies enter as "
                      "their mean, a scatter function. all: terms carry every frequency. auto: the lowest "
                      "cut above which single mirrors do not differ noticeably from their mean. Absent: auto "
                      "if terms is auto and the theory is not geometric, else all",
                      kOptional, "\"6 /m\"", "Or \"auto\", or \"all\"."},
                     value, "auto|all", kFrequency, Range::positive());
  if (value == before) return;
  if (const auto* cut = std::get_if<double>(&value))
    band = {BandRule::kCut, *cut};
  else
    band = {std::get<std::string>(value) == "auto" ? BandRule::kAuto : BandRule::kAll, 0};
}

void describe_terms(Visitor& v, TermsSpec& terms) {
  const bool named = !terms.automatic();
  bool given = named || terms.band.rule == BandRule::kCut || terms.band.rule == BandRule::kAll;
  std::size_t rule = terms.fewest;
  v.word_or_object(
      {"terms",
       "aberration terms to fit; auto: those that carry the roughness up to where single mirrors no longer "
       "differ from their mean; fewest: the smallest equivalent set, whatever its PSD"},
      given, {"auto", "fewest"}, rule, [&](Visitor& t) {
        bool zernike = terms.zernike.has_value();
        t.object({"zernike", "all Zernike modes n_min <= n <= n_max"}, &zernike, [&](Visitor& z) {
          if (!terms.zernike) terms.zernike.emplace();
          z.integer({"n_min", "lowest radial order"}, terms.zernike->n_min, 0, kLargestOrder);
          std::optional<int>& n_max = terms.zernike->n_max;
          z.integer(
              {"n_max", "highest radial order; absent: 1.1 x 2 pi R f, which carries the band, at most 100",
               kOptional, "20"},
              n_max, 0, kLargestOrder);
          z.check(!n_max || *n_max >= terms.zernike->n_min, "n_max", fmt::format("{}", n_max.value_or(0)),
                  fmt::format("an integer from n_min = {} to {}", terms.zernike->n_min, kLargestOrder));
        });
        t.optional_object(
            {"fourier", "plane waves that sample the band of the PSD"}, terms.fourier,
            [](Visitor& f, FourierSpec& fourier) {
              f.integer(
                  {"count", "number of plane waves on log-uniform rings; absent: 400", kOptional, "400"},
                  fourier.count, 1, 1000000);
              f.choice_of({"sampling",
                           "log: `count` waves on log-uniform rings; grid: every point of the frequency grid "
                           "of pitch 1/diameter in the band, each with the variance of its grid square"},
                          fourier.sampling, {"log", "grid"});
              f.check(fourier.sampling == FourierSampling::kLog || !fourier.count, "count",
                      fmt::format("a count of {} with a grid", fourier.count.value_or(0)),
                      "no count, because band and aperture determine the points of the grid; or sampling "
                      "\"log\"");
            });
        std::vector<std::size_t> powers;
        for (const int power : terms.spherical) powers.push_back(std::size_t(power / 2 - 2));
        t.choices({"spherical", "even powers of rho", kOptional, R"(["c4", "c6"])"}, powers,
                  {"c4", "c6", "c8", "c10", "c12"});
        t.choice_of(
            {"covariance", "prior of the Zernikes: the PSD's full covariance, or its diagonal (the paper's)"},
            terms.covariance, {"full", "diagonal"});
        describe_band(t, terms.band);
        terms.spherical.clear();
        for (const std::size_t power : powers) terms.spherical.push_back(int(2 * power + 4));
        t.check(terms.zernike || terms.fourier || !terms.spherical.empty() ||
                    terms.band.rule != BandRule::kDefault,
                "", "no terms", "at least one of zernike, fourier, spherical and band; or \"auto\"");
      });
  terms.fewest = rule == 1;
}

void describe_trace(Visitor& v, TraceSpec& trace, const Aperture& aperture) {
  v.object({"trace", "how the surface is propagated to the focus"}, nullptr, [&](Visitor& t) {
    t.choice_or_auto({"model",
                      "how statistics are computed from the surface: rays, or waves (diffraction of the "
                      "pupil on a sufficiently fine grid); auto: as the theory needs"},
                     trace.model, {FocusModel::kRays, FocusModel::kWaves});
    PupilLayout layout = layout_of(aperture, trace.pupil);
    t.choice_of(
        {"pupil", "layout of the rays; absent: polar, or sobol where the aperture is no circle or annulus"},
        layout, {"polar", "random", "sobol", "grid"});
    if (layout != usual_layout(aperture)) trace.pupil.layout = layout;
    bool automatic_rays = !trace.pupil.rays;
    std::int64_t rays = rays_of(trace.pupil);
    t.word_or_integer({"rays",
                       "requested number of rays; auto: a fit takes as many as its sampling error needs, "
                       "everything else 65536",
                       kOptional, "16384"},
                      automatic_rays, "auto", rays, 1, kMostRays);
    if (t.reading() && !automatic_rays) trace.pupil.rays = rays;
    t.seed({"seed", "seed of random and Sobol pupils"}, trace.pupil.seed);
    bool differences = trace.central_difference_step.has_value();
    std::size_t analytic = 0;
    t.word_or_object(
        {"normals", "surface normals: analytic, or by central differences with a step"}, differences,
        {"analytic"}, analytic, [&](Visitor& n) {
          n.object(
              {"central_difference", "central differences of the height", kRequired, R"({"step": "1 um"})"},
              nullptr, [&](Visitor& c) {
                double step = trace.central_difference_step.value_or(0);
                c.quantity({"step", "step [m]", kRequired, "\"1 um\""}, step, kLength, Range::positive());
                trace.central_difference_step = step;
              });
        });
    if (!differences) trace.central_difference_step.reset();
    t.choice_of({"centre", "centre of the statistics: nominal focus or centroid"}, trace.centre,
                {"nominal", "centroid"});
  });
}

void describe_fit(Visitor& v, FitSpec& fit) {
  v.object({"fit", "how the terms are fitted"}, nullptr, [&](Visitor& f) {
    f.choice_of({"start", "start of the fit: a random realisation of the prior, or zero"}, fit.start,
                {"draw", "zero"});
    f.seed({"seed", "seed of the realisation"}, fit.seed);
    f.choice_of({"prior",
                 "near-start keeps the surface near the random start, with its roughness character; "
                 "zero-mean suits few or low-order terms"},
                fit.prior, {"near-start", "zero-mean"});
    f.integer({"max_iterations", "largest number of iterations"}, fit.max_iterations, 1, 1000000);
    f.integer({"starts",
               "number of random starts, tried in turn until one is equivalent; else the nearest is kept"},
              fit.starts, 1, 10000);
    f.quantity(
        {"spherical_rms",
         "prior RMS height of the spherical terms [m]; absent: by waves that of the roughness, else 1 um",
         kOptional, "\"25 nm\""},
        fit.spherical_rms, kLength, Range::positive());
    f.quantity({"bound_sigmas", "limit of coefficients in prior standard deviations; 0: no limit"},
               fit.bound_sigmas, kNumber, Range::non_negative());
  });
}

}  // namespace

void describe_study(Visitor& v, Study& study) {
  std::int64_t version = 1;
  v.integer({"aberfit", "version of the study format", kRequired, "1"}, version, 1, 1);
  v.text({"$schema", "file where an editor finds the schema of this format, as printed by `aberfit schema`",
          kOptional, "\"./aberfit.schema.json\""},
         study.schema, true);
  v.text({"title", "title of the study, one line", kOptional, "\"0.4 m f/7 paraboloid\""}, study.title, true);
  v.text({"description", "purpose of the study and source of its numbers; copied to the result"},
         study.description, true);
  describe_mirror(v, study.mirror);
  describe_aperture(v, study);
  describe_light(v, study.wavelength);
  describe_roughness(v, study.roughness);
  describe_target(v, study.target, study.map, study.mirror.focal_length);
  describe_terms(v, study.terms);
  describe_trace(v, study.trace, study.aperture);
  describe_fit(v, study.fit);
  v.object({"equivalence", "margins of the verdict, by two one-sided tests"}, nullptr, [&](Visitor& e) {
    e.quantity({"margin", "largest relative difference that counts as equivalent", kOptional, "\"1 %\""},
               study.equivalence.margin, kFraction, Range{0, 1, true, true});
    e.quantity({"stray_light",
                "largest relative difference that counts as equivalent in 1 - E, the energy outside the "
                "radius of an encircled energy; absent: only the margin applies",
                kOptional, "\"5 %\""},
               study.equivalence.stray_light, kFraction, Range{0, 1, true, true});
    e.quantity({"confidence", "confidence of each one-sided test"}, study.equivalence.confidence, kFraction,
               Range{0.5, 1, true, true});
  });
  v.object({"output", "files that are written besides the result"}, nullptr, [&](Visitor& o) {
    o.choice_of(
        {"pictures",
         "file format of pictures: SVG, PNG or PDF; auto: SVG for curves, PNG for maps; none: no pictures"},
        study.output.pictures, picture_format_names());
    std::vector<std::size_t> exports;
    for (const ExportFormat format : study.output.exports) exports.push_back(std::size_t(format));
    o.choices({"export", "the fitted surface for other programs", kOptional,
               R"(["zemax-grid-sag", "zernike-noll"])"},
              exports, export_names());
    study.output.exports.clear();
    for (const std::size_t format : exports) study.output.exports.push_back(ExportFormat(format));
    o.integer({"export_grid", "number of points per side of exported maps"}, study.output.export_grid, 5,
              8193);
    o.choice_of({"arrays",
                 "format of curves, PSF and OTF as numbers: arrays.npz, CSV tables, or psf.fits and "
                 "otf.fits; for `fit`, `trace` and `check`"},
                study.output.arrays, array_format_names());
  });
  v.object({"verify", "how `aberfit verify` compares"}, nullptr, [&](Visitor& w) {
    w.integer({"draws",
               "number of random surfaces for the ensemble means, a multiple of 16; absent: as many as the "
               "margin needs",
               kOptional, "256"},
              study.verify_draws, 2, 1000000);
  });
  v.optional_object({"solve", "which roughness meets a budget, for `aberfit solve`"}, study.solve,
                    describe_solve);
  v.optional_object({"vary", "studies that differ from this one in a few values, for `aberfit sweep`"},
                    study.vary, describe_vary);
}

}  // namespace aberfit::internal
