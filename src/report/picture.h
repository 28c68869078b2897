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

/// One picture before it is drawn: a script of src/report/pictures with the values and data files it reads.
struct Picture {
  /// study: its title. script_name: empty where it is that of the picture.
  Picture(std::string picture_name, const std::string& study, const std::string& script_name = "");

  std::string name, script;
  std::string title;       ///< instead of the script's where it is not empty
  bool has_cloud = false;  ///< thousands of points: PNG unless a format is asked for
  std::string values;      ///< of NAME.values
  std::vector<std::pair<std::string, std::string>> data;  ///< file name, text

  /// Variables of the script: a number, a count, a text, and arrays of numbers and texts.
  void set(const std::string& variable, double value);
  void set(const std::string& variable, int value);
  void set(const std::string& variable, const std::string& text);
  void set(const std::string& variable, const char* text) { set(variable, std::string(text)); }
  void set(const std::string& variable, const std::vector<double>& numbers);
  void set(const std::string& variable, const std::vector<std::string>& texts);
  /// `axis`_scale and `axis`_unit.
  void set(const std::string& axis, const AxisUnit& unit);

  /// Adds a data file: the sentences of `header` as comments, then one row per entry of the columns, 9
  /// digits; several blocks for gnuplot's `index`.
  void add_columns(const std::string& file, const std::vector<std::string>& header,
                   const PictureColumns& columns);
  void add_blocks(const std::string& file, const std::vector<std::string>& header,
                  const std::vector<PictureColumns>& blocks);
  /// Adds one of gnuplot's `matrix` kind: row by row, 6 digits.
  void add_matrix(const std::string& file, const std::vector<std::string>& header,
                  const Eigen::ArrayXXd& matrix);
  /// Where the points of a matrix lie [m], for the scripts' `pixel_axes`.
  void set_pixels(double x_first, double x_pitch, double y_first, double y_pitch);
  /// Adds NAME_rim.dat, the outlines of a clear aperture moved by (dx, dy) [m], a block each, and sets
  /// `rims`.
  void add_rim(const ClearRegion& clear, double dx, double dy);
};

/// Writes data and scripts below `directory`/plots and draws them.
std::vector<DrawnPicture> draw(const std::vector<Picture>& pictures, const std::string& directory,
                               const PictureOptions& options, Warnings* warnings);

/// The unit in which `largest` [m] or [rad] has few digits before the point.
AxisUnit length_unit(double largest);
AxisUnit angle_unit(double largest);

/// format_quantity with the micro sign.
std::string display(double value, Dimension dimension);

/// gnuplot string literal of any text, which ends where the text ends. Grave accents, between which gnuplot
/// takes a command of the shell, become apostrophes, control characters blanks.
std::string gnuplot_text(const std::string& text);

/// gnuplot's commands, for `eval`, that make `axis` ("x", "y", "cb") one of logarithms from `low` to `high`
/// in its unit. Two numbers stand at it at least on any range of a quarter of a decade.
std::string log_axis(const std::string& axis, double low, double high);
/// The tics of that axis: `(1, 2, 5)`; `autofreq`, gnuplot's own choice, of a range without logarithm.
std::string log_tics(double low, double high);

/// Largest absolute value; NaN and infinity do not count, and 0 where nothing else is there.
double largest_size(const Eigen::ArrayXXd& values);
/// How far colours of a map reach: the absolute value that 99.9 % of the finite values do not exceed, so that
/// a spike takes the last colour, not all the others. At least 1e-15.
double colour_reach(const std::vector<const Grid*>& maps);

Eigen::ArrayXd array_of(const std::vector<double>& values);

}  // namespace aberfit::internal
