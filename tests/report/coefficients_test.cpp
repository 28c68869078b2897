#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "aberfit/core/errors.h"
#include "aberfit/core/random.h"
#include "aberfit/report/result.h"
#include "aberfit/scene/segments.h"
#include "sample_result.h"

using namespace aberfit;

namespace {

class CoefficientsCsv : public ::testing::Test {
 protected:
  CoefficientsCsv() {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    path_ =
        (std::filesystem::path(::testing::TempDir()) / (std::string("coefficients-") + info->name() + ".csv"))
            .string();
    terms_ = sample_result().fitted.terms;
  }
  ~CoefficientsCsv() override { std::filesystem::remove(path_); }

  void put(const std::string& text) { std::ofstream(path_) << text; }
  // Writes a file with the usual header and the given rows.
  void put_rows(const std::string& rows) {
    const std::string empty = coefficients_csv(TermSet{0.2, {}, {}, {}}, {}, {});
    put(empty + rows);
    first_row_ = 1 + int(std::count(empty.begin(), empty.end(), '\n'));
  }
  // The message of the reading error. It must name the file and (unless `row` is 0) the row, counted from 1.
  std::string error(int row) {
    try {
      read_coefficients_csv(path_, &terms_);
    } catch (const InputError& e) {
      EXPECT_EQ(e.file(), path_);
      EXPECT_EQ(e.pointer(), row == 0 ? "" : "line " + std::to_string(first_row_ + row - 1));
      return e.what();
    }
    ADD_FAILURE() << "no InputError";
    return "";
  }

  std::string path_;
  TermSet terms_;
  int first_row_ = 0;
};

bool same_bits(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), std::size_t(a.size()) * sizeof(double)) == 0;
}

}  // namespace

TEST_F(CoefficientsCsv, ReadsBackToTheLastBit) {
  TermSet terms;
  terms.radius = 0.2 / 3.0;
  terms.zernike = zernike_modes(2, 12);
  const RandomStream random(7, "coefficients-round-trip");
  for (std::uint64_t i = 0; i < 50; ++i) {
    const auto [fx, fy] = random.normal_pair(i);
    terms.fourier.push_back({40 * fx, 40 * fy});
  }
  terms.spherical = {4, 6, 12};
  Eigen::VectorXd c(terms.size());
  for (Eigen::Index i = 0; i < c.size(); ++i) {
    const auto [a, b] = random.normal_pair(1000 + std::uint64_t(i));
    c[i] = 1e-8 * a * std::exp(20 * b);  // many decades
  }
  c[3] = 5e-324;
  c[4] = -0.0;
  put(coefficients_csv(terms, c, Eigen::VectorXd::Constant(c.size(), 1e-10)));
  EXPECT_TRUE(same_bits(read_coefficients_csv(path_, &terms), c));

  TermSet empty;
  EXPECT_TRUE(same_bits(read_coefficients_csv(path_, &empty), c));
  EXPECT_EQ(empty.radius, terms.radius);
  EXPECT_EQ(empty.zernike, terms.zernike);
  EXPECT_EQ(empty.spherical, terms.spherical);
  ASSERT_EQ(empty.fourier.size(), terms.fourier.size());
  for (std::size_t i = 0; i < terms.fourier.size(); ++i) {
    EXPECT_EQ(empty.fourier[i].fx, terms.fourier[i].fx);
    EXPECT_EQ(empty.fourier[i].fy, terms.fourier[i].fy);
  }
}

TEST_F(CoefficientsCsv, HasTheErrorsOfSegmentsByTheirNumber) {
  SegmentedAperture aperture = hexagonal_segments(1, 0.1, 0.01, false, 0);
  aperture.tip_tilt = 1e-7;
  TermSet terms;
  terms.radius = 0.2;
  terms.zernike = zernike_modes(2, 2);
  terms.segments = std::make_shared<const Segments>(aperture);
  const Eigen::VectorXd c = 1e-8 * Eigen::VectorXd::Random(terms.size());
  const std::string text = coefficients_csv(terms, c, {});
  EXPECT_NE(text.find("\nslope_y,6,,,,,"), std::string::npos);
  EXPECT_EQ(text.find("\npiston,"), std::string::npos);
  put(text);
  EXPECT_TRUE(same_bits(read_coefficients_csv(path_, &terms), c));
  TermSet of_study;  // only its segments are known
  of_study.segments = terms.segments;
  EXPECT_TRUE(same_bits(read_coefficients_csv(path_, &of_study), c));
  TermSet without;
  try {
    read_coefficients_csv(path_, &without);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("slope_x of segment 1"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("`piston` and `tip_tilt`"), std::string::npos) << error.what();
  }
}

TEST_F(CoefficientsCsv, SaysUnitsAndConventionsBeforeTheNumbers) {
  const ResultDocument result = sample_result();
  const std::string text = coefficients_csv(result.fitted.terms, result.fitted.fit.coefficients, {});
  const std::string header = text.substr(0, text.find("\nkind,n,m,noll"));
  for (const char* word : {"metres", "surface (not of the wavefront)", "towards the incoming light",
                           "orthonormal", "m > 0 cosine", "cycles per metre", "radius_m = 0.2"})
    EXPECT_NE(header.find(word), std::string::npos) << word;
  EXPECT_NE(text.find("\nzernike,2,-2,5,,,"), std::string::npos);
  EXPECT_NE(text.find("\nsin,,,,2.5,0.3333333333333333,"), std::string::npos);
  EXPECT_NE(text.find("\nspherical,8,,,,,"), std::string::npos);
}

TEST_F(CoefficientsCsv, FillsTermsTheFileLacksWithZeroInAnyRowOrder) {
  put_rows(
      "spherical,8,,,,,3e-9,\r\n\nzernike,3,1,8,,,-2e-9,1e-10\nsin,,,,-7.25,0.1,4e-9,\nzernike,2,0,,,,1e-9,"
      "\n");
  Eigen::VectorXd expected = Eigen::VectorXd::Zero(10);
  expected[1] = 1e-9;
  expected[3] = -2e-9;
  expected[7] = 4e-9;
  expected[9] = 3e-9;
  EXPECT_TRUE(same_bits(read_coefficients_csv(path_, &terms_), expected));
}

TEST_F(CoefficientsCsv, FindsAWaveWhoseFrequencyDiffersInTheLastBits) {
  put_rows("cos,,,,2.5000000001,0.33333333334,4e-9,\n");
  EXPECT_EQ(read_coefficients_csv(path_, &terms_)[4], 4e-9);
  put_rows("cos,,,,2.5000001,0.33333333334,4e-9,\n");
  EXPECT_NE(error(1).find("cosine wave"), std::string::npos);
}

TEST_F(CoefficientsCsv, RejectsTermsTheSetLacks) {
  put_rows("zernike,2,0,4,,,1e-9,\nzernike,9,1,,,,1e-9,\n");
  EXPECT_NE(error(2).find("zernike n = 9, m = 1"), std::string::npos);
  put_rows("spherical,6,,,,,1e-9,\n");
  EXPECT_NE(error(1).find("spherical n = 6"), std::string::npos);
}

TEST_F(CoefficientsCsv, RejectsATermThatComesTwice) {
  put_rows("zernike,2,0,4,,,1e-9,\nzernike,2,2,6,,,1e-9,\nzernike,2,0,4,,,2e-9,\n");
  EXPECT_NE(error(3).find("line " + std::to_string(first_row_)), std::string::npos);
  terms_ = TermSet{};  // also if the file itself is the set
  EXPECT_NE(error(3).find("once"), std::string::npos);
}

TEST_F(CoefficientsCsv, RejectsWhatIsNotANumber) {
  for (const char* bad : {"", "x", "1e-9 m", "nan", "inf", "1e999", "1,5e-9"}) {
    put_rows(std::string("zernike,2,2,6,,,1e-9,\nzernike,2,0,4,,,") + bad + ",\n");
    error(2);
  }
  put_rows("zernike,2,0,4,,,1e-9,one\n");
  EXPECT_NE(error(1).find("\"one\""), std::string::npos);
  put_rows("zernike,2.5,0,4,,,1e-9,\n");
  EXPECT_NE(error(1).find("integer"), std::string::npos);
}

TEST_F(CoefficientsCsv, RejectsModesThatDoNotExistAndForeignIndexSchemes) {
  put_rows("zernike,3,0,,,,1e-9,\n");
  EXPECT_NE(error(1).find("even"), std::string::npos);
  put_rows("zernike,2,2,5,,,1e-9,\n");  // 5 is OSA's index of (2,2); Noll's is 6
  EXPECT_NE(error(1).find("Noll"), std::string::npos);
  put_rows("zernike,2147483646,-2147483648,,,,1e-9,\n");  // |m| and the index are no int
  EXPECT_NE(error(1).find("300"), std::string::npos);
  put_rows("zernike,4,-2147483648,,,,1e-9,\n");
  EXPECT_NE(error(1).find("even"), std::string::npos);
  put_rows("slope_z,0,0,1,,,1e-9,\n");
  EXPECT_NE(error(1).find("\"slope_z\""), std::string::npos);
  put_rows("spherical,5,,,,,1e-9,\n");
  EXPECT_NE(error(1).find("\"5\""), std::string::npos);
}

TEST_F(CoefficientsCsv, RejectsAnotherNormalisationRadius) {
  put_rows("zernike,2,0,4,,,1e-9,\n");
  terms_.radius = 0.25;
  EXPECT_NE(error(0).find("radius_m = 0.2"), std::string::npos);
}

TEST_F(CoefficientsCsv, RejectsFilesOfAnotherKind) {
  error(0);  // no such file
  put("");
  error(0);
  put("# radius_m = 0.2\n1 2 3\n");
  first_row_ = 2;
  error(1);
  put("kind,n,m,noll,fx_per_m,fy_per_m,value_m,std_m\n");
  EXPECT_NE(error(0).find("radius"), std::string::npos);
}
