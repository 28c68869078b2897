#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string_view>

#include "aberfit/core/errors.h"
#include "aberfit/report/result.h"
#include "aberfit/scene/zernike.h"
#include "listing_lines.h"

namespace aberfit {
namespace {

constexpr std::string_view kColumnNames = "kind,n,m,noll,fx_per_m,fy_per_m,value_m,std_m";
constexpr std::string_view kRadiusKey = "# radius_m = ";
// If another machine sampled the same set, its frequencies may differ in the last bits of sine and logarithm.
constexpr double kFrequencyMatch = 1e-9;

constexpr std::string_view kFileHeader =
    "# aberfit aberration coefficients, version 1\n"
    "# Heights of the surface (not of the wavefront) in metres, positive towards the incoming light.\n"
    "# zernike: Z_n^m orthonormal on the disc of radius radius_m (unit RMS), m > 0 cosine, m < 0 sine; "
    "Noll's index counts from 1.\n"
    "# cos, sin: amplitudes of cos and sin of 2 pi (fx x + fy y), frequencies in cycles per metre.\n"
    "# spherical: value_m (rho / radius_m)^n, the height at the rim. std_m: standard deviation, empty where "
    "unknown.\n"
    "# piston, slope_x, slope_y: of segment n of the aperture, from 1; slopes times the radius of the "
    "segment, "
    "about the centre of its area.\n";

// Fewest digits that read back to the same double.
std::string shortest(double value) { return fmt::format("{}", value); }

std::string deviation(const Eigen::VectorXd& std, Eigen::Index i) {
  return i < std.size() && std::isfinite(std[i]) ? shortest(std[i]) : "";
}

constexpr std::array<std::string_view, 3> kSegmentErrors{"piston", "slope_x", "slope_y"};

// One row of the file before its term is found in a set.
struct Row {
  enum class Kind { kZernike, kCos, kSin, kSpherical, kSegment } kind = Kind::kZernike;
  ZernikeMode mode;       // zernike
  FourierMode wave;       // cos, sin
  int power = 0;          // spherical
  int segment = 0;        // from 1
  std::size_t error = 0;  // in kSegmentErrors
  double value = 0;       // [m]
  int line = 0;
};

// The row of the current line.
Row row_of(const internal::ListingLines& file) {
  const std::string_view text = file.text();
  std::array<std::string_view, 8> cell;
  std::size_t count = 0, begin = 0;
  for (;; ++count) {
    const std::size_t comma = text.find(',', begin);
    if (count < cell.size()) cell[count] = trimmed(text.substr(begin, comma - begin));
    if (comma == std::string_view::npos) break;
    begin = comma + 1;
  }
  if (count + 1 != cell.size()) file.fail(text, "8 columns: " + std::string(kColumnNames));

  Row row;
  row.line = int(file.line());
  if (cell[0] == "zernike") {
    row.mode = {file.integer(cell[1], "n"), file.integer(cell[2], "m")};
    constexpr int kLargestOrder = 300;  // limit of a study
    if (row.mode.n > kLargestOrder) file.fail(cell[1], fmt::format("n from 0 to {}", kLargestOrder));
    if (!is_zernike_mode(row.mode)) file.fail(text, "n >= |m| with n - |m| even");
    // The index is for people. If given it must agree; otherwise the file was renumbered in another scheme.
    if (!cell[3].empty() && file.integer(cell[3], "noll") != noll_index(row.mode))
      file.fail(cell[3], "Noll's index of this (n, m), " + std::to_string(noll_index(row.mode)));
  } else if (cell[0] == "cos" || cell[0] == "sin") {
    row.kind = cell[0] == "cos" ? Row::Kind::kCos : Row::Kind::kSin;
    row.wave = {file.number(cell[4], "fx_per_m"), file.number(cell[5], "fy_per_m")};
  } else if (cell[0] == "spherical") {
    row.kind = Row::Kind::kSpherical;
    row.power = file.integer(cell[1], "n");
    if (row.power < 4 || row.power > 12 || row.power % 2 != 0) file.fail(cell[1], "n of 4, 6, 8, 10 or 12");
  } else {
    const auto error = std::find(kSegmentErrors.begin(), kSegmentErrors.end(), cell[0]);
    if (error == kSegmentErrors.end())
      file.fail(cell[0], "zernike, cos, sin, spherical, piston, slope_x or slope_y");
    row.kind = Row::Kind::kSegment;
    row.error = std::size_t(error - kSegmentErrors.begin());
    row.segment = file.integer(cell[1], "n");
  }
  row.value = file.number(cell[6], "value_m");
  if (!cell[7].empty()) file.number(cell[7], "std_m");
  return row;
}

// All rows of a file, and its normalisation radius [m].
std::vector<Row> read_rows(const std::string& path, double* radius) {
  internal::ListingLines file(path);
  std::vector<Row> rows;
  std::optional<double> found_radius;
  bool columns = false;
  while (file.next()) {
    const std::string_view text = file.text();
    if (text.starts_with(kRadiusKey.substr(0, kRadiusKey.find('=')))) {
      found_radius = file.number(trimmed(text.substr(text.find('=') + 1)), "a radius [m]");
      if (!(*found_radius > 0)) file.fail(text, "a radius above 0");
    } else if (text.front() == '#') {
      continue;
    } else if (!columns) {
      if (text != kColumnNames) file.fail(text, "the columns " + std::string(kColumnNames));
      columns = true;
    } else {
      rows.push_back(row_of(file));
    }
  }
  if (!columns) file.fail_whole("no line of column names", std::string(kColumnNames));
  if (!found_radius) file.fail_whole("no radius", "a line \"" + std::string(kRadiusKey) + "...\"");
  *radius = *found_radius;
  return rows;
}

// Index in kSegmentErrors of the k-th term of a segment.
std::size_t error_of(const TermSet& terms, Eigen::Index k) {
  return std::size_t(k) + (terms.segments->piston() > 0 ? 0 : 1);
}

// Position of each term of a set in the coefficient vector.
class Places {
 public:
  explicit Places(const TermSet& terms) {
    for (std::size_t i = 0; i < terms.zernike.size(); ++i)
      zernike_[{terms.zernike[i].n, terms.zernike[i].m}] = Eigen::Index(i);
    for (std::size_t i = 0; i < terms.fourier.size(); ++i)
      fourier_.emplace(terms.fourier[i].fx,
                       Wave{terms.fourier[i].fy, terms.fourier_begin() + 2 * Eigen::Index(i)});
    for (std::size_t i = 0; i < terms.spherical.size(); ++i)
      spherical_[terms.spherical[i]] = terms.spherical_begin() + Eigen::Index(i);
    for (Eigen::Index k = 0; k < terms.size() - terms.segments_begin(); ++k)
      segments_[{int(k / terms.of_a_segment()) + 1, error_of(terms, k % terms.of_a_segment())}] =
          terms.segments_begin() + k;
  }

  std::optional<Eigen::Index> of(const Row& row) const {
    if (row.kind == Row::Kind::kZernike) return lookup(zernike_, std::pair(row.mode.n, row.mode.m));
    if (row.kind == Row::Kind::kSpherical) return lookup(spherical_, row.power);
    if (row.kind == Row::Kind::kSegment) return lookup(segments_, std::pair(row.segment, row.error));
    const auto cosine = wave(row.wave);
    return cosine && row.kind == Row::Kind::kSin ? std::optional(*cosine + 1) : cosine;
  }

  std::optional<Eigen::Index> wave(const FourierMode& mode) const {
    const double reach = kFrequencyMatch * std::hypot(mode.fx, mode.fy);
    for (auto it = fourier_.lower_bound(mode.fx - reach);
         it != fourier_.end() && it->first <= mode.fx + reach; ++it)
      if (std::abs(it->second.fy - mode.fy) <= reach) return it->second.index;
    return std::nullopt;
  }

 private:
  struct Wave {
    double fy;
    Eigen::Index index;
  };
  template <typename Map>
  static std::optional<Eigen::Index> lookup(const Map& map, const typename Map::key_type& key) {
    const auto it = map.find(key);
    return it == map.end() ? std::nullopt : std::optional(it->second);
  }

  std::map<std::pair<int, int>, Eigen::Index> zernike_;
  std::multimap<double, Wave> fourier_;  // by fx
  std::map<int, Eigen::Index> spherical_;
  std::map<std::pair<int, std::size_t>, Eigen::Index> segments_;
};

// The terms of a file in its order, each once. A sine or cosine alone is enough to add its wave.
TermSet terms_of(const std::vector<Row>& rows, double radius) {
  TermSet terms;
  terms.radius = radius;
  std::set<std::pair<int, int>> modes;
  std::set<std::pair<double, double>> waves;
  std::set<int> powers;
  for (const Row& row : rows) {
    if (row.kind == Row::Kind::kZernike) {
      if (modes.emplace(row.mode.n, row.mode.m).second) terms.zernike.push_back(row.mode);
    } else if (row.kind == Row::Kind::kSpherical) {
      if (powers.insert(row.power).second) terms.spherical.push_back(row.power);
    } else if (row.kind != Row::Kind::kSegment && waves.emplace(row.wave.fx, row.wave.fy).second) {
      terms.fourier.push_back(row.wave);
    }
  }
  return terms;
}

std::string describe(const Row& row) {
  if (row.kind == Row::Kind::kZernike) return fmt::format("zernike n = {}, m = {}", row.mode.n, row.mode.m);
  if (row.kind == Row::Kind::kSpherical) return fmt::format("spherical n = {}", row.power);
  if (row.kind == Row::Kind::kSegment)
    return fmt::format("{} of segment {}", kSegmentErrors[row.error], row.segment);
  return fmt::format("{} wave fx = {} /m, fy = {} /m", row.kind == Row::Kind::kCos ? "cosine" : "sine",
                     row.wave.fx, row.wave.fy);
}

}  // namespace

std::string coefficients_csv(const TermSet& terms, const Eigen::VectorXd& coefficients,
                             const Eigen::VectorXd& std) {
  assert(coefficients.size() == terms.size());
  std::string text(kFileHeader);
  text += fmt::format("{}{}\n{}\n", kRadiusKey, shortest(terms.radius), kColumnNames);
  Eigen::Index i = 0;
  const auto value = [&] {
    std::string cells = shortest(coefficients[i]) + "," + deviation(std, i);
    ++i;
    return cells;
  };
  for (const ZernikeMode& mode : terms.zernike)
    text += fmt::format("zernike,{},{},{},,,{}\n", mode.n, mode.m, noll_index(mode), value());
  for (const FourierMode& mode : terms.fourier)
    for (const char* kind : {"cos", "sin"})
      text += fmt::format("{},,,,{},{},{}\n", kind, shortest(mode.fx), shortest(mode.fy), value());
  for (const int power : terms.spherical) text += fmt::format("spherical,{},,,,,{}\n", power, value());
  for (Eigen::Index k = 0; k < terms.size() - terms.segments_begin(); ++k)
    text += fmt::format("{},{},,,,,{}\n", kSegmentErrors[error_of(terms, k % terms.of_a_segment())],
                        k / terms.of_a_segment() + 1, value());
  return text;
}

Eigen::VectorXd read_coefficients_csv(const std::string& path, TermSet* terms) {
  double radius = 0;
  const std::vector<Row> rows = read_rows(path, &radius);
  const auto fail = [&](const Row& row, const std::string& allowed) {
    throw InputError(path, "line " + std::to_string(row.line), describe(row), allowed);
  };
  if (terms->segments_begin() == 0) {
    const std::shared_ptr<const Segments> segments = terms->segments;
    *terms = terms_of(rows, radius);
    terms->segments = segments;
  } else if (std::abs(radius - terms->radius) > 1e-12 * radius &&
             (!terms->zernike.empty() || !terms->spherical.empty())) {
    throw InputError(path, "", fmt::format("radius_m = {}", radius),
                     fmt::format("the normalisation radius of the terms, {}", terms->radius));
  }

  const Places places(*terms);
  Eigen::VectorXd coefficients = Eigen::VectorXd::Zero(terms->size());
  std::vector<int> line_of(std::size_t(terms->size()), 0);
  for (const Row& row : rows) {
    const std::optional<Eigen::Index> place = places.of(row);
    if (!place)
      fail(row, row.kind == Row::Kind::kSegment
                    ? "segments of the study's aperture, with its `piston` and `tip_tilt`"
                    : "terms of the study's set");
    int& line = line_of[std::size_t(*place)];
    if (line != 0)
      fail(row, "each term once; this one is already on line " + std::to_string(line) + " already");
    line = row.line;
    coefficients[*place] = row.value;
  }
  return coefficients;
}

}  // namespace aberfit
