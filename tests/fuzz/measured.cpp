// Every format of measured files. Beside good errors the readers promise that a map has no more points than
// its file can hold, and that values are finite or NaN.
#include <cmath>

#include "aberfit/measured/clear_aperture.h"
#include "aberfit/measured/read_measurement.h"
#include "aberfit/measured/write_map.h"
#include "harness.h"
#include "measured/packed_files.h"
#include "measured/synthetic_files.h"
#include "targets.h"

namespace aberfit::test {
namespace {

constexpr std::size_t kDeflate = 1032;  // most bytes that deflate makes of one
// Points in columns x, y, z fill at least a hundredth of their grid and take at least 6 bytes ("0 0 0" and
// its end).
constexpr std::size_t kSparse = 100 / 5;

void require_values(const Measurement& data, std::size_t most) {
  if (const auto* map = std::get_if<HeightMap>(&data)) {
    require(std::size_t(map->height.size()) <= most, "a map fits in its file");
    for (const double h : map->height.reshaped()) require(!std::isinf(h), "heights are finite or NaN");
    require(map->pitch_x >= 0 && map->pitch_y >= 0, "a pitch is not negative");
  } else {
    const Profile& profile = std::get<Profile>(data);
    require(std::size_t(profile.size()) <= most && profile.size() == profile.value.size(),
            "a profile fits in its file");
    for (Eigen::Index i = 1; i < profile.size(); ++i)
      require(profile.x[i] > profile.x[i - 1], "positions ascend");
  }
}

// Reads the file as a user would who follows the message about missing facts, and once with all facts given.
void read_file(const std::string& path, MeasuredFormat format, std::size_t most) {
  detect_format(path);
  MeasuredSource source;
  source.path = path;
  source.format = format;
  const auto read = [&] { require_values(read_measurement(source), most); };
  if (read_or_refuse(read)) return;
  missing_facts(source);
  source.quantity = ProfileQuantity::kSlope;
  source.wavefront = true;
  source.pitch = 1e-3;
  source.wavelength = 633e-9;
  const bool text = format == MeasuredFormat::kProfileText || format == MeasuredFormat::kMapText;
  if (text) source.x_factor = 1e-3;
  if (text || format == MeasuredFormat::kFits || format == MeasuredFormat::kDatx) source.value_factor = 1e-9;
  if (format == MeasuredFormat::kNpy) source.value_factor = 1e-9;
  if (format == MeasuredFormat::kFits) source.hdu = "0";
  if (format == MeasuredFormat::kFits || format == MeasuredFormat::kNpy) source.plane = 1;
  if (format == MeasuredFormat::kMapText) source.columns = 4, source.bottom_first = true;
  read_or_refuse(read);
}

void read_one_file(MeasuredFormat format, std::string_view bytes) {
  const bool packed = format == MeasuredFormat::kX3p || format == MeasuredFormat::kDatx ||
                      format == MeasuredFormat::kFourD || bytes.starts_with("\x1f\x8b");
  const std::size_t points_per_byte = packed ? kDeflate : format == MeasuredFormat::kMapText ? kSparse : 1;
  read_file(fuzz_folder().write("input", bytes), format, bytes.size() * points_per_byte);
}

// The bytes are the metadata, a zero byte, and the numbers.
void read_dabam_pair(std::string_view bytes) {
  const std::size_t cut = bytes.find('\0');
  const std::string path = fuzz_folder().write("pair.txt", bytes.substr(0, cut));
  fuzz_folder().write("pair.dat", cut == std::string_view::npos ? std::string_view() : bytes.substr(cut + 1));
  read_file(path, MeasuredFormat::kDabam, bytes.size());
}

void read_mask_file(std::string_view bytes) {
  const std::string path = fuzz_folder().write("mask", bytes);
  const std::size_t most = bytes.size() * (bytes.starts_with("\x1f\x8b") ? kDeflate : 1);
  read_or_refuse([&] { require(std::size_t(read_mask(path).size()) <= most, "a mask fits in its file"); });
}

HeightMap small_map() {
  HeightMap map;
  map.height = Grid(6, 7);
  for (Eigen::Index i = 0; i < map.height.size(); ++i)
    map.height.data()[i] = 1e-9 * std::sin(1.7 * double(i) + 0.3);
  map.height(1, 2) = std::nan("");
  map.pitch_x = map.pitch_y = 1e-3;
  centre_on_grid(&map);
  map.label = "small";
  return map;
}

std::string bytes_of_synthetic(const char* name) {
  return bytes_of(std::filesystem::path(ABERFIT_TEST_DATA) / "synthetic" / name);
}

std::vector<std::string> dabam_seeds() {
  DabamFile plain;
  plain.rows = {{0, 1}, {1, -2.5}, {2, 3}, {3.5, 1e-1}};
  DabamFile pairs = plain;
  pairs.format = 4, pairs.header = {"made"}, pairs.separator = "\t";
  pairs.keys = R"("X1_FACTOR": 1e-3, "Y1_FACTOR": 1e-9, "X2_FACTOR": 1e-3, "Y2_FACTOR": 1e-9)";
  for (auto& row : pairs.rows) row.insert(row.end(), {row[0], row[1] + 1});
  std::vector<std::string> seeds;
  for (const DabamFile& file : {plain, pairs}) seeds.push_back(file.metadata() + '\0' + file.numbers());
  return seeds;
}

std::vector<std::string> profile_seeds() {
  return {"# x [mm], height [nm]\n0, 1.5\n1, -2\n2, 0.25\n3, 1\n",
          "x_mm;slope_urad\n0;1\n0.5;nan\n1;2\n2;3\n", "0 1 2\r\n1 2 3\r\n2 3 4\r\n",
          "1,5\t2,25\n2,5\t3\n3,5\t-1e-3\n", "X;Z\n[mm];[nm]\n\"0\";\"1\"\n0.1;2\n0.1;4\n"};
}

std::vector<std::string> map_seeds() {
  return {"1 2 3 4\n5 nan 7 8\n9 10 11 12\n",
          "x,y,z\n0,0,1\n1,0,2\n0,1,3\n1,1,4\n",
          map_csv(small_map()),
          "# unit nm\n1;2;3\n4;--;6\n7;8;9\n",
          "# Width: 3 mm\n# Height: 2 mm\n# Value units: m\n1 2 3\n4 5 7\n",
          "0 1 2 3 4\n1 5 2 9 4\n2 6 1 7 3\n3 4 8 1 2\n4 1 2 3 3\n"};
}

std::vector<std::string> zygo_text_seeds() {
  const std::string header =
      " - Format 2\n1 8 3 5 \"date\"\n0 0 2 1 1 255\n4 0 3 2\n\"a\"\n\"b\"\n\"c\"\n"
      "0 0.5 6.328e-007 0 1 0 2.5e-04 1\n640 480 0 0 0 0 \"\"\n0 1 10 5 0 0 0.1 0 2 50\n"
      "1 0 20 0 60 1 0 0 0\n0 \"\"\n1 0\n#\n";
  return {"Zygo XYZ Data File" + header + "4 0 0.5\n5 0 No Data\n6 0 1\n4 1 2\n5 1 1e-3\n6 1 0\n#\n",
          "Zygo ASCII Data File" + header + "12 13\n#\n5 -4 2147483640\n7 8 9\n#\n"};
}

std::vector<std::string> wyko_text_seeds() {
  const std::string header =
      "X Size\t2\nY Size\t3\nBlock Name\tType\tLength\tValue\nTitle\t5\t9\tflat\nWavelength\t7\t4\t632.8\n"
      "Mult\t6\t2\t4\nAspect\t7\t4\t0.5\nPixel_size\t7\t4\t0.25\n";
  return {"Wyko ASCII Data File Format 0\t0\t1\n" + header + "RAW_DATA\t3\t24\t\n1\tBad\t3\n4\t5\t6\n",
          "Wyko ASCII Data File Format 0\t1\t1\n" + header +
              "Intensity\t3\t24\t\n1 2 3\n4 5 6\nOPD\t3\t24\t\n1\t2\t3\n4\t5\t6\n"};
}

std::vector<std::string> dftfringe_seeds() {
  return {
      "3\n3\n0 0.5 0\n0.25 1 2\n0 -1 0\noutside ellipse 1 1 1.5 1.5\nobstruction 1 1 0.2\nDIAM 200\n"
      "ROC 1600\nLambda 550\n",
      "2\n2\n1\n2\n3\n4\nLambda 632.8\n"};
}

std::vector<std::string> zygo_seeds() {
  MetroProFile second;
  second.magic = 0x881B0371, second.header_bytes = 4096, second.phase_resolution = 2, second.sign = 1;
  MetroProFile frames;
  frames.intensity_width = 3, frames.intensity_height = 2, frames.frames = 2;
  return {MetroProFile().bytes(), frames.bytes(), second.bytes()};
}

std::vector<std::string> codev_seeds() {
  return {codev_int_text(small_map(), 633e-9, "small"),
          "! comment\ntitle\nGRD 3 2 WFR WVL 0.5 SSZ 100 NDA 99 XSC 2\n1 2 3\n4 99 6\n"};
}

std::vector<std::string> fits_seeds() {
  const std::string image = fits_opd_bytes(small_map());
  std::string integers = image;  // 16 bits with scale and blank value: other branches of the reader
  integers.replace(integers.find("-64"), 3, " 16");
  std::string cube = image;  // with a single plane
  cube.replace(cube.find("NAXIS   =                    2"), 30, "NAXIS   =                    3");
  cube.replace(cube.find("EXTEND  =                    T"), 30, "NAXIS3  =                    1");
  return {image, integers, cube, gzip_of(image)};
}

std::vector<std::string> npy_seeds() {
  std::vector<std::string> seeds;
  for (const char* header : {"{'descr': '<f8', 'fortran_order': False, 'shape': (2, 3), }",
                             "{'descr': '>i2', 'fortran_order': True, 'shape': (2, 2, 3), }",
                             "{'descr': '|u1', 'fortran_order': False, 'shape': (3, 4), }"}) {
    std::string text = header;
    text += std::string(117 - text.size(), ' ') + "\n";
    std::string numbers;
    for (char i = 0; i < 48; ++i) numbers += i % 8 == 7 ? '?' : i;
    seeds.push_back("\x93NUMPY\x01" + std::string(1, '\0') + little(text.size(), 2) + text + numbers);
  }
  return seeds;
}

// Members at the top, in a folder, and of another kind.
std::vector<std::string> x3p_seeds() {
  std::vector<std::string> seeds = {bytes_of_synthetic("marker-counts.x3p"),
                                    bytes_of_synthetic("marker-double.x3p")};
  seeds.push_back(zip_of({{"part/main.xml", "<ISO5436_2/>"}, {"__MACOSX/part/._main.xml", "a"}}));
  seeds.push_back(zip_of({{"xl/workbook.xml", "<a/>"}}));
  return seeds;
}

std::vector<std::string> sag_seeds() {
  GridSag sag;
  sag.map = small_map();
  sag.dx = sag.dy = sag.dxdy = Grid::Zero(6, 7);
  return {zemax_grid_sag_text(sag, "small")};
}

FuzzTarget of_format(const char* name, MeasuredFormat format, std::function<std::vector<std::string>()> seeds,
                     std::size_t longest) {
  return {name, [format](std::string_view bytes) { read_one_file(format, bytes); }, std::move(seeds),
          longest};
}

FuzzTarget of_format(const char* name, MeasuredFormat format, std::vector<const char*> files,
                     std::size_t longest) {
  return of_format(
      name, format,
      [files] {
        std::vector<std::string> seeds;
        for (const char* file : files) seeds.push_back(bytes_of_synthetic(file));
        return seeds;
      },
      longest);
}

}  // namespace

std::vector<FuzzTarget> measured_targets() {
  using enum MeasuredFormat;
  const auto mask_seeds = [] {
    return std::vector<std::string>{"0 1 1\n1 0 nan # left out\n", fits_opd_bytes(small_map())};
  };
  return {
      {"dabam", read_dabam_pair, dabam_seeds, 4096},
      of_format("profile", kProfileText, profile_seeds, 2048),
      of_format("map", kMapText, map_seeds, 2048),
      of_format("zygo", kZygo, zygo_seeds, 5000),
      of_format("codev", kCodeVInt, codev_seeds, 2048),
      of_format("fits", kFits, fits_seeds, 6000),
      of_format("grid-sag", kZemaxGridSag, sag_seeds, 4096),
      of_format("zygo-text", kZygoText, zygo_text_seeds, 2048),
      of_format("wyko-text", kWykoText, wyko_text_seeds, 2048),
      of_format("dftfringe", kDftfringe, dftfringe_seeds, 1024),
      of_format("opd", kOpd, {"marker-counts.opd", "marker-float.opd"}, 2048),
      of_format("sdf", kSdf, {"marker-bcr.sdf", "marker-iso1.sdf", "marker-iso2.sdf", "marker-text.sdf"},
                4096),
      of_format("x3p", kX3p, x3p_seeds, 8192),
      of_format("datx", kDatx,
                {"marker-fringes.datx", "marker-nm.datx", "link.datx", "outside.datx", "other.h5"}, 16384),
      of_format("4d", kFourD, {"marker-4d.h5", "marker-4d-packed.h5", "marker-4d-focus.h5", "other.h5"},
                8192),
      of_format("npy", kNpy, npy_seeds, 1024),
      {"mask", read_mask_file, mask_seeds, 6000}};
}

}  // namespace aberfit::test
