#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "aberfit/core/output_formats.h"
#include "aberfit/fit/map_fit.h"
#include "aberfit/measured/clear_aperture.h"
#include "aberfit/method/task.h"
#include "aberfit/method/verify.h"
#include "aberfit/roughness/psd.h"
#include "aberfit/roughness/psd_table.h"
#include "aberfit/specify/budget.h"
#include "aberfit/specify/ceilings.h"
#include "aberfit/specify/contributors.h"
#include "aberfit/specify/psd_of_focus.h"
#include "aberfit/spectrum/outliers.h"
#include "aberfit/spectrum/psd_model_fit.h"
#include "aberfit/spectrum/surface_psd.h"

// A study file in memory, format version 1. Member names follow the JSON keys; SI units and radians
// throughout.
namespace aberfit {

/// `psd.model: "table"`: what the file says and how to read it. The table itself is loaded by read_study.
struct PsdTableFile {
  static constexpr const char* kModel = "table";
  std::string file;                      ///< as written in the study, relative to it
  std::string kind = "2d";               ///< "2d": two-sided [m^4]; "1d": one-sided profile PSD [m^3]
  std::string frequency_unit, psd_unit;  ///< empty: as the header of the file says
  std::string of = "surface";            ///< "wavefront": heights are half
  double scale = 1;                      ///< height factor, to put a measured shape on another mirror
  std::optional<double> f_min, f_max;    ///< band cut [cycles/m]
  PsdTableResult
      table;  ///< loaded: two-sided 2-D surface PSD with `of`, `scale` and the cut applied; what was left out
};

/// A measured profile or map: the file and what it may not say itself.
struct MeasuredFile {
  std::string file;  ///< as written in the study, relative to it
  MeasuredFormat format = MeasuredFormat::kAuto;
  int column = 1;                  ///< profiles: which scan line, from 1
  std::string quantity;            ///< profile text: "height" or "slope"; empty: as the file says
  std::string of;                  ///< "surface" or "wavefront"; empty: as the file says
  std::string x_unit, value_unit;  ///< empty: as the file says; value_unit may be "waves"
  std::optional<double> pitch;     ///< maps: pixel scale [m]; profiles with rounded positions: their step
  std::optional<int> columns;      ///< text maps: samples of a row that goes over several lines
  std::string first_row = "top";   ///< text maps: "bottom" where the first row has the lowest y
  std::optional<double>
      wavelength;   ///< of the instrument [m], for values in waves or radians; absent: as the file says
  std::string hdu;  ///< FITS: name or number of the image, "0" the primary; empty: the only one
  std::optional<int> plane;     ///< FITS, NumPy: which plane of a cube, from 1
  double scale = 1;             ///< factor on the heights, to put a measured shape on another mirror
  std::vector<double> invalid;  ///< values of the file that mark a missing sample, see MeasuredSource
  ClearPart clear;
};

/// `psd.model: "measured"`: measurement -> PSD -> model. The measuring is done by read_study.
struct MeasuredPsd {
  static constexpr const char* kModel = "measured";
  MeasuredFile source;
  std::vector<MeasuredFile> further;  ///< other instruments' bands of the same surface
  OutlierTreatment outliers = OutlierTreatment::kWarn;
  PsdEstimatorOptions estimator;
  PsdFitOptions fit;
  std::vector<FrequencyBand> bands;  ///< whose RMS height and slope are told
  // What came of it:
  std::vector<Measurement> data;   ///< as read, heights scaled, clear part, rejected outliers taken out
  std::vector<ClearRegion> clear;  ///< of each
  PsdEstimate estimate;
  PsdModelFit result;
};

/// A node of the `psd` block: a closed model, a table file, a measurement, or a sum of nodes.
struct RoughnessModel;
struct RoughnessSum {
  static constexpr const char* kModel = "sum";
  std::vector<RoughnessModel> parts;
};
struct RoughnessModel {
  PsdModelOr<PsdTableFile, MeasuredPsd, RoughnessSum> model;
  std::string name = {};  ///< for people, of a part of a sum
};

/// A measured map as target: least-squares terms.
struct MapTarget {
  MeasuredFile source;
  std::string origin = "circle";  ///< the axis is at the middle of the enclosing circle, of the "grid", or
                                  ///< where the "file" has it
  OutlierTreatment outliers = OutlierTreatment::kWarn;
  MapFitOptions fit;
};

struct OutputSpec {
  PictureFormat pictures = PictureFormat::kAuto;
  std::vector<ExportFormat> exports;
  int export_grid = 257;  ///< points per side of exported maps
  ArrayFormat arrays = ArrayFormat::kNone;
};

/// What blurs beside the mirror (specify/contributors.h), as the file has it.
struct OtherSurfaceSpec {
  std::string name;
  RoughnessModel psd;
  double footprint = 1, incidence = 0;  ///< [1], [rad]
  bool is_wavefront = false;
};
struct ContributorsSpec {
  std::vector<OtherSurfaceSpec> surfaces;
  std::optional<Atmosphere> atmosphere;
  double jitter = 0;  ///< [rad]
};

/// A measured focus whose PSD is looked for (specify/psd_of_focus.h), as the file has it.
struct FocusSpec {
  std::string file;           ///< as written in the study, relative to it
  std::string kind = "auto";  ///< "curve", "image"; "auto": FITS and many columns are images
  std::string radius_unit;    ///< of a curve whose file does not say it; may be empty
  /// Length [m], or an angle as text ("0.1 arcsec"); absent: what the file says, of a curve none.
  std::optional<std::variant<std::string, double>> pixel;
  std::optional<std::variant<std::string, double>> reach;  ///< likewise; absent: all of the data
  MeasuredFocus measured;  ///< what is known of it; its data and lengths come with run_psd_of_focus
};

/// Which roughness is looked for (specify/solve.h).
struct SolveSpec {
  std::vector<std::string>
      unknowns;  ///< JSON pointers of numbers of the roughness: one or two, of a focus four
  std::vector<Budget> budgets;
  double contour_decades = 1;        ///< of two unknowns: how far either way of the study's values
  std::optional<double> confidence;  ///< share of mirrors that the budgets have to hold for; absent: the mean
  std::optional<ContributorsSpec> with;
  std::optional<CeilingsSpec> ceilings;  ///< instead of unknowns: what may be rough at all
  std::optional<FocusSpec> focus;        ///< instead of budgets: what a measured focus says
};

/// A value of the study that varies: a list, or a range of numbers.
struct VaryAxis {
  std::string pointer;              ///< JSON pointer into the study
  std::vector<std::string> values;  ///< of a list, as JSON texts; empty: a range
  std::string from, to;             ///< of a range: numbers or quantities, as JSON texts
  int count = 0;                    ///< of a range: values in a grid, both ends among them
  std::string spacing = "linear";   ///< of a range: "linear", "log", "integers"
};
enum class VaryDesign { kGrid, kSobol };
/// What is computed of a case.
enum class CaseLevel {
  kCheck,  ///< what theory says (method/theory_values.h)
  kTrace,  ///< statistics of the surface that the seed draws
  kFit,    ///< the whole fit with its verdict
  kSolve,  ///< the specification that the study's `solve` block asks for
};
std::string to_string(CaseLevel level);
/// The cases of `aberfit sweep`.
struct VarySpec {
  /// All are looked through before the first is done.
  static constexpr int kMostCases = 10'000'000;
  std::vector<VaryAxis> axes;
  VaryDesign design = VaryDesign::kGrid;
  int cases = 256;         ///< of kSobol
  std::uint64_t seed = 1;  ///< of kSobol: shifts the points
  int realisations = 1;    ///< seeds of the fit, from the study's own on, for each of them
  CaseLevel run = CaseLevel::kCheck;
};

/// A mask whose outlines are the aperture.
struct MaskFile {
  std::string file;
  double pitch = 0;  ///< of its pixels [m]
  double margin = 0;
};
/// An aperture before its file is read and its spiders are taken off.
struct ApertureSpec {
  std::variant<CircleAperture, AnnulusAperture, RectangleAperture, PolygonAperture, SegmentedAperture,
               MaskFile>
      shape;
  std::vector<Vane> spiders;
};

/// A task, and what belongs to the file it is written in. A program that fills it needs mirror, aperture,
/// wavelength and psd (or roughness); what it leaves alone is what a file would leave out.
struct Study : Task {
  std::string path;                  ///< file it was read from; empty: a program's
  std::vector<std::string> changes;  ///< put into it, "/json/pointer=value"
  std::string typed;                 ///< its JSON text with these changes, units as typed; empty: a program's
  std::string title;
  std::string description;  ///< text for people, of any length
  std::string schema;       ///< where an editor finds the JSON Schema; nothing else reads it
  /// The description in the file, where `aperture` is made from it: the file of a mask, or a shape and
  /// spiders that cover a part of it.
  std::optional<ApertureSpec> obstructed;
  std::optional<RoughnessModel> roughness;  ///< as the file has it; `psd` is the model that it stands for
  std::optional<MapTarget> map;             ///< target.map: instead of statistics
  OutputSpec output;
  /// Surfaces that `verify` draws; absent: as many as its margin needs (method/verify.h).
  std::optional<int> verify_draws;
  std::optional<SolveSpec> solve;
  std::optional<VarySpec> vary;
};

/// The study with what its other members and the files that it names say: tables, measurements and curves
/// that are not there yet (relative paths start at the folder of `path`), `psd` of the roughness or, where
/// that is absent, the roughness of `psd`, and the disc of the known Zernikes. Every command (commands/run.h)
/// begins with it, so that a study filled by a program is what the same file would be; read_study has done
/// it. Done again it changes nothing. Throws InputError for files that cannot be read and for what joins
/// several members and cannot be meant.
Study completed(Study study);

/// The PSD model of a roughness node, tables included.
PsdModel psd_model(const RoughnessModel& roughness);
/// What a `with` block stands for.
Contributors contributors(const ContributorsSpec& with);

}  // namespace aberfit
