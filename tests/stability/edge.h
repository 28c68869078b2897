#pragma once
#include <functional>
#include <limits>
#include <string>
#include <vector>

namespace aberfit::test {

/// One step of a sweep to an edge and past it. Errors and promises in the unit of the edge.
struct EdgeRow {
  double parameter = 0;  ///< > 0
  double error = 0;      ///< of what the program returned; NaN where it returned no value
  double promised = 0;   ///< largest error that a header, a warning-free result or a page allows here
  bool told = false;     ///< the program refused, warned, or set a status that says so
  /// Error of the textbook method, if there is one, which the program avoids.
  double avoided = std::numeric_limits<double>::quiet_NaN();
};

/// How the failing method fails: error(parameter) within a factor, for parameters in [from, to].
struct EdgeLaw {
  std::string text;
  std::function<double(double)> error;
  double from = 0, to = 0;
  double factor = 2;
};

/// A sweep of one method to the point where it fails, and beyond.
class Edge {
 public:
  /// name: name of the files, as the test is called; the others label the axes, with their units.
  Edge(std::string name, std::string parameter, std::string error);

  /// Makes the parameter axis of the picture linear instead of logarithmic.
  void linear_parameter() { linear_ = true; }
  void add(const EdgeRow& row) { rows_.push_back(row); }
  /// Adds a law that the error must follow, with at least three rows in its range. It holds for the avoided
  /// way if there is one, else for the program's own error. At least one law is required.
  void follows(EdgeLaw law) { laws_.push_back(std::move(law)); }

  /// Fails the test unless all of this holds. Wherever the error exceeds its promise, the program says so.
  /// The edge is reached: some row is reported, exceeds its promise, or its avoided way does; a sweep that
  /// never fails proves nothing. Some row is not reported, because a program that always warns says nothing.
  /// The laws hold.
  void judge() const;
  /// Calls judge(), and writes <name>.csv beside the test program. <name>.svg goes into the folder that the
  /// environment variable ABERFIT_STABILITY_PICTURES names.
  void expect() const;

 private:
  void expect_law(const EdgeLaw& law) const;
  void write_table(const std::string& folder) const;
  void draw(const std::string& scratch, const std::string& folder) const;
  std::string points(const std::function<double(const EdgeRow&)>& value,
                     const std::function<bool(const EdgeRow&)>& wanted) const;

  std::string name_, parameter_, error_;
  bool linear_ = false;
  std::vector<EdgeRow> rows_;
  std::vector<EdgeLaw> laws_;
};

/// `count` numbers from first to last, both > 0, with equal ratios.
std::vector<double> geometric_steps(double first, double last, int count);

}  // namespace aberfit::test
