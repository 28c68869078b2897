#include "edge.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "../../src/report/gnuplot.h"

namespace aberfit::test {
namespace {

constexpr double kLowestDrawn = 1e-17;  // errors of zero have no place on a logarithmic axis

double failing(const EdgeRow& row) { return std::isnan(row.avoided) ? row.error : row.avoided; }
bool exceeds(const EdgeRow& row) { return !(row.error <= row.promised); }

}  // namespace

Edge::Edge(std::string name, std::string parameter, std::string error)
    : name_(std::move(name)), parameter_(std::move(parameter)), error_(std::move(error)) {}

void Edge::judge() const {
  bool reached = false, quiet = false;
  double largest = 0;
  for (const EdgeRow& row : rows_) {
    EXPECT_FALSE(exceeds(row) && !row.told)
        << name_ << ": at " << parameter_ << " = " << row.parameter << " the error is " << row.error
        << " without a word; promised: " << row.promised;
    reached = reached || row.told || exceeds(row) || row.avoided > row.promised;
    quiet = quiet || !row.told;
    if (!row.told) largest = std::max(largest, row.error);
  }
  EXPECT_GE(rows_.size(), 5u) << name_ << ": too few steps for a sweep";
  EXPECT_TRUE(reached) << name_ << ": the sweep never came to the edge";
  EXPECT_TRUE(quiet) << name_ << ": every step was told, so that the word says nothing";
  for (const EdgeLaw& law : laws_) expect_law(law);
  fmt::print("{}: largest error without a word {:.3g}\n", name_, largest);
  ::testing::Test::RecordProperty(name_, fmt::format("{:.3g}", largest));
}

void Edge::expect() const {
  judge();
  const std::string scratch = ABERFIT_STABILITY_SCRATCH;
  std::filesystem::create_directories(scratch);
  write_table(scratch);
  if (const char* folder = std::getenv("ABERFIT_STABILITY_PICTURES")) draw(scratch, folder);
}

void Edge::expect_law(const EdgeLaw& law) const {
  int seen = 0;
  double least = std::numeric_limits<double>::infinity(), most = 0;
  for (const EdgeRow& row : rows_) {
    if (row.parameter < law.from || row.parameter > law.to) continue;
    const double ratio = failing(row) / law.error(row.parameter);
    ++seen;
    least = std::min(least, ratio), most = std::max(most, ratio);
    EXPECT_TRUE(ratio >= 1 / law.factor && ratio <= law.factor)
        << name_ << ": at " << parameter_ << " = " << row.parameter << " the error is " << failing(row)
        << ", by the law '" << law.text << "' " << law.error(row.parameter) << ", allowed a factor "
        << law.factor;
  }
  EXPECT_GE(seen, 3) << name_ << ": too few steps for the law '" << law.text << "'";
  fmt::print("{}: {}, measured {:.3g} to {:.3g} of it\n", name_, law.text, least, most);
}

void Edge::write_table(const std::string& folder) const {
  std::ofstream file(std::filesystem::path(folder) / (name_ + ".csv"));
  file << "# " << parameter_ << " | " << error_ << "\nparameter,error,promised,told,avoided\n";
  for (const EdgeRow& row : rows_)
    file << fmt::format("{:.6g},{:.6g},{:.6g},{:d},{:.6g}\n", row.parameter, row.error, row.promised,
                        row.told, row.avoided);
  EXPECT_TRUE(file.good()) << "cannot write " << folder;
}

std::string Edge::points(const std::function<double(const EdgeRow&)>& value,
                         const std::function<bool(const EdgeRow&)>& wanted) const {
  std::string text;
  for (const EdgeRow& row : rows_)
    if (wanted(row) && std::isfinite(value(row)))
      text += fmt::format("{:.4g} {:.4g}\n", row.parameter, std::max(value(row), kLowestDrawn));
  return text;
}

void Edge::draw(const std::string& scratch, const std::string& folder) const {
  const std::string gnuplot = internal::find_gnuplot();
  if (gnuplot.empty()) {
    ADD_FAILURE() << "ABERFIT_STABILITY_PICTURES is set, and gnuplot is not on PATH: install gnuplot";
    return;
  }
  const auto error = [](const EdgeRow& row) { return row.error; };
  std::string blocks, curves;
  const auto curve = [&](const std::string& data, const std::string& style, const std::string& title) {
    if (data.empty()) return;
    const std::string block = fmt::format("$curve{}", blocks.size());
    blocks += fmt::format("{} << END\n{}END\n", block, data);
    curves += fmt::format("{}{} with {} title \"{}\"", curves.empty() ? "" : ", ", block, style, title);
  };
  curve(points([](const EdgeRow& row) { return row.avoided; }, [](const EdgeRow&) { return true; }),
        "linespoints lc rgb '#a0a0a0' pt 2 ps 0.5", "way not taken");
  curve(points([](const EdgeRow& row) { return row.promised; }, [](const EdgeRow&) { return true; }),
        "lines lc rgb '#202020' lw 1.5", "promise");
  for (const EdgeLaw& law : laws_) {
    std::string line;
    for (const double at : geometric_steps(law.from, law.to, 17))
      line += fmt::format("{:.4g} {:.4g}\n", at, law.error(at));
    curve(line, "lines dt 2 lw 2 lc rgb '#c06000'", law.text);
  }
  curve(points(error, [](const EdgeRow& row) { return !row.told; }), "points pt 7 ps 0.6 lc rgb '#1060b0'",
        "without a word");
  curve(points(error, [](const EdgeRow& row) { return row.told; }), "points pt 6 ps 0.9 lc rgb '#c00000'",
        "told");
  // Rows without a value get a mark at the upper edge of the error axis.
  std::string refused;
  for (const EdgeRow& row : rows_)
    if (row.told && !std::isfinite(row.error))
      refused += fmt::format("set label at first {:.4g}, graph 0.97 point pt 11 ps 0.7 lc rgb '#c00000'\n",
                             row.parameter);
  const std::filesystem::path script = std::filesystem::path(scratch) / (name_ + ".gp");
  std::ofstream(script) << fmt::format(
      "set terminal svg size 560,380 font 'sans,11' noenhanced\nset output '{}'\n"
      "set logscale {}\nset format y '1e%T'\nset key below samplen 2\nset bmargin 6\nunset mxtics\nunset "
      "mytics\n"
      "set xlabel \"{}\"\nset ylabel \"{}\"\n{}{}plot {}\n",
      (std::filesystem::absolute(folder) / (name_ + ".svg")).string(), linear_ ? "y" : "xy", parameter_,
      error_, refused, blocks, curves);
  EXPECT_EQ(internal::run_gnuplot(gnuplot, scratch, script.filename().string()), "");
}

std::vector<double> geometric_steps(double first, double last, int count) {
  std::vector<double> steps;
  for (int i = 0; i < count; ++i) steps.push_back(first * std::pow(last / first, double(i) / (count - 1)));
  return steps;
}

}  // namespace aberfit::test
