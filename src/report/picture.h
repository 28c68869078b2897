#pragma once
#include <Eigen/Core>
#include <string>
#include <utility>
#include <vector>

#include "aberfit/core/units.h"
#include "aberfit/report/plots.h"

namespace aberfit::internal {

/// One picture before it is drawn: a gnuplot script `name`.gp that makes `name`.png, and the data files it
/// reads.
struct Picture {
  std::string name;
  std::string script;
  std::vector<std::pair<std::string, std::string>> data;  ///< file name, text

  /// Adds a data file: the sentences of `header` as comments, then one row per entry of the columns, 9
  /// digits.
  void add_columns(const std::string& file, const std::vector<std::string>& header,
                   const std::vector<Eigen::ArrayXd>& columns);
  /// Adds one of gnuplot's `matrix` kind: row by row, 6 digits.
  void add_matrix(const std::string& file, const std::vector<std::string>& header,
                  const Eigen::ArrayXXd& matrix);
};

/// Writes data and scripts below `directory`/plots and draws them; see write_plots.
std::vector<std::string> draw_pictures(const std::vector<Picture>& pictures, const std::string& directory,
                                       Warnings* warnings);

// What each picture shows is said where it is made; nullopt-like pictures (nothing to show) have an empty
// name.
Picture ee_curves_picture(const PlotInput& input);
Picture ring_through_picture(const PlotInput& input);
Picture focal_images_picture(const PlotInput& input);
Picture gradients_picture(const PlotInput& input);
Picture surface_picture(const PlotInput& input, const SurfaceField& grid);
Picture profile_picture(const PlotInput& input, const SurfaceField& grid);
Picture coefficients_picture(const PlotInput& input);
Picture frontier_picture(const PlotInput& input);
Picture character_picture(const PlotInput& input);
Picture map_heights_picture(const PlotInput& input);
Picture map_light_picture(const PlotInput& input);

// Shared by the makers of pictures:

/// A unit of an axis: SI value * per_si = number on the axis.
struct AxisUnit {
  double per_si = 1;
  std::string name;
  /// "x [mm]".
  std::string label(const std::string& what) const { return what + " [" + name + "]"; }
};
/// The unit in which `largest` [m] or [rad] has few digits before the point.
AxisUnit length_unit(double largest);
AxisUnit angle_unit(double largest);

/// format_quantity with the micro sign.
std::string display(double value, Dimension dimension);

/// gnuplot string literal of any text: single-quoted (nothing in it is executed or expanded), control
/// characters as blanks.
std::string gnuplot_text(const std::string& text);

/// Opens every script: how to draw again, terminal, fonts, grid, the shared line colours. Size [pixels].
std::string script_head(const std::string& name, int width, int height);

/// `text`, then the study's title when it has one; shortened to fit the width of a picture.
std::string picture_title(const PlotInput& input, const std::string& text);
/// The same with the title at hand.
std::string picture_title(const std::string& text, const std::string& title);

/// gnuplot's `set palette` for signed values, blue over white to red.
std::string signed_palette();

/// `(1, 2, 5)`: numbers at an axis of logarithms, two of them at least on any range of a quarter of a decade:
/// powers of ten alone leave a short one bare. `autofreq`, gnuplot's own choice, of a range that has no
/// logarithm.
std::string log_tics(double low, double high);

/// `set xrange` (or of another axis) from -reach to reach.
std::string symmetric_range(const std::string& axis, double reach);

/// The outlines of a clear aperture, moved by (dx, dy) [m], as further curves of a `plot` whose axes have
/// `scale` units per metre, with their data added to the picture; empty where there is none.
std::string rim_curves(Picture* picture, const ClearRegion& clear, double dx, double dy, double scale);

/// Between two curves of one `plot`.
inline constexpr const char* kNextCurve = ", \\\n  ";

/// Largest absolute value; NaN and infinity do not count, and 0 where nothing else is there.
double largest_size(const Eigen::ArrayXXd& values);

Eigen::ArrayXd array_of(const std::vector<double>& values);

/// Colours told apart with every common colour blindness (Okabe & Ito 2008).
inline constexpr const char* kIdealColour = "#666666";
inline constexpr const char* kTargetColour = "#0072B2";
inline constexpr const char* kFittedColour = "#D55E00";

}  // namespace aberfit::internal
