#include "aberfit/report/plots.h"

#include <filesystem>
#include <system_error>

#include "gnuplot.h"
#include "picture.h"

namespace aberfit {
using namespace internal;

namespace {

// Terms of a map without a specification have only their own light, which is that of `map_light` where rays
// are no model of it.
bool rays_show_nothing(const ResultDocument& result) {
  return result.map && !result.has_roughness && result.model == "waves";
}

std::vector<Picture> all_pictures(const PlotInput& input) {
  std::vector<Picture> pictures;
  if (!rays_show_nothing(input.result))
    pictures = {ee_curves_picture(input), ring_through_picture(input), focal_images_picture(input)};
  const Eigen::VectorXd& coefficients = input.result.fit.coefficients;
  if (coefficients.size() > 0 && coefficients.size() == input.surface_grid.terms().size()) {
    SurfaceField grid;
    input.surface_grid.apply(coefficients, &grid);
    pictures.push_back(surface_picture(input, grid));
    pictures.push_back(profile_picture(input, grid));
    pictures.push_back(coefficients_picture(input));
  }
  pictures.push_back(gradients_picture(input));
  if (input.result.frontier && input.result.frontier->points.size() > 1)
    pictures.push_back(frontier_picture(input));
  if (input.result.character && !input.result.character->zones.empty())
    pictures.push_back(character_picture(input));
  if (input.result.map_panels) pictures.push_back(map_heights_picture(input));
  if (input.result.map_light) pictures.push_back(map_light_picture(input));
  return pictures;
}

}  // namespace

std::vector<std::string> write_plots(const PlotInput& input, const std::string& directory,
                                     Warnings* warnings) {
  return draw_pictures(all_pictures(input), directory, warnings);
}

namespace internal {

std::vector<std::string> draw_pictures(const std::vector<Picture>& pictures, const std::string& directory,
                                       Warnings* warnings) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::path(directory) / "plots";
  for (const Picture& picture : pictures) {
    for (const auto& [file, text] : picture.data) write_file((folder / file).string(), text);
    write_file((folder / (picture.name + ".gp")).string(), picture.script);
  }

  std::vector<std::string> drawn;
  const std::string gnuplot = find_gnuplot();
  std::string problem = gnuplot.empty() ? "gnuplot is not on PATH" : "";
  for (const Picture& picture : pictures) {
    const fs::path png = folder / (picture.name + ".png");
    std::error_code ignored;
    fs::remove(png, ignored);  // a picture of an earlier run would lie about this one
    if (!problem.empty()) continue;
    problem = run_gnuplot(gnuplot, folder.string(), picture.name + ".gp");
    if (problem.empty()) {
      drawn.push_back(png.string());
    } else {
      fs::remove(png, ignored);  // half a picture
      problem = "gnuplot could not draw " + picture.name + " (" + problem + ")";
    }
  }
  if (!problem.empty() && warnings)
    warnings->push_back(
        {"no-gnuplot", problem +
                           ", so pictures are missing. Their data and scripts are in the "
                           "folder plots of the results: install gnuplot with the pngcairo terminal (Debian: "
                           "gnuplot-nox) and run `gnuplot *.gp` there."});
  return drawn;
}

}  // namespace internal
}  // namespace aberfit
