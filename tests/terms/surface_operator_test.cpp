#include "aberfit/terms/surface_operator.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "../../src/terms/fourier_kernel.h"
#include "../../src/terms/zernike_kernel.h"
#include "aberfit/core/random.h"
#include "aberfit/scene/zernike.h"

using namespace aberfit;
using namespace aberfit::internal;

namespace {

constexpr double kRadius = 0.2;

/// Points uniform over a disc slightly larger than the normalisation radius, the vertex first.
struct Pupil {
  Eigen::ArrayXd x, y;
};
Pupil pupil(int count, const char* name, double radius = 1.01 * kRadius) {
  const RandomStream stream(1, name);
  Pupil points{Eigen::ArrayXd::Zero(count), Eigen::ArrayXd::Zero(count)};
  for (int i = 1; i < count; ++i) {
    const auto [u, v] = stream.uniform_pair(std::uint64_t(i));
    const double r = radius * std::sqrt(u), angle = 2 * std::numbers::pi * v;
    points.x[i] = r * std::cos(angle);
    points.y[i] = r * std::sin(angle);
  }
  return points;
}

Eigen::ArrayXd normals(Eigen::Index count, const char* name) {
  const RandomStream stream(2, name);
  Eigen::ArrayXd values(count);
  for (Eigen::Index i = 0; i < count; ++i) values[i] = stream.normal(std::uint64_t(i));
  return values;
}

SurfaceField random_field(Eigen::Index count, const char* name) {
  const Eigen::ArrayXd all = normals(3 * count, name);
  return {all.head(count), all.segment(count, count), all.tail(count)};
}

TermSet mixed_terms(int n_min, int n_max) {
  TermSet terms;
  terms.radius = kRadius;
  terms.zernike = zernike_modes(n_min, n_max);
  for (int i = 0; i < 37; ++i) terms.fourier.push_back({30 * std::cos(2.4 * i), 1.3 * i * std::sin(2.4 * i)});
  terms.spherical = {4, 6, 8, 10, 12};
  return terms;
}

/// The reference: one mode at a time, with Fourier and spherical terms from their definitions in long double.
SurfaceField term_by_term(const TermSet& terms, const Eigen::VectorXd& c, const Pupil& points) {
  using Long = long double;
  const Long two_pi = 2 * std::numbers::pi_v<Long>;
  SurfaceField field;
  field.resize(points.x.size());
  for (Eigen::Index i = 0; i < points.x.size(); ++i) {
    Long h = 0, hx = 0, hy = 0;
    const double x = points.x[i], y = points.y[i];
    for (std::size_t j = 0; j < terms.zernike.size(); ++j) {
      const ZernikeValue z = zernike(terms.zernike[j], x / terms.radius, y / terms.radius);
      const Long a = c[Eigen::Index(j)];
      h += a * z.value, hx += a * z.dx / terms.radius, hy += a * z.dy / terms.radius;
    }
    for (std::size_t j = 0; j < terms.fourier.size(); ++j) {
      const Long fx = terms.fourier[j].fx, fy = terms.fourier[j].fy, phase = two_pi * (fx * x + fy * y);
      const Long a = c[terms.fourier_begin() + 2 * Eigen::Index(j)],
                 b = c[terms.fourier_begin() + 2 * Eigen::Index(j) + 1];
      const Long along = two_pi * (b * std::cos(phase) - a * std::sin(phase));
      h += a * std::cos(phase) + b * std::sin(phase), hx += fx * along, hy += fy * along;
    }
    for (std::size_t j = 0; j < terms.spherical.size(); ++j) {
      const Long a = c[terms.spherical_begin() + Eigen::Index(j)], r2 = Long(kRadius) * kRadius;
      const Long s = (Long(x) * x + Long(y) * y) / r2, half = terms.spherical[j] / 2;
      h += a * std::pow(s, half);
      hx += a * half * std::pow(s, half - 1) * 2 * x / r2;
      hy += a * half * std::pow(s, half - 1) * 2 * y / r2;
    }
    field.height[i] = double(h), field.slope_x[i] = double(hx), field.slope_y[i] = double(hy);
  }
  return field;
}

/// Largest relative difference of heights or slopes, relative to the largest height or the largest slope.
double relative_difference(const SurfaceField& a, const SurfaceField& b) {
  const double height = (a.height - b.height).abs().maxCoeff() / b.height.abs().maxCoeff();
  const double slope =
      std::max((a.slope_x - b.slope_x).abs().maxCoeff(), (a.slope_y - b.slope_y).abs().maxCoeff());
  return std::max(height, slope / std::max(b.slope_x.abs().maxCoeff(), b.slope_y.abs().maxCoeff()));
}

double norm(const SurfaceField& f) {
  return std::sqrt(f.height.square().sum() + f.slope_x.square().sum() + f.slope_y.square().sum());
}
double dot(const SurfaceField& a, const SurfaceField& b) {
  return (a.height * b.height + a.slope_x * b.slope_x + a.slope_y * b.slope_y).sum();
}

constexpr double kSum = 1e-12;      // relative to the largest value of the sum; both sides have rounding
constexpr double kAdjoint = 1e-13;  // relative to |L c| |g|

void expect_adjoint(const TermSet& terms, const Pupil& points, const char* name) {
  const SurfaceOperator op(terms, points.x, points.y);
  const Eigen::VectorXd c = normals(terms.size(), name).matrix();
  const SurfaceField g = random_field(points.x.size(), name);
  SurfaceField field;
  op.apply(c, &field);
  const Eigen::VectorXd transposed = op.apply_transpose(g);
  ASSERT_EQ(transposed.size(), terms.size());
  EXPECT_LE(std::abs(dot(field, g) - c.dot(transposed)) / (norm(field) * norm(g)), kAdjoint) << name;
  EXPECT_GT(transposed.norm(), 0);
}

}  // namespace

TEST(SurfaceOperator, MixedSetMatchesTermByTermSum) {
  const Pupil points = pupil(777, "mixed");
  for (const int n_min : {0, 1, 2}) {
    const TermSet terms = mixed_terms(n_min, 20);
    const Eigen::VectorXd c = normals(terms.size(), "mixed coefficients").matrix();
    SurfaceField field;
    SurfaceOperator(terms, points.x, points.y).apply(c, &field);
    EXPECT_LE(relative_difference(field, term_by_term(terms, c, points)), kSum) << "n_min " << n_min;
  }
}

TEST(SurfaceOperator, EachKindAloneMatchesTermByTermSum) {
  const Pupil points = pupil(300, "alone");
  for (int kind = 0; kind < 3; ++kind) {
    TermSet terms = mixed_terms(2, 12);
    if (kind != 0) terms.zernike.clear();
    if (kind != 1) terms.fourier.clear();
    if (kind != 2) terms.spherical.clear();
    const Eigen::VectorXd c = normals(terms.size(), "alone coefficients").matrix();
    SurfaceField field;
    SurfaceOperator(terms, points.x, points.y).apply(c, &field);
    EXPECT_LE(relative_difference(field, term_by_term(terms, c, points)), kSum) << "kind " << kind;
    expect_adjoint(terms, points, "alone");
  }
}

TEST(SurfaceOperator, TakesAnySubsetOfModesInAnyOrder) {
  TermSet terms;
  terms.radius = kRadius;
  terms.zernike = {{7, -5}, {12, 0},  {2, 2}, {3, -3}, {40, 38},
                   {1, 1},  {40, -2}, {9, 9}, {0, 0},  {12, 0}};  // one occurs twice
  const Pupil points = pupil(301, "subset", kRadius);
  const Eigen::VectorXd c = normals(terms.size(), "subset coefficients").matrix();
  SurfaceField field;
  SurfaceOperator(terms, points.x, points.y).apply(c, &field);
  EXPECT_LE(relative_difference(field, term_by_term(terms, c, points)), kSum);
  expect_adjoint(terms, points, "subset");
}

TEST(SurfaceOperator, HighOrderSumMatchesTermByTermSum) {
  TermSet terms;
  terms.radius = kRadius;
  terms.zernike = zernike_modes(2, 100);
  const Pupil points = pupil(65, "high order", kRadius);
  const Eigen::VectorXd c = normals(terms.size(), "high order coefficients").matrix();
  SurfaceField field;
  SurfaceOperator(terms, points.x, points.y).apply(c, &field);
  EXPECT_LE(relative_difference(field, term_by_term(terms, c, points)), kSum);
}

TEST(SurfaceOperator, AdjointIdentityHolds) {
  // The numbers of points lie around the vector, block and chunk sizes, to test every kind of remainder.
  for (const int count : {1, 3, 16, 255, 256, 257, 4096, 4097, 9001})
    expect_adjoint(mixed_terms(0, 20), pupil(count, "adjoint"), "adjoint");
  // More points than the partial vectors held at once can serve.
  expect_adjoint(mixed_terms(2, 3), pupil(600001, "adjoint many"), "adjoint many");
  TermSet high;
  high.radius = kRadius;
  high.zernike = zernike_modes(2, 120);
  expect_adjoint(high, pupil(500, "adjoint high", kRadius), "adjoint high");
}

TEST(SurfaceOperator, AdjointOfOnePointIsItsRowOfTheOperator) {
  const TermSet terms = mixed_terms(0, 9);
  const Pupil points = pupil(40, "row");
  const SurfaceOperator op(terms, points.x, points.y);
  SurfaceField weights;
  weights.resize(40);
  weights.height.setZero(), weights.slope_x.setZero(), weights.slope_y.setZero();
  weights.height[17] = 1, weights.slope_x[17] = 1e-2, weights.slope_y[17] = -3e-2;
  const Eigen::VectorXd row = op.apply_transpose(weights);
  for (Eigen::Index j = 0; j < terms.size(); ++j) {
    const SurfaceField unit = term_by_term(terms, Eigen::VectorXd::Unit(terms.size(), j), points);
    EXPECT_NEAR(row[j], dot(unit, weights), 1e-13 * row.cwiseAbs().maxCoeff()) << j;
  }
}

TEST(SurfaceOperator, ListedRaysGiveTheAdjointOfZeroWeightsElsewhere) {
  const TermSet terms = mixed_terms(2, 15);
  const Pupil points = pupil(12000, "sparse");
  const SurfaceOperator op(terms, points.x, points.y);
  std::vector<std::uint32_t> rays;
  for (std::uint32_t i = 11999; i > 7; i -= 2) rays.push_back(i);  // descending order is allowed
  const SurfaceField listed = random_field(Eigen::Index(rays.size()), "sparse weights");
  SurfaceField dense;
  dense.resize(12000);
  dense.height.setZero(), dense.slope_x.setZero(), dense.slope_y.setZero();
  for (std::size_t i = 0; i < rays.size(); ++i) {
    dense.height[rays[i]] = listed.height[Eigen::Index(i)];
    dense.slope_x[rays[i]] = listed.slope_x[Eigen::Index(i)];
    dense.slope_y[rays[i]] = listed.slope_y[Eigen::Index(i)];
  }
  const Eigen::VectorXd a = op.apply_transpose(rays, listed), b = op.apply_transpose(dense);
  // The same sum of 6000 terms in another order: n eps of the norm.
  EXPECT_LE((a - b).norm() / b.norm(), kAdjoint);
}

TEST(SurfaceOperator, ThreadCountChangesNoBit) {
  const TermSet terms = mixed_terms(1, 14);
  const Pupil points = pupil(30011, "threads");
  const Eigen::VectorXd c = normals(terms.size(), "threads coefficients").matrix();
  const SurfaceField g = random_field(30011, "threads weights");
  std::vector<std::uint32_t> rays;
  for (std::uint32_t i = 0; i < 30011; i += 3) rays.push_back(i);
  const SurfaceField some = random_field(Eigen::Index(rays.size()), "threads some");

  const SurfaceOperator single(terms, points.x, points.y, 1);
  SurfaceField expected;
  single.apply(c, &expected);
  for (const int threads : {2, 3}) {
    const SurfaceOperator op(terms, points.x, points.y, threads);
    SurfaceField field;
    op.apply(c, &field);
    EXPECT_TRUE((field.height == expected.height).all());
    EXPECT_TRUE((field.slope_x == expected.slope_x).all());
    EXPECT_TRUE((field.slope_y == expected.slope_y).all());
    EXPECT_EQ(op.apply_transpose(g), single.apply_transpose(g));
    EXPECT_EQ(op.apply_transpose(rays, some), single.apply_transpose(rays, some));
  }
}

TEST(SurfaceOperator, EveryInstructionSetGivesTheSameFieldToRounding) {
  const TermSet terms = mixed_terms(0, 30);
  const ZernikeRows zernike_part = zernike_rows(terms.zernike);
  const FourierRows fourier_part = fourier_rows(terms.fourier);
  const Eigen::ArrayXd zernike_packed = normals(Eigen::Index(2 * zernike_part.rows()), "packed zernike");
  const Eigen::ArrayXd fourier_packed = normals(2 * fourier_part.modes(), "packed fourier");
  const Pupil points = pupil(201, "instruction sets", 1.0);
  PointBlock empty{};
  empty.used = 201;
  for (int i = 0; i < 201; ++i) empty.x[i] = points.x[i], empty.y[i] = points.y[i];

  struct Outcome {
    SurfaceField field;
    Eigen::VectorXd zernike, fourier;
  };
  const auto run = [&](InstructionSet set) {
    PointBlock block = empty;
    zernike_forward(set, zernike_part, zernike_packed.data(), &block);
    fourier_forward(set, fourier_part, fourier_packed.data(), &block);
    Outcome outcome;
    outcome.field.height = Eigen::Map<Eigen::ArrayXd>(block.height, 201);
    outcome.field.slope_x = Eigen::Map<Eigen::ArrayXd>(block.slope_x, 201);
    outcome.field.slope_y = Eigen::Map<Eigen::ArrayXd>(block.slope_y, 201);
    PointBlock weights = empty;  // the same for all sets; entries from `used` on stay zero
    for (int i = 0; i < 201; ++i)
      weights.height[i] = 1.0 + i, weights.slope_x[i] = 0.3 * i, weights.slope_y[i] = 1.0 - i;
    outcome.zernike = Eigen::VectorXd::Zero(zernike_packed.size());
    outcome.fourier = Eigen::VectorXd::Zero(fourier_packed.size());
    std::vector<CacheLine> lanes;
    zernike_adjoint(set, zernike_part, weights, &lanes, outcome.zernike.data());
    fourier_adjoint(set, fourier_part, weights, outcome.fourier.data());
    return outcome;
  };

  const Outcome baseline = run(InstructionSet::kBaseline);
  for (const InstructionSet set : {InstructionSet::kAvx2, InstructionSet::kAvx512}) {
    if (!is_supported(set)) continue;
    const Outcome outcome = run(set);
    EXPECT_LE(relative_difference(outcome.field, baseline.field), kSum);
    EXPECT_LE((outcome.zernike - baseline.zernike).norm() / baseline.zernike.norm(), kSum);
    EXPECT_LE((outcome.fourier - baseline.fourier).norm() / baseline.fourier.norm(), kSum);
  }
}

TEST(SurfaceOperator, HoldsZernikesAtTheRimAndNothingElse) {
  TermSet terms = mixed_terms(2, 20);
  const Pupil around = pupil(500, "rim", 1.05 * kRadius);
  PupilSample sample{around.x, around.y, Eigen::ArrayXd::Constant(500, 1.0 / 500)};
  const Eigen::VectorXd c = normals(terms.size(), "rim coefficients").matrix();
  const auto only = [&](Eigen::Index begin, Eigen::Index count) {
    Eigen::VectorXd some = Eigen::VectorXd::Zero(c.size());
    some.segment(begin, count) = c.segment(begin, count);
    return some;
  };
  Pupil pulled = around;
  for (Eigen::Index i = 0; i < pulled.x.size(); ++i) {
    const double beyond = std::hypot(pulled.x[i], pulled.y[i]) / kRadius;
    if (beyond > 1) pulled.x[i] /= beyond, pulled.y[i] /= beyond;
  }
  const Eigen::Index zernikes = Eigen::Index(terms.zernike.size());
  SurfaceField expected = term_by_term(terms, only(0, zernikes), pulled);
  const SurfaceField others = term_by_term(terms, only(zernikes, c.size() - zernikes), around);
  expected.height += others.height;
  expected.slope_x += others.slope_x;
  expected.slope_y += others.slope_y;
  {
    OperatorOptions options;
    options.hold_at_rim = true;
    const SurfaceOperator held(terms, sample, options);
    SurfaceField field;
    held.apply(c, &field);
    EXPECT_LE(relative_difference(field, expected), kSum);
    const SurfaceField g = random_field(500, "rim");
    EXPECT_LE(std::abs(dot(field, g) - c.dot(held.apply_transpose(g))) / (norm(field) * norm(g)), kAdjoint);
  }
}

TEST(SurfaceOperator, PlaneWavesKeepTheirPhaseOverManyCycles) {
  // Phases up to 800 cycles: rounding of f.x alone gives 2 pi 800 eps = 1.1e-12 of the amplitude. Some points
  // have exact half and quarter cycles.
  TermSet terms;
  terms.fourier = {{4000.0, 0.0}, {-1234.5, 2345.6}, {0.0, 0.0}, {2.5, 0.0}, {0.0, -1.25}};
  Pupil points = pupil(500, "phase");
  points.x.head(5) << 0.0, 0.1, 0.2, -0.1, -0.2;
  points.y.head(5) << 0.2, 0.1, 0.0, -0.1, -0.2;
  for (Eigen::Index j = 0; j < terms.size(); ++j) {
    const Eigen::VectorXd c = Eigen::VectorXd::Unit(terms.size(), j);
    SurfaceField field;
    SurfaceOperator(terms, points.x, points.y).apply(c, &field);
    const SurfaceField exact = term_by_term(terms, c, points);
    const FourierMode f = terms.fourier[std::size_t(j / 2)];
    const double k = 2 * std::numbers::pi * std::hypot(f.fx, f.fy), reach = 1e-15 + k * kRadius * 2.3e-16;
    EXPECT_LE((field.height - exact.height).abs().maxCoeff(), 4e-15 + reach) << j;
    EXPECT_LE((field.slope_x - exact.slope_x).abs().maxCoeff(), k * (4e-15 + reach)) << j;
    EXPECT_LE((field.slope_y - exact.slope_y).abs().maxCoeff(), k * (4e-15 + reach)) << j;
  }
}

TEST(SurfaceOperator, SlopesAreTheDerivativesOfTheHeights) {
  // The reference uses no formula for a gradient, only fourth-order central differences of the heights.
  const TermSet terms = mixed_terms(0, 10);
  const Pupil points = pupil(200, "differences");
  const Eigen::VectorXd c = normals(terms.size(), "differences coefficients").matrix();
  SurfaceField field;
  SurfaceOperator(terms, points.x, points.y).apply(c, &field);
  const double step = 2e-5;
  const auto height = [&](double dx, double dy) {
    SurfaceField moved;
    SurfaceOperator(terms, points.x + dx, points.y + dy).apply(c, &moved);
    return moved.height;
  };
  const Eigen::ArrayXd by_x =
      (8 * (height(step, 0) - height(-step, 0)) - (height(2 * step, 0) - height(-2 * step, 0))) / (12 * step);
  const Eigen::ArrayXd by_y =
      (8 * (height(0, step) - height(0, -step)) - (height(0, 2 * step) - height(0, -2 * step))) / (12 * step);
  // Truncation is (k step)^4 / 30 with k = 2 pi 57 /m: 9e-11. Rounding is eps h / step ~ 1e-10 of the slopes.
  const double scale = std::max(field.slope_x.abs().maxCoeff(), field.slope_y.abs().maxCoeff());
  EXPECT_LE((by_x - field.slope_x).abs().maxCoeff() / scale, 1e-9);
  EXPECT_LE((by_y - field.slope_y).abs().maxCoeff() / scale, 1e-9);
}

TEST(SurfaceOperator, HandlesNoPointsAndNoTerms) {
  SurfaceField field;
  const SurfaceOperator nowhere(mixed_terms(0, 4), Eigen::ArrayXd(0), Eigen::ArrayXd(0));
  nowhere.apply(Eigen::VectorXd::Ones(nowhere.terms().size()), &field);
  EXPECT_EQ(field.size(), 0);
  EXPECT_EQ(nowhere.apply_transpose(field), Eigen::VectorXd::Zero(nowhere.terms().size()));

  const SurfaceOperator flat(TermSet{}, Eigen::ArrayXd::Ones(5), Eigen::ArrayXd::Ones(5));
  flat.apply(Eigen::VectorXd(0), &field);
  EXPECT_TRUE((field.height == 0).all() && (field.slope_x == 0).all() && (field.slope_y == 0).all());
  EXPECT_EQ(flat.apply_transpose(field).size(), 0);
}

TEST(SurfaceOperator, RejectsWhatItCannotEvaluate) {
  const Eigen::ArrayXd two = Eigen::ArrayXd::Zero(2), three = Eigen::ArrayXd::Zero(3);
  TermSet terms;
  terms.radius = 1;
  EXPECT_THROW(SurfaceOperator(terms, two, three), std::invalid_argument);
  terms.zernike = {{2, 1}};
  EXPECT_THROW(SurfaceOperator(terms, two, two), std::invalid_argument);
  terms.zernike = {{2, 0}};
  terms.radius = 0;
  EXPECT_THROW(SurfaceOperator(terms, two, two), std::invalid_argument);
  terms.radius = 1, terms.spherical = {5};
  EXPECT_THROW(SurfaceOperator(terms, two, two), std::invalid_argument);
}
