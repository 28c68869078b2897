// The commands: a study as text, and the data in memory that it names, give an answer.
#include <fmt/ranges.h>
#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <atomic>
#include <nlohmann/json.hpp>

#include "aberfit/cases/case_plan.h"
#include "aberfit/commands/answer.h"
#include "aberfit/report/documents.h"
#include "aberfit/report/html_report.h"
#include "aberfit/report/result.h"
#include "background.h"
#include "parts.h"
#include "study_text.h"
#include "views.h"

namespace py = pybind11;

namespace aberfit::internal {
namespace {

using Numbers = py::array_t<double, py::array::c_style | py::array::forcecast>;

Eigen::ArrayXd vector_of(const Numbers& numbers) {
  return Eigen::Map<const Eigen::ArrayXd>(numbers.data(), numbers.size());
}
Grid grid_of(const Numbers& numbers) {
  return Eigen::Map<const Grid>(numbers.data(), numbers.shape(0), numbers.shape(1));
}

// Data in place of files. The Python part has checked shapes.
void put_map(StudyData& data, const Numbers& height, double pitch_x, double pitch_y, double x0, double y0) {
  HeightMap map;
  map.height = grid_of(height);
  map.pitch_x = pitch_x, map.pitch_y = pitch_y;
  map.x0 = x0, map.y0 = y0;
  data.map = std::make_shared<const Measurement>(std::move(map));
}
void put_profile(StudyData& data, const Numbers& x, const Numbers& value, bool is_slope) {
  Profile profile;
  profile.x = vector_of(x);
  profile.value = vector_of(value);
  profile.quantity = is_slope ? ProfileQuantity::kSlope : ProfileQuantity::kHeight;
  data.profile = std::make_shared<const Measurement>(std::move(profile));
}
void put_mask(StudyData& data, const Numbers& mask) {
  data.mask = std::make_shared<const Grid>(grid_of(mask));
}

struct Settings {
  int threads = 0;
  std::string output, pictures, arrays, coefficients, call;
  bool force = false;
  double chart_seconds = 60;
  std::shared_ptr<const GivenSurface> surface;  // for trace and verify
};

template <typename Enum>
std::optional<Enum> chosen(const std::string& word, const std::vector<std::string>& names, const char* key) {
  if (word.empty()) return std::nullopt;
  const auto found = std::find(names.begin(), names.end(), word);
  if (found == names.end()) {
    throw InputError("call", key, '"' + word + '"', fmt::format("one of {}", fmt::join(names, ", ")));
  }
  return Enum(found - names.begin());
}

RunOptions options_of(const Settings& settings) {
  RunOptions options;
  options.threads = settings.threads;
  options.output_directory = settings.output;
  options.pictures = chosen<PictureFormat>(settings.pictures, picture_format_names(), "pictures");
  options.arrays = chosen<ArrayFormat>(settings.arrays, array_format_names(), "arrays");
  options.coefficients_file = settings.coefficients;
  options.command_line = settings.call;
  options.force = settings.force;
  options.chart_seconds = settings.chart_seconds;
  options.surface = settings.surface;
  return options;
}

// What Python shows of a focus. No file of the program has both.
struct PyFocus : FocusArrays {
  std::optional<ScatterTable> scatter;  // of the roughness beside the terms
};

// An answer, and its numbers once they have been asked for.
struct PyAnswer {
  Answer answer;
  nlohmann::ordered_json document;  // made at once, while the input files are what they were
  std::shared_ptr<const PyFocus> arrays;

  std::string json() const { return document.dump(2) + "\n"; }
  std::string text() const { return text_of(answer.page, {100, false}); }
  std::string first_screen() const { return shown(first_screen_of); }
  std::string html() const {
    return shown([](const HtmlReport& report) { return html_of(report); });
  }

 private:
  template <typename Show>
  std::string shown(const Show& show) const {
    const nlohmann::ordered_json asked = answer.asked();
    return show(HtmlReport{answer.page, document, asked, {}, "", {}});
  }
};

py::dict light_of(const LightArrays& light, const std::shared_ptr<const FocusArrays>& owner) {
  py::dict result;
  result["encircled_energy"] = view(light.encircled_energy, owner);
  result["ring_profile"] = view(light.ring_profile, owner);
  result["psf"] = view(light.psf, owner);
  if (light.mtf) result["mtf"] = view(*light.mtf, owner);
  if (light.otf) {
    result["otf"] = view(light.otf->value, owner);
    result["otf_step"] = light.otf->step;
  }
  return result;
}

// What `look` makes of the light of an answer.
template <typename Result>
Result seen(const PyAnswer& self, const std::function<Result(const ArrayInput&)>& look) {
  return in_background<Result>(
      [&](Hooks&) {
        Result result;
        self.answer.focus([&](const ArrayInput& focus) { result = look(focus); });
        return result;
      },
      py::none());
}

// The spot of the surface, or else of theory, as fractions of the energy per pixel.
py::object image_of(const PyAnswer& self, double pixel, int pixels, double dz) {
  if (!self.answer.focus) return py::none();
  return owned(seen<Eigen::ArrayXXd>(self, [&](const ArrayInput& focus) {
    if (pixel > focus.mirror.focal_length)
      throw InputError("call", "pixel", fmt::format("{:g}", pixel), "at most the focal length");
    const FocalLight& light = focus.surface ? *focus.surface : *focus.theory;
    return light.image(dz, 0.5 * pixel * pixels, pixels);
  }));
}

py::object focus_of(PyAnswer& self) {
  if (!self.answer.focus) return py::none();
  if (!self.arrays)
    self.arrays = seen<std::shared_ptr<const PyFocus>>(self, [](const ArrayInput& focus) {
      auto made = std::make_shared<PyFocus>(PyFocus{make_focus_arrays(focus), {}});
      if (focus.rest) made->scatter = scatter_table(ScatterFunction(*focus.rest, focus.wavelength));
      return made;
    });
  const auto& arrays = self.arrays;
  py::dict result;
  result["plane"] = view(arrays->plane, arrays);
  result["radius"] = view(arrays->radius, arrays);
  result["pixel"] = view(arrays->pixel, arrays);
  result["frequency"] = view(arrays->frequency, arrays);
  if (arrays->theory) result["theory"] = light_of(*arrays->theory, arrays);
  if (arrays->halo)
    result["halo"] = py::make_tuple(view(arrays->halo->fraction, arrays), arrays->halo->core,
                                    arrays->halo->halo, arrays->halo->beyond);
  if (arrays->scatter) {
    py::dict scatter;
    scatter["theta"] = view(arrays->scatter->theta, arrays);
    scatter["bsdf"] = view(arrays->scatter->bsdf_per_sr, arrays);
    scatter["tis_within"] = view(arrays->scatter->tis_within, arrays);
    result["scatter"] = scatter;
  }
  if (arrays->surface) result["surface"] = light_of(*arrays->surface, arrays);
  return result;
}

PyAnswer run(const std::string& command, const StudyText& study, const Settings& settings,
             const py::object& progress) {
  const auto which = *chosen<StudyCommand>(command, study_command_names(), "command");
  return in_background<PyAnswer>(
      [&](Hooks& hooks) {
        RunOptions options = options_of(settings);
        options.progress = [&](const std::string& line) { hooks.tell(line); };
        options.interrupted = [&] { return hooks.stopped(); };
        options.stopped_by = [] { return std::string("Ctrl-C"); };
        PyAnswer made{answer(which, study.read(), options), {}, nullptr};
        made.document = made.answer.document();
        return made;
      },
      progress, [](const PyAnswer& made) { return made.answer.code == ExitCode::kInterrupted; });
}

void save(const PyAnswer& self, const Settings& settings) {
  if (!self.answer.save)
    throw InputError("call", "save", "a result without files", "a result of a command that did not fail");
  in_background<bool>(
      [&](Hooks&) {
        self.answer.save(options_of(settings));
        return true;
      },
      py::none());
}

// The command of a sweep, and its cases.
std::pair<std::string, CasePlan> sweep_cases(const StudyText& text) {
  const Study study = text.read();
  if (!study.vary) throw InputError(text.path, "/vary", kMissing, "a sweep needs a block `vary`");
  return {to_string(study.vary->run), CasePlan(*study.vary, study.fit.seed, study.path)};
}

}  // namespace

void add_studies(py::module_& module) {
  py::class_<StudyData>(module, "StudyData")
      .def(py::init<>())
      .def("put_map", &put_map)
      .def("put_profile", &put_profile)
      .def("put_mask", &put_mask);
  py::class_<StudyText>(module, "StudyText")
      .def(py::init([](std::string text, std::string path, std::vector<std::string> changes, StudyData data) {
             return StudyText{std::move(text), std::move(path), std::move(changes), std::move(data)};
           }),
           py::arg("text"), py::arg("path"), py::arg("changes"), py::arg("data"));
  py::class_<Settings>(module, "Settings")
      .def(py::init<>())
      .def_readwrite("threads", &Settings::threads)
      .def_readwrite("output", &Settings::output)
      .def_readwrite("pictures", &Settings::pictures)
      .def_readwrite("arrays", &Settings::arrays)
      .def_readwrite("coefficients", &Settings::coefficients)
      .def_readwrite("call", &Settings::call)
      .def_readwrite("force", &Settings::force)
      .def_readwrite("chart_seconds", &Settings::chart_seconds)
      .def("set_surface", [](Settings& self, const GivenSurface& surface) {
        self.surface = std::make_shared<const GivenSurface>(surface);
      });
  py::class_<CasePlan>(module, "CasePlan").def("__len__", &CasePlan::size).def("at", &CasePlan::at);
  py::class_<PyAnswer>(module, "Answer")
      .def_property_readonly("json", &PyAnswer::json)
      .def_property_readonly("code", [](const PyAnswer& self) { return int(self.answer.code); })
      .def_property_readonly("headline", [](const PyAnswer& self) { return self.answer.page.headline; })
      .def("text", &PyAnswer::text)
      .def("first_screen", &PyAnswer::first_screen)
      .def("html", &PyAnswer::html)
      .def("focus", &focus_of)
      .def("image", &image_of)
      .def("save", &save);
  module.def("run", &run, py::arg("command"), py::arg("study"), py::arg("settings"), py::arg("progress"));
  module.def("sweep_cases", &sweep_cases);
  module.def("write_file", [](const std::string& path, const py::bytes& content) {
    write_file(path, std::string(content));
  });
  module.def("forget_all", &Running::forget);
  module.def("end_all", &Running::end_all, py::call_guard<py::gil_scoped_release>());
  module.def("study_schema", [] { return study_schema().dump(); });
  module.def("results_schema", [] { return results_schema().dump(); });
}

}  // namespace aberfit::internal
