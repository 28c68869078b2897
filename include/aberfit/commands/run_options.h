#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "aberfit/core/output_formats.h"

namespace aberfit {

struct GivenSurface;

struct RunOptions {
  int threads = 0;                                   ///< 0: all the process may use
  std::optional<PictureFormat> pictures;             ///< absent: as the study says
  std::optional<ArrayFormat> arrays;                 ///< fit, trace, check; absent: as the study says
  std::string output_directory;                      ///< empty: nothing is written
  std::string command_line;                          ///< for provenance; empty: a program's call
  bool force = false;                                ///< replace files there that stand in the way of results
  std::function<void(const std::string&)> tell;      ///< receives a line that names them; may be empty
  std::string coefficients_file;                     ///< trace, verify: surface in place of a realisation
  std::shared_ptr<const GivenSurface> surface;       ///< the same in memory; null: the file, if there is one
  std::function<void(const std::string&)> progress;  ///< one line of progress; called often
  /// Called between the steps of a fit; true ends the fit with the best so far. Empty: never.
  std::function<bool()> interrupted;
  /// Says what asked to stop after `interrupted` returned true. Empty: a signal.
  std::function<std::string()> stopped_by;
  double chart_seconds = 60;       ///< chart: about how long it may take [s], > 0
  bool measure_iteration = false;  ///< check: make one iteration of the fit and report its time
};

}  // namespace aberfit
