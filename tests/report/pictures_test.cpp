#include "aberfit/report/pictures.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <numbers>
#include <regex>
#include <sstream>

#include "../../src/report/fit_pictures.h"
#include "../../src/report/gnuplot.h"
#include "aberfit/core/embedded_texts.h"
#include "plot_scene.h"

using namespace aberfit;
namespace fs = std::filesystem;

namespace {

// Distance that the curve of N random points exceeds once in 1e6 experiments. Dvoretzky-Kiefer-Wolfowitz
// bound with Massart's constant: sup |F_N - F| <= sqrt(ln(2 / alpha) / (2 N)).
double dkw(Eigen::Index count) { return std::sqrt(std::log(2 / 1e-6) / (2.0 * double(count))); }
constexpr double kPrinted = 1e-8;     // relative rounding of a column of nine digits
constexpr double kPrintedMap = 1e-5;  // and of a map of six

std::string content(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::vector<std::vector<double>> rows(const fs::path& path) {
  std::ifstream in(path);
  EXPECT_TRUE(in) << path;
  std::vector<std::vector<double>> all;
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("#")) continue;
    std::vector<double> row;
    std::istringstream cells(line);
    for (std::string cell; cells >> cell;) row.push_back(std::strtod(cell.c_str(), nullptr));
    all.push_back(row);
  }
  return all;
}

bool has_gnuplot() {
  std::istringstream path(std::getenv("PATH") ? std::getenv("PATH") : "");
  for (std::string folder; std::getline(path, folder, ':');)
    if (::access((folder + "/gnuplot").c_str(), X_OK) == 0) return true;
  return false;
}

// Sets PATH for the life of the object.
class Path {
 public:
  explicit Path(const std::string& value) : before_(std::getenv("PATH") ? std::getenv("PATH") : "") {
    ::setenv("PATH", value.c_str(), 1);
  }
  ~Path() { ::setenv("PATH", before_.c_str(), 1); }

 private:
  std::string before_;
};

const std::vector<std::string> kNames = {"specified_psd", "ee_curves", "ring_through", "focal_images",
                                         "bsdf",          "surface",   "profile",      "gradients",
                                         "coefficients",  "character"};

// Surface error of the scene, written anew. The truth scene of the maps has only waves and spherical terms,
// because explicit polynomials of Zernikes would be long.
struct Truth {
  const TermSet& terms;
  const Eigen::VectorXd& c;
  double height(double x, double y) const {
    double h = 0;
    for (std::size_t k = 0; k < terms.fourier.size(); ++k) {
      const double phase = 2 * std::numbers::pi * (terms.fourier[k].fx * x + terms.fourier[k].fy * y);
      h += c[Eigen::Index(2 * k)] * std::cos(phase) + c[Eigen::Index(2 * k + 1)] * std::sin(phase);
    }
    for (std::size_t k = 0; k < terms.spherical.size(); ++k)
      h += c[terms.spherical_begin() + Eigen::Index(k)] *
           std::pow(std::hypot(x, y) / terms.radius, terms.spherical[k]);
    return h;
  }
  double slope(double x, double y, bool along_x) const {
    double s = 0;
    for (std::size_t k = 0; k < terms.fourier.size(); ++k) {
      const FourierMode& f = terms.fourier[k];
      const double phase = 2 * std::numbers::pi * (f.fx * x + f.fy * y);
      s += 2 * std::numbers::pi * (along_x ? f.fx : f.fy) *
           (c[Eigen::Index(2 * k + 1)] * std::cos(phase) - c[Eigen::Index(2 * k)] * std::sin(phase));
    }
    for (std::size_t k = 0; k < terms.spherical.size(); ++k) {
      const int n = terms.spherical[k];
      const double rho = std::hypot(x, y);
      if (rho > 0)
        s += c[terms.spherical_begin() + Eigen::Index(k)] * n * std::pow(rho / terms.radius, n - 1) /
             terms.radius * (along_x ? x : y) / rho;
    }
    return s;
  }
};

// The pictures of the plain scene, drawn once for all tests that only read them.
class Pictures : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    root() = fs::path(::testing::TempDir()) / ("aberfit plots' \"$HOME\" " + std::to_string(::getpid()));
    fs::remove_all(root());
    scene() = new PlotScene();
    scene()->result.judgement.character = sample_character();
    scene()->result.title = "It's a `touch executed` @test, 50 % {a}_b^c \"quoted\" \\n $0";
    drawn() = scene()->write((root() / "run").string(), &warnings());
  }
  static void TearDownTestSuite() {
    delete scene();
    fs::remove_all(root());
  }
  static fs::path& root() {
    static fs::path value;
    return value;
  }
  static PlotScene*& scene() {
    static PlotScene* value = nullptr;
    return value;
  }
  static std::vector<DrawnPicture>& drawn() {
    static std::vector<DrawnPicture> value;
    return value;
  }
  static Warnings& warnings() {
    static Warnings value;
    return value;
  }
  static fs::path file(const std::string& name) { return root() / "run" / "plots" / name; }
};

}  // namespace

TEST_F(Pictures, EncircledEnergyOfAGaussianBundleIsRayleighs) {
  const double sigma = scene()->focal_sigma;
  const auto table = rows(file("ee_curves.dat"));
  ASSERT_EQ(table.size(), 501u);
  double worst = 0;
  for (const auto& row : table)
    worst = std::max(worst, std::abs(row[2] + std::expm1(-0.5 * std::pow(row[0] / sigma, 2))));
  EXPECT_LT(worst, dkw(scene()->target.size()));
  EXPECT_GT(table.back()[0], 2.8 * sigma);  // shows 98 % and more
  EXPECT_EQ(table.front()[2], 0.0);
}

TEST_F(Pictures, EncircledEnergyCountsRaysExactly) {
  const RayBundle& rays = scene()->fitted;
  const auto table = rows(file("ee_curves.dat"));
  for (std::size_t k = 0; k < table.size(); k += 50) {
    const double radius = table[k][0];
    const double low =
        (rays.weight * ((rays.x.square() + rays.y.square()).sqrt() <= radius * (1 - kPrinted)).cast<double>())
            .sum();
    const double high =
        (rays.weight * ((rays.x.square() + rays.y.square()).sqrt() <= radius * (1 + kPrinted)).cast<double>())
            .sum();
    EXPECT_GE(table[k][3], low - kPrinted);
    EXPECT_LE(table[k][3], high + kPrinted);
  }
}

TEST_F(Pictures, StandardErrorOfTheTargetIsBinomial) {
  const auto row = rows(file("ee_curves.dat"))[200];
  EXPECT_NEAR(row[4], std::sqrt(row[2] * (1 - row[2]) / double(scene()->target.size())), kPrinted);
}

TEST_F(Pictures, RingThroughOfTheIdealParabolaIsItsGeometry) {
  const std::string header = content(file("ring_through.dat"));
  std::smatch found;
  ASSERT_TRUE(std::regex_search(header, found, std::regex("ring of radius ([^ ]+) m")));
  const double ring = std::stod(found[1]), f = PlotScene::kFocalLength, radius = PlotScene::kRadius;
  // ee90 of a Gaussian is 2.146 sigma. Its sampling error is that of the fraction, 5 sqrt(0.09/N), over the
  // density at ee90.
  const double share_error = 5 * std::sqrt(0.09 / double(scene()->target.size()));
  EXPECT_NEAR(ring / (2.14596603 * scene()->focal_sigma), 1.0, share_error / (0.1 * 2.14596603 * 2.14596603));
  const auto table = rows(file("ring_through.dat"));
  double flank = 0;
  for (const auto& row : table) {
    // A ray from rho crosses plane dz at dz (rho/f)/(1 - (rho/2f)^2). The fraction is that of uniform points
    // inside the rho whose crossing is the ring.
    const double t = row[0] == 0 ? HUGE_VAL : ring / std::abs(row[0]);
    const double rho = std::isinf(t) ? HUGE_VAL : 2 * f * (std::sqrt(1 + t * t) - 1) / t;
    const double expected = std::min(1.0, std::pow(rho / radius, 2));
    EXPECT_NEAR(row[1], expected, dkw(scene()->ideal.size()))
        << row[0];  // a scrambled Sobol pupil does better than random points
    // The paraxial form min(1, (ring f / (R dz))^2) lacks the factor (1 - t^2)^2, t = R/2f, at the rim.
    const double paraxial = row[0] == 0 ? 1.0 : std::min(1.0, std::pow(ring * f / (radius * row[0]), 2));
    EXPECT_NEAR(expected, paraxial, 2 * std::pow(radius / (2 * f), 2)) << row[0];
    if (row[1] > 0.4 && row[1] < 0.6) flank += 1;
  }
  EXPECT_GT(flank, 20);  // the half maximum is well inside the picture
  EXPECT_LT(table.front()[1], 0.1);
  EXPECT_LT(table.back()[1], 0.1);
}

// The mean irradiance has no plane behind the mirror, but rings of widely scattered light would reach it.
TEST(PicturesOfWideScatter, EndInFrontOfTheMirror) {
  PlotScene wide(CircleAperture{2 * PlotScene::kRadius, 0}, 2000);
  const double spread = 0.5 * PlotScene::kFocalLength / wide.focal_sigma;
  wide.target.x *= spread;
  wide.target.y *= spread;
  wide.focal_sigma *= spread;
  const auto ideal = ray_light(wide.ideal, wide.ideal, Centre::kNominal),
             target = ray_light(wide.target, wide.ideal, Centre::kNominal),
             fitted = ray_light(wide.fitted, wide.ideal, Centre::kNominal);
  for (const char* model : {"rays", "waves"}) {
    wide.result.scene.model = model;
    const FitPictures input = wide.shown(*ideal, target.get(), *fitted);
    const internal::Picture ring = internal::ring_through_picture(input);
    ASSERT_EQ(ring.data.size(), 1u);
    std::istringstream lines(ring.data[0].second);
    double nearest = 0;
    for (std::string line; std::getline(lines, line);)
      if (!line.starts_with("#")) nearest = std::min(nearest, std::stod(line));
    EXPECT_NEAR(nearest, -0.9 * PlotScene::kFocalLength, kPrinted);
    const std::string images = internal::focal_images_picture(input).values;
    EXPECT_NE(images.find("2.52 m before z = f"), std::string::npos) << images;
  }
}

// The grid resolves planes up to one where the irradiance has not fallen to half. No width is searched
// beyond.
TEST(PicturesOfWideScatter, EndWhereTheCellsDo) {
  class FewCells : public FocalLight {
   public:
    explicit FewCells(const FocalLight& light) : light_(light) {}
    double statistic(const Statistic& wanted) const override {
      widths += std::holds_alternative<RingFwhm>(wanted);
      return light_.statistic(wanted);
    }
    Eigen::ArrayXd encircled_energy(const Eigen::ArrayXd& radii, double dz) const override {
      return light_.encircled_energy(radii, dz);
    }
    Eigen::ArrayXd ring_through(double radius, const Eigen::ArrayXd& planes) const override {
      return light_.ring_through(radius, planes);
    }
    Eigen::ArrayXXd image(double dz, double half_width, int pixels) const override {
      return light_.image(dz, half_width, pixels);
    }
    double farthest_plane() const override { return farthest; }
    double farthest = HUGE_VAL;
    mutable int widths = 0;

   private:
    const FocalLight& light_;
  };
  PlotScene scene(CircleAperture{2 * PlotScene::kRadius, 0}, 2000);
  const auto ideal = ray_light(scene.ideal, scene.ideal, Centre::kNominal),
             target = ray_light(scene.target, scene.ideal, Centre::kNominal),
             traced = ray_light(scene.fitted, scene.ideal, Centre::kNominal);
  const double width = traced->statistic(RingFwhm{0.9, target->statistic(EncircledEnergyRadius{0.9, 0.0})});
  for (const double farthest : {0.4 * width, 0.6 * width}) {  // before and behind where it falls to half
    FewCells fitted(*traced);
    fitted.farthest = farthest;
    const FitPictures input = scene.shown(*ideal, target.get(), fitted);
    const internal::Picture ring = internal::ring_through_picture(input);
    std::istringstream lines(ring.data.at(0).second);
    double nearest = 0, last = 0;
    for (std::string line; std::getline(lines, line);)
      if (!line.starts_with("#")) last = std::stod(line), nearest = std::min(nearest, last);
    EXPECT_NEAR(nearest, -farthest, 1e-6 * farthest);
    EXPECT_NEAR(last, farthest, 1e-6 * farthest);
    EXPECT_EQ(fitted.widths, farthest > 0.5 * width ? 1 : 0);
    EXPECT_EQ(ring.values.find("fitted surface: FWHM beyond these planes") == std::string::npos,
              farthest > 0.5 * width);
  }
  // The images have side planes; two units out all light is seen.
  FewCells fitted(*traced);
  fitted.farthest = 0.5 * PlotScene::kFocalLength * scene.focal_sigma / PlotScene::kRadius;
  const FitPictures input = scene.shown(*ideal, target.get(), fitted);
  const std::string images = internal::focal_images_picture(input).values;
  EXPECT_NE(images.find(internal::display(fitted.farthest, Dimension::kLength) + " before z = f"),
            std::string::npos)
      << images;
}

TEST_F(Pictures, RingThroughAgreesWithCountingPlaneByPlane) {
  const std::string header = content(file("ring_through.dat"));
  std::smatch found;
  ASSERT_TRUE(std::regex_search(header, found, std::regex("ring of radius ([^ ]+) m")));
  const double ring = std::stod(found[1]);
  const auto table = rows(file("ring_through.dat"));
  const RayBundle& rays = scene()->fitted;
  for (std::size_t k = 0; k < table.size(); k += 97) {
    const double dz = table[k][0];
    const Eigen::ArrayXd distance =
        ((rays.x + dz * rays.tx).square() + (rays.y + dz * rays.ty).square()).sqrt();
    // Ring and plane have nine printed digits, which may move single rays across the edge.
    const double slack = 1e-7 * ring;
    EXPECT_GE(table[k][3], (rays.weight * (distance <= ring - slack).cast<double>()).sum() - kPrinted);
    EXPECT_LE(table[k][3], (rays.weight * (distance <= ring + slack).cast<double>()).sum() + kPrinted);
  }
}

TEST_F(Pictures, FocalImagesHoldTheLightOfTheirWindow) {
  const auto sum_and_mean = [&](const std::string& name) {
    const auto image = rows(file(name));
    EXPECT_EQ(image.size(), 129u);
    double sum = 0, x = 0, y = 0;
    for (std::size_t j = 0; j < image.size(); ++j) {
      EXPECT_EQ(image[j].size(), 129u);
      for (std::size_t i = 0; i < image[j].size(); ++i) {
        EXPECT_GE(image[j][i], 0.0);
        sum += image[j][i];
        x += image[j][i] * (double(i) - 64);
        y += image[j][i] * (double(j) - 64);
      }
    }
    return std::array{sum, x / sum, y / sum};
  };
  // Five sigma hold all of the Gaussian except 4e-6 and the rim of the pixels.
  EXPECT_NEAR(sum_and_mean("focal_images_target_focus.dat")[0], 1.0, 1e-4 + 129 * 129 * 1e-11);
  EXPECT_NEAR(sum_and_mean("focal_images_ideal_before.dat")[0], 1.0, 1e-4);
  const auto focus = rows(file("focal_images_ideal_focus.dat"));
  EXPECT_NEAR(focus[64][64], 1.0, 1e-5);  // one point in the middle pixel
  // Bilinear weights keep the centroid, that of the fitted rays in units of pixels.
  const double pixel = 10 * scene()->focal_sigma / 129;
  const RayBundle& rays = scene()->fitted;
  const auto fitted = sum_and_mean("focal_images_fitted_focus.dat");
  EXPECT_NEAR(fitted[0], 1.0, 1e-4);
  EXPECT_NEAR(fitted[1], (rays.weight * rays.x).sum() / pixel, 1e-2);
  EXPECT_NEAR(fitted[2], (rays.weight * rays.y).sum() / pixel, 1e-2);
}

TEST_F(Pictures, SlopeDensitiesAreNormalisedAndKeepTheirMoments) {
  const auto table = rows(file("gradients.dat"));
  ASSERT_EQ(table.size(), 81u);
  const double width = table[1][0] - table[0][0];
  for (const int column : {1, 2}) {
    const Eigen::ArrayXd& slope = column == 1 ? scene()->field.slope_x : scene()->field.slope_y;
    double sum = 0, mean = 0, square = 0;
    for (const auto& row : table) {
      sum += row[std::size_t(column)] * width;
      mean += row[std::size_t(column)] * width * row[0];
      square += row[std::size_t(column)] * width * row[0] * row[0];
    }
    const Eigen::ArrayXd& weight = scene()->pupil.weight;
    const double sigma2 = (weight * slope.square()).sum();
    EXPECT_NEAR(sum, 1.0, 2e-3);  // the share beyond four standard deviations
    EXPECT_NEAR(mean, (weight * slope).sum(), 0.02 * std::sqrt(sigma2));
    EXPECT_NEAR(square / sigma2, 1.0, 0.03);  // bins of a tenth of sigma: width^2/12, and the tails
  }
  const auto dots = rows(file("gradients_scatter.dat"));
  EXPECT_NEAR(double(dots.size()), 5000, 5 * std::sqrt(5000.0));
}

TEST_F(Pictures, CoefficientsAddUpByRadialOrder) {
  const ResultDocument& result = scene()->result;
  const auto zernike = rows(file("coefficients_zernike.dat")), orders = rows(file("coefficients_orders.dat"));
  ASSERT_EQ(zernike.size(), result.fitted.terms.zernike.size());
  ASSERT_EQ(orders.size(), 5u);  // n = 2 .. 6
  for (std::size_t j = 0; j < zernike.size(); ++j)
    EXPECT_EQ(zernike[j][0], double(4 + j));  // Noll 4 .. 28 without a gap
  for (const auto& order : orders) {
    double square = 0;
    for (std::size_t i = 0; i < result.fitted.terms.zernike.size(); ++i)
      if (result.fitted.terms.zernike[i].n == order[0])
        square += std::pow(result.fitted.fit.coefficients[Eigen::Index(i)], 2);
    EXPECT_NEAR(order[1] / std::sqrt(square), 1.0, kPrinted);
  }
  const auto fourier = rows(file("coefficients_fourier.dat"));
  ASSERT_EQ(fourier.size(), 60u);
  const Eigen::Index k = result.fitted.terms.fourier_begin() + 2 * 7;
  EXPECT_NEAR(
      fourier[7][3] / std::hypot(result.fitted.fit.coefficients[k], result.fitted.fit.coefficients[k + 1]),
      1.0, kPrinted);
  const auto spherical = rows(file("coefficients_spherical.dat"));
  ASSERT_EQ(spherical.size(), 2u);
  EXPECT_EQ(spherical[1][0], 6.0);
}

TEST_F(Pictures, EveryDataFileSaysWhatItHoldsAndInWhichUnit) {
  int files = 0;
  for (const auto& entry : fs::directory_iterator(file(""))) {
    if (entry.path().extension() != ".dat") continue;
    ++files;
    const std::string text = content(entry.path());
    EXPECT_TRUE(text.starts_with("# ")) << entry.path();
    const std::string header = text.substr(0, text.find("\n", text.find("\n# ") + 1));
    EXPECT_TRUE(std::regex_search(header, std::regex("_m|\\[m\\]| m |rad\\]|_rad|fraction|/m\\]"))) << header;
  }
  EXPECT_EQ(files, 2 + 2 + 1 + 9 + 1 + 1 + 1 + 2 + 4 + 2);
}

// After the folder has moved, gnuplot alone can draw the pictures again, in each format.
TEST_F(Pictures, ScriptsDrawAgainInEachFormatWhereverTheFolderIs) {
  const std::string gnuplot = internal::find_gnuplot();
  if (gnuplot.empty()) GTEST_SKIP() << "no gnuplot";
  const fs::path moved = root() / "moved";
  fs::copy(root() / "run" / "plots", moved);
  for (const auto& [format, begin] :
       {std::pair{"png", "\x89PNG\r\n\x1a\n"}, {"svg", "<?xml"}, {"pdf", "%PDF-"}})
    for (const std::string& name : kNames) {
      const fs::path values = moved / (name + ".values");
      std::ofstream(values, std::ios::app) << "format = '" << format << "'\n";
      EXPECT_EQ(internal::run_gnuplot(gnuplot, moved.string(), name + ".gp"), "");
      const std::string picture = content(moved / (name + "." + format));
      EXPECT_GT(picture.size(), 8000u) << name << " " << format;
      EXPECT_TRUE(picture.starts_with(begin)) << name << " " << format;
    }
}

TEST_F(Pictures, AreThereWithWhatADocumentSaysOfThem) {
  if (!has_gnuplot()) {
    EXPECT_TRUE(drawn().empty());
    ASSERT_EQ(warnings().size(), 1u);
    EXPECT_EQ(warnings()[0].code, "no-gnuplot");
    return;
  }
  EXPECT_TRUE(warnings().empty()) << warnings()[0].message;
  ASSERT_EQ(drawn().size(), kNames.size());
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    const DrawnPicture& picture = drawn()[i];
    EXPECT_EQ(picture.name, kNames[i]);
    const bool is_map =
        picture.name == "focal_images" || picture.name == "surface" || picture.name == "gradients";
    EXPECT_EQ(picture.file, "plots/" + picture.name + (is_map ? ".png" : ".svg"));
    const std::string text = content(root() / "run" / picture.file);
    if (is_map) {
      EXPECT_TRUE(text.substr(text.size() - 8, 4) == "IEND") << picture.name;  // whole
      continue;
    }
    // The picture can stand in a document: it is small, runs nothing, loads nothing, and its words are text.
    EXPECT_LT(text.size(), 150000u) << picture.name;
    EXPECT_EQ(text.find("<script"), std::string::npos) << picture.name;
    EXPECT_FALSE(std::regex_search(text, std::regex("href=.[^#]"))) << picture.name;
    EXPECT_NE(text.find("<rect x=\"0\" y=\"0\""), std::string::npos) << picture.name;
    EXPECT_NE(text.find("touch executed"), std::string::npos) << picture.name;
  }
}

TEST(PictureScripts, HaveTitleCaptionAndAlternativeText) {
  int seen = 0;
  for (const auto& entry : std::filesystem::directory_iterator(ABERFIT_SOURCE_DIR "/src/report/pictures")) {
    const std::string name = entry.path().stem().string();
    const std::string script = embedded_text(entry.path().filename().string());
    if (name == "common") continue;
    ++seen;
    std::smatch found;
    ASSERT_TRUE(std::regex_search(script, found, std::regex("# caption: ((.|\n#   )+)\n# alt: .{20}")))
        << name;
    const std::string caption = std::regex_replace(found[1].str(), std::regex("\n#   "), " ");
    const std::regex end("\\.( |$)");
    const auto sentences =
        std::distance(std::sregex_iterator(caption.begin(), caption.end(), end), std::sregex_iterator());
    EXPECT_TRUE(sentences >= 1 && sentences <= 3) << name << ": " << caption;
    EXPECT_TRUE(std::regex_search(script, std::regex("^# title: .{5}"))) << name;
    EXPECT_TRUE(std::regex_search(script, std::regex("\n# format: (png|svg)\n"))) << name;
    std::istringstream lines(script);
    for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 110u) << name << ": " << line;
  }
  EXPECT_GT(seen, 25);
}

TEST_F(Pictures, DoNotDependOnTheNumberOfThreads) {
  if (!has_gnuplot()) GTEST_SKIP() << "no gnuplot";
  const std::vector<DrawnPicture> again = scene()->write((root() / "threads").string(), nullptr, {{}, 3});
  ASSERT_EQ(again.size(), drawn().size());
  for (std::size_t i = 0; i < again.size(); ++i)
    EXPECT_EQ(content(root() / "threads" / again[i].file), content(root() / "run" / drawn()[i].file))
        << again[i].name;
}

TEST_F(Pictures, OfNoFormatAreNotWritten) {
  EXPECT_TRUE(scene()->write((root() / "none").string(), nullptr, {PictureFormat::kNone}).empty());
  EXPECT_FALSE(fs::exists(root() / "none"));
}

TEST_F(Pictures, TitleOfTheStudyIsTextAndNeverACommand) {
  EXPECT_FALSE(fs::exists(file("executed")));
  if (!has_gnuplot()) GTEST_SKIP() << "no gnuplot";
  for (const char* name : {"specified_psd", "ring_through"})
    EXPECT_NE(content(file(std::string(name) + ".svg"))
                  .find("It's a 'touch executed' @test, 50 % {a}_b^c \"quoted\" \\n $0"),
              std::string::npos)
        << name;
}

TEST_F(Pictures, SpecifiedPsdAndScatterAreThoseOfTheModel) {
  // S is sigma^2 over the area of the band; single scattering gives exp(-g^2) 16 pi^2 S/lambda^4.
  const double sigma = 3e-9, low = 2.5, high = 1000, pi = std::numbers::pi, lambda = PlotScene::kWavelength;
  const double level = sigma * sigma / (pi * (high * high - low * low));
  for (const auto& row : rows(file("specified_psd.dat"))) EXPECT_NEAR(row[1] / level, 1, kPrinted) << row[0];
  const auto terms = rows(file("specified_psd_terms.dat"));
  ASSERT_EQ(terms.size(), scene()->result.judgement.character->psd.size());
  EXPECT_NEAR(terms[1][3] / (3.1 * 1e-17), 1, kPrinted);
  EXPECT_NEAR(terms[0][5] / (2.1 * 2e-17), 1, kPrinted);
  const double k2 = std::pow(4 * pi / lambda, 2), g2 = k2 * sigma * sigma;
  int inside = 0;
  for (const auto& row : rows(file("bsdf_whole.dat"))) {
    const double f = std::sin(row[0]) / lambda;
    if (f < 1.01 * low || f > 0.99 * high) continue;
    ++inside;
    // Higher orders add g^2/2 of it, up to twice as much in the middle.
    EXPECT_NEAR(row[1] / (std::exp(-g2) * k2 * level / (lambda * lambda)), 1, g2) << f;
  }
  EXPECT_GT(inside, 20);
}

namespace {

// A PSF known only by its transfer function, which is that of a perfect circle times `modulus` of direction.
class KnownTransfer : public FocalLight {
 public:
  KnownTransfer(double cutoff, double ripple) : cutoff_(cutoff), ripple_(ripple) {}
  static double circle(double nu) {
    return nu >= 1 ? 0 : 2 / std::numbers::pi * (std::acos(nu) - nu * std::sqrt(1 - nu * nu));
  }
  double statistic(const Statistic&) const override { return NAN; }
  Eigen::ArrayXd encircled_energy(const Eigen::ArrayXd& radii, double) const override { return radii; }
  Eigen::ArrayXd ring_through(double, const Eigen::ArrayXd& planes) const override { return planes; }
  Eigen::ArrayXXd image(double, double, int pixels) const override {
    return Eigen::ArrayXXd::Zero(pixels, pixels);
  }
  std::optional<TransferImage> transfer() const override {
    constexpr int kLags = 256;
    TransferImage otf{Eigen::ArrayXXcd(2 * kLags + 1, 2 * kLags + 1), cutoff_ / kLags, kLags};
    for (int row = -kLags; row <= kLags; ++row)
      for (int column = -kLags; column <= kLags; ++column) {
        const double angle = std::atan2(row, column), phase = 0.1 * row;
        otf.value(row + kLags, column + kLags) = std::polar(
            circle(std::hypot(row, column) / kLags) * (1 - ripple_ * std::pow(std::cos(angle), 2)), phase);
      }
    return otf;
  }
  std::optional<Eigen::ArrayXd> round_transfer(const Eigen::ArrayXd& frequencies) const override {
    return frequencies.unaryExpr([&](double f) { return 0.5 * circle(f / cutoff_); });
  }

 private:
  double cutoff_, ripple_;
};

}  // namespace

TEST_F(Pictures, ModulationTransferIsTheModulusOverDirections) {
  const double cutoff = 2 * PlotScene::kRadius / (PlotScene::kWavelength * PlotScene::kFocalLength);
  const KnownTransfer ideal(cutoff, 0), target(cutoff, 0), fitted(cutoff, 0.4);
  const std::optional<internal::Picture> mtf = internal::mtf_picture(scene()->shown(ideal, &target, fitted));
  ASSERT_TRUE(mtf);
  std::istringstream lines(mtf->data.at(0).second);
  int count = 0;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("#")) continue;
    ++count;
    double f, of_ideal, of_target, mean, least, most;
    std::istringstream(line) >> f >> of_ideal >> of_target >> mean >> least >> most;
    const double circle = KnownTransfer::circle(f / cutoff);
    // The ring of lags extends half a lag to either side, 1/512 of the cut-off, over which the function
    // changes by 4/pi of that. The first rings have few lags.
    const double ring = 1.3 / 512;
    EXPECT_NEAR(of_ideal, circle, ring) << f;
    EXPECT_NEAR(of_target, 0.5 * circle, kPrinted) << f;
    if (f < 0.02 * cutoff) continue;
    EXPECT_NEAR(mean, 0.8 * circle, 2 * ring) << f;
    EXPECT_NEAR(least, 0.6 * circle, 2 * ring) << f;
    EXPECT_NEAR(most, circle, 2 * ring) << f;
  }
  EXPECT_EQ(count, 301);
}

TEST_F(Pictures, SurfaceMapAndCutsShowTheSurfaceAndNothingOutsideTheAperture) {
  PlotScene annulus(AnnulusAperture{2 * PlotScene::kRadius, 0.1, 0}, 2000);
  const fs::path folder = root() / "annulus";
  // The truth has waves and spherical terms only, which are short to write.
  annulus.result.fitted.fit.coefficients.head(annulus.result.fitted.terms.fourier_begin()).setZero();
  const TermSet truth_terms{
      PlotScene::kRadius, {}, annulus.result.fitted.terms.fourier, annulus.result.fitted.terms.spherical};
  const Eigen::VectorXd truth_coefficients = annulus.result.fitted.fit.coefficients.tail(
      annulus.result.fitted.terms.size() - annulus.result.fitted.terms.fourier_begin());
  const Truth truth{truth_terms, truth_coefficients};
  const Path no_gnuplot("/nonexistent");
  annulus.write(folder.string(), nullptr);

  const auto map = rows(folder / "plots" / "surface.dat");
  ASSERT_EQ(map.size(), std::size_t(PlotScene::kGrid));
  constexpr double kHeight =
      1e-13;  // operator error: 1e-12 of 100 nm and less; printing: six digits of 300 nm
  constexpr double kLargest = 4e-7;
  int inside = 0;
  for (int j = 0; j < PlotScene::kGrid; ++j) {
    ASSERT_EQ(map[std::size_t(j)].size(), std::size_t(PlotScene::kGrid));
    for (int i = 0; i < PlotScene::kGrid; ++i) {
      const double x = PlotScene::line(i), y = PlotScene::line(j), rho = std::hypot(x, y);
      const double value = map[std::size_t(j)][std::size_t(i)];
      if (rho > PlotScene::kRadius * (1 + 1e-6) || rho < 0.05 * (1 - 1e-6)) {
        EXPECT_TRUE(std::isnan(value)) << x << " " << y;
      } else if (rho < PlotScene::kRadius * (1 - 1e-6) && rho > 0.05 * (1 + 1e-6)) {
        ++inside;
        EXPECT_NEAR(value, truth.height(x, y), kHeight + kPrintedMap * kLargest) << x << " " << y;
      }
    }
  }
  EXPECT_GT(inside, 10000);

  const auto cuts = rows(folder / "plots" / "profile.dat");
  ASSERT_EQ(cuts.size(), std::size_t(PlotScene::kGrid));
  for (int i = 0; i < PlotScene::kGrid; ++i) {
    const double t = PlotScene::line(i);
    const auto& row = cuts[std::size_t(i)];
    EXPECT_NEAR(row[0], t, kPrinted);
    if (std::abs(t) < 0.05 * (1 - 1e-6)) {
      EXPECT_TRUE(std::isnan(row[1]) && std::isnan(row[2]) && std::isnan(row[3]) && std::isnan(row[4])) << t;
    } else if (std::abs(t) > 0.05 * (1 + 1e-6)) {
      EXPECT_NEAR(row[1], truth.height(t, 0), kHeight) << t;
      EXPECT_NEAR(row[2], truth.height(0, t), kHeight) << t;
      EXPECT_NEAR(row[3], truth.slope(t, 0, true), 1e-11) << t;
      EXPECT_NEAR(row[4], truth.slope(0, t, false), 1e-11) << t;
    }
  }
}

TEST_F(Pictures, MissingGnuplotIsAWarningThatSaysWhatToDo) {
  const fs::path folder = root() / "without";
  fs::create_directories(folder / "plots");
  std::ofstream(folder / "plots" / "surface.png") << "of an earlier run";
  const Path no_gnuplot("/nonexistent:");
  Warnings found;
  PlotScene all(CircleAperture{0.4, 0}, 2000);
  all.result.judgement.character = sample_character();
  EXPECT_TRUE(all.write(folder.string(), &found).empty());
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].code, "no-gnuplot");
  for (const char* word : {"not on PATH", "Install gnuplot", "gnuplot NAME.gp"})
    EXPECT_NE(found[0].message.find(word), std::string::npos) << found[0].message;
  EXPECT_FALSE(fs::exists(folder / "plots" / "surface.png"));
  for (const std::string& name : kNames) EXPECT_TRUE(fs::exists(folder / "plots" / (name + ".gp"))) << name;
}

TEST_F(Pictures, FailingGnuplotIsAWarningWithItsOwnWords) {
  const fs::path folder = root() / "failing", tools = root() / "tools";
  fs::create_directories(tools);
  std::ofstream(tools / "gnuplot")
      << "#!/bin/sh\necho half > surface.png\necho 'unknown terminal pngcairo' >&2\nexit 3\n";
  fs::permissions(tools / "gnuplot", fs::perms::owner_all);
  const Path path(tools.string() + ":/bin");
  Warnings found;
  EXPECT_TRUE(PlotScene(CircleAperture{0.4, 0}, 2000).write(folder.string(), &found).empty());
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].code, "no-gnuplot");
  EXPECT_NE(found[0].message.find("unknown terminal pngcairo"), std::string::npos) << found[0].message;
}

TEST_F(Pictures, GnuplotThatDoesNotEndIsStopped) {
  const std::string gnuplot = internal::find_gnuplot();
  if (gnuplot.empty()) GTEST_SKIP() << "no gnuplot";
  const fs::path folder = root() / "endless";
  fs::create_directories(folder);
  std::ofstream(folder / "endless.gp") << "while (1) { print 'on and on' }\n";
  EXPECT_EQ(internal::run_gnuplot(gnuplot, folder.string(), "endless.gp", std::chrono::seconds(1)),
            "it did not end within 1 s");
}

TEST_F(Pictures, TicsOfARangeWithoutLogarithmAreGnuplotsOwn) {
  EXPECT_EQ(internal::log_tics(0, 5), "autofreq");
  EXPECT_EQ(internal::log_tics(-1, 5), "autofreq");
  EXPECT_EQ(internal::log_tics(1, std::numeric_limits<double>::infinity()), "autofreq");
  EXPECT_EQ(internal::log_tics(1, 5), "(1, 1.2, 1.5, 2, 2.5, 3, 4, 5)");
  EXPECT_NE(internal::log_tics(1e-7, 1e6).find("\"10⁻⁶\" 1e-06, \"\" 2e-06 1, "), std::string::npos);
}

TEST_F(Pictures, WithoutRoughnessOrFitShowWhatThereIs) {
  PlotScene bare(CircleAperture{0.4, 0}, 4000);
  bare.target = RayBundle{};
  bare.result.has_roughness = false;
  bare.result.fitted.fit.coefficients.resize(0);
  bare.result.fitted.targets.clear();
  bare.focal_sigma = 0;
  const fs::path folder = root() / "bare";
  Warnings found;
  bare.psd.reset();
  const std::vector<DrawnPicture> pictures = bare.write(folder.string(), &found);
  if (has_gnuplot()) {
    EXPECT_TRUE(found.empty()) << found[0].message;
    EXPECT_EQ(pictures.size(), 3u);  // no surface, profile, slopes or coefficients
  }
  EXPECT_TRUE(std::isnan(rows(folder / "plots" / "ee_curves.dat")[100][2]));
  EXPECT_FALSE(fs::exists(folder / "plots" / "focal_images_target_focus.dat"));
  EXPECT_FALSE(fs::exists(folder / "plots" / "surface.gp"));
}
