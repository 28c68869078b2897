#pragma once
#include <cstdint>
#include <memory>
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

/// `psd.model: "table"`: a file and how to read it. read_study loads the table.
struct PsdTableFile {
  static constexpr const char* kModel = "table";
  std::string file;                      ///< as written in the study, relative to it
  std::string kind = "2d";               ///< "2d": two-sided [m^4]; "1d": one-sided profile PSD [m^3]
  std::string frequency_unit, psd_unit;  ///< empty: as the header of the file says
  std::string of = "surface";            ///< "wavefront": heights are half
  double scale = 1;                      ///< height factor, to put a measured shape on another mirror
  std::optional<double> f_min, f_max;    ///< band cut [cycles/m]
  PsdTableResult table;  ///< loaded: two-sided 2-D surface PSD with `of`, `scale` and the cut applied, and
                         ///< what the cut left out
};

/// A measured profile or map: the file, and the facts that it may not state itself.
struct MeasuredFile {
  std::string file;  ///< as written in the study, relative to it
  MeasuredFormat format = MeasuredFormat::kAuto;
  int column = 1;                  ///< profiles: scan line, from 1
  std::string quantity;            ///< profile text: "height" or "slope"; empty: as the file says
  std::string of;                  ///< "surface" or "wavefront"; empty: as the file says
  std::string x_unit, value_unit;  ///< empty: as the file says; value_unit may be "waves"
  std::optional<double> pitch;     ///< maps: pixel scale [m]; profiles with rounded positions: their step
  std::optional<int> columns;      ///< text maps: samples in a row that spans several lines
  std::string first_row = "top";   ///< text maps: "bottom" if the first row has the lowest y
  std::optional<double>
      wavelength;   ///< the instrument's [m], for values in waves or radians; absent: as the file says
  std::string hdu;  ///< FITS: name or number of the image, "0" the primary; empty: the only one
  std::optional<int> plane;     ///< FITS, NumPy: plane of a cube, from 1
  double scale = 1;             ///< factor on the heights, to put a measured shape on another mirror
  std::vector<double> invalid;  ///< values of the file that mark a missing sample, see MeasuredSource
  ClearPart clear;
  /// Data of a program in place of the file, which then is only a name. The facts above apply to them as to a
  /// file that states none. Without a unit, heights are in m, of the surface, and slopes in rad.
  std::shared_ptr<const Measurement> values = nullptr;
};

/// `psd.model: "measured"`: measurement -> PSD -> model, computed by read_study.
struct MeasuredPsd {
  static constexpr const char* kModel = "measured";
  MeasuredFile source;
  std::vector<MeasuredFile> further;  ///< other bands of the same surface, by other instruments
  OutlierTreatment outliers = OutlierTreatment::kWarn;
  PsdEstimatorOptions estimator;
  PsdFitOptions fit;
  std::vector<FrequencyBand> bands;  ///< bands whose RMS height and slope are reported
  // The results:
  std::vector<Measurement> data;   ///< clear parts, heights scaled, rejected outliers removed
  std::vector<ClearRegion> clear;  ///< one for each
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
  std::string name = {};  ///< for readers: name of a part of a sum
};

/// A measured map as target, fitted by terms in least squares.
struct MapTarget {
  MeasuredFile source;
  std::string origin = "circle";  ///< the axis is at the centre of the enclosing circle, of the "grid", or
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

/// A surface other than the mirror that blurs the focus (specify/contributors.h), as the file has it.
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

/// A measured focus, from which a PSD is found (specify/psd_of_focus.h), as the file has it.
struct FocusSpec {
  std::string file;           ///< as written in the study, relative to it
  std::string kind = "auto";  ///< "curve", "image"; "auto": FITS and many columns are images
  std::string radius_unit;    ///< unit of a curve whose file does not state it; may be empty
  /// Length [m], or an angle as text ("0.1 arcsec"). Absent: as the file says; a curve has none.
  std::optional<std::variant<std::string, double>> pixel;
  std::optional<std::variant<std::string, double>> reach;  ///< likewise; absent: all data
  MeasuredFocus measured;  ///< known facts; run_psd_of_focus adds data and lengths
};

/// The `solve` block: which roughness to find (specify/solve.h).
struct SolveSpec {
  std::vector<std::string>
      unknowns;  ///< JSON pointers of numbers of the roughness: one or two, up to four for a focus
  std::vector<Budget> budgets;
  double contour_decades = 1;        ///< two unknowns: range on either side of the study's values
  std::optional<double> confidence;  ///< fraction of mirrors that must meet the budgets; absent: the mean
  std::optional<ContributorsSpec> with;
  std::optional<CeilingsSpec> ceilings;  ///< instead of unknowns: how rough the mirror may be at all
  std::optional<FocusSpec> focus;        ///< instead of budgets: a measured focus
};

/// A value of the study that varies, by a list or by a range of numbers.
struct VaryAxis {
  std::string pointer;              ///< JSON pointer into the study
  std::vector<std::string> values;  ///< the list, as JSON texts; empty: a range
  std::string from, to;             ///< ends of a range: numbers or quantities, as JSON texts
  int count = 0;                    ///< range: number of values in a grid, both ends included
  std::string spacing = "linear";   ///< range: "linear", "log", "integers"
};
enum class VaryDesign { kGrid, kSobol };
/// The computation of a sweep for each case.
enum class CaseLevel {
  kCheck,  ///< the values of theory (method/theory_values.h)
  kTrace,  ///< statistics of the seed's random surface
  kFit,    ///< the whole fit with its verdict
  kSolve,  ///< the specification that the study's `solve` block asks for
};
std::string to_string(CaseLevel level);
/// The cases of `aberfit sweep`.
struct VarySpec {
  /// Largest number of cases: the plan goes through all of them before the first runs.
  static constexpr int kMostCases = 10'000'000;
  std::vector<VaryAxis> axes;
  VaryDesign design = VaryDesign::kGrid;
  int cases = 256;         ///< of kSobol
  std::uint64_t seed = 1;  ///< of kSobol: shifts the points
  int realisations = 1;    ///< seeds of the fit for each case, counted from the study's own
  CaseLevel run = CaseLevel::kCheck;
};

/// A mask whose outlines are the aperture.
struct MaskFile {
  std::string file;
  double pitch = 0;  ///< of pixels [m]
  double margin = 0;
  std::shared_ptr<const Grid> values = nullptr;  ///< data of a program in place of the file
};
/// An aperture before its file is read and its spiders are removed.
struct ApertureSpec {
  std::variant<CircleAperture, AnnulusAperture, RectangleAperture, PolygonAperture, SegmentedAperture,
               MaskFile>
      shape;
  std::vector<Vane> spiders;
};

/// A task and what belongs to its file. A program that fills it must set mirror, aperture, wavelength and psd
/// (or roughness). Members left alone mean the same as keys that a file leaves out.
struct Study : Task {
  std::string path;                  ///< file it was read from; empty: made by a program
  std::vector<std::string> changes;  ///< made to it, each "/json/pointer=value"
  std::string typed;  ///< JSON text with these changes, units as typed; empty: made by a program
  std::string title;
  std::string description;  ///< text for people, of any length
  std::string schema;       ///< address of the JSON Schema; only editors read it
  /// The file's description, if `aperture` is computed from it: a mask, or a shape and the spiders that cover
  /// a part of it. A program sets this in place of `aperture`.
  std::optional<ApertureSpec> obstructed;
  std::optional<RoughnessModel> roughness;  ///< as the file has it; `psd` is its model
  std::optional<MapTarget> map;             ///< target.map: instead of statistics
  OutputSpec output;
  /// Number of surfaces that `verify` draws; absent: as many as its margin needs (method/verify.h).
  std::optional<int> verify_draws;
  std::optional<SolveSpec> solve;
  std::optional<VarySpec> vary;
};

/// Data of a program for a study that names files.
struct StudyData {
  std::shared_ptr<const Measurement> map, profile;
  std::shared_ptr<const Grid> mask;  ///< of the aperture; row 0 at the lowest y
};

/// Fills in what follows from other members and from the files that the study names. It loads missing tables,
/// measurements and curves (relative paths start at the folder of `path`). It makes `psd` from the roughness
/// or, if that is absent, the roughness from `psd`, and sets the disc of the known Zernikes. Every command
/// (commands/run.h) calls it first, so a study filled by a program equals the same study read from a file.
/// read_study has called it; a second call changes nothing. Throws InputError for unreadable files and for
/// members that contradict each other.
Study completed(Study study);

/// The PSD model of a roughness node, tables included.
PsdModel psd_model(const RoughnessModel& roughness);
/// The contributors that a `with` block stands for.
Contributors contributors(const ContributorsSpec& with);

}  // namespace aberfit
