#pragma once
#include <Eigen/Core>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "aberfit/core/units.h"
#include "aberfit/core/warning.h"
#include "aberfit/measured/clear_aperture.h"
#include "aberfit/measured/height_map.h"
#include "aberfit/report/drawn_picture.h"

namespace aberfit::internal {

/// A unit of an axis: SI value * per_si = number on the axis.
struct AxisUnit {
  double per_si = 1;
  std::string name;
  /// "x [mm]".
  std::string label(const std::string& what) const { return what + " [" + name + "]"; }
};

using PictureColumns = std::vector<Eigen::ArrayXd>;

/// A picture before it is drawn: a script of src/report/pictures with the values and data files that it
/// reads.
struct Picture {
  /// study: its title. script_name: empty if it is the name of the picture.
  Picture(std::string picture_name, const std::string& study, const std::string& script_name = "");

  std::string name, script;
  std::string title;       ///< replaces the script's title if not empty
  bool has_cloud = false;  ///< thousands of points: PNG unless a format is requested
  std::string values;      ///< content of NAME.values
  std::vector<std::pair<std::string, std::string>> data;  ///< file name, text

  /// Sets a variable of the script: a number, a count, a text, or an array of numbers or texts.
  void set(const std::string& variable, double value);
  void set(const std::string& variable, int value);
  void set(const std::string& variable, const std::string& text);
  void set(const std::string& variable, const char* text) { set(variable, std::string(text)); }
  void set(const std::string& variable, const std::vector<double>& numbers);
  void set(const std::string& variable, const std::vector<std::string>& texts);
  /// Sets `axis`_scale and `axis`_unit.
  void set(const std::string& axis, const AxisUnit& unit);

  /// Adds a data file: `header` as comments, then one row per entry of the columns with 9 digits. Blocks are
  /// for gnuplot's `index`.
  void add_columns(const std::string& file, const std::vector<std::string>& header,
                   const PictureColumns& columns);
  void add_blocks(const std::string& file, const std::vector<std::string>& header,
                  const std::vector<PictureColumns>& blocks);
  /// Adds a data file for gnuplot's `matrix`: row by row, 6 digits.
  void add_matrix(const std::string& file, const std::vector<std::string>& header,
                  const Eigen::ArrayXXd& matrix);
  /// Sets the positions [m] of the points of a matrix for the scripts' `pixel_axes`.
  void set_pixels(double x_first, double x_pitch, double y_first, double y_pitch);
  /// Adds NAME_rim.dat, the outlines of a clear aperture shifted by (dx, dy) [m], one block each; sets
  /// `rims`.
  void add_rim(const ClearRegion& clear, double dx, double dy);
};

/// Writes data and scripts below `directory`/plots and draws them.
std::vector<DrawnPicture> draw(const std::vector<Picture>& pictures, const std::string& directory,
                               const PictureOptions& options, Warnings* warnings);

/// The unit in which `largest` [m] or [rad] has few digits before the point.
AxisUnit length_unit(double largest);
AxisUnit angle_unit(double largest);

/// Text of format_quantity with the micro sign.
std::string display(double value, Dimension dimension);

/// gnuplot string literal of any text, safe against a premature end. Grave accents, which enclose a shell
/// command in gnuplot, become apostrophes; control characters become blanks.
std::string gnuplot_text(const std::string& text);

/// gnuplot commands, for `eval`, that make `axis` ("x", "y", "cb") logarithmic from `low` to `high` in its
/// unit. A range of at least a quarter of a decade has at least two numbers.
std::string log_axis(const std::string& axis, double low, double high);
/// The tics of that axis: `(1, 2, 5)`, or gnuplot's `autofreq` for a range without logarithm.
std::string log_tics(double low, double high);

/// Largest finite absolute value; 0 if there is none.
double largest_size(const Eigen::ArrayXXd& values);
/// Range of the colours of a map: the absolute value that 99.9 % of the finite values do not exceed, so that
/// a spike does not stretch the scale. At least 1e-15.
double colour_reach(const std::vector<const Grid*>& maps);

Eigen::ArrayXd array_of(const std::vector<double>& values);

}  // namespace aberfit::internal
