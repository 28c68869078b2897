#include "statistic_request.h"

#include <string>
#include <variant>

namespace aberfit::internal {
namespace {

// "ee50" -> 0.5
double fraction_of(const std::string& name) { return std::stod(name.substr(2)) / 100; }

std::vector<Wanted> profile(const StatisticRequest& request, const RingOf& ring_of) {
  const auto* given = std::get_if<double>(&request.ring);
  const double ring = given ? *given : ring_of(fraction_of(std::get<std::string>(request.ring)));
  std::vector<Wanted> wanted;
  for (std::size_t k = 0; k < request.profile_dz.size(); ++k)
    wanted.push_back({RingThrough{ring, request.profile_dz[k], true}, request.profile_value[k],
                      request.standard_error, request.tolerance});
  return wanted;
}

}  // namespace

std::vector<Wanted> wanted_by(const StatisticRequest& request, const RingOf& ring_of, double focal_sigma) {
  const std::string& name = request.name;
  if (name == "ring_profile") return profile(request, ring_of);
  const StudyOption& option = option_of_key(name);
  StatisticOptions options;
  if (option.form == StudyOption::kPercent) options.fraction = fraction_of(name);
  if (option.form == StudyOption::kRing) {
    if (const auto* radius = std::get_if<double>(&request.ring))
      options.ring_radius = *radius;
    else
      options.fraction = fraction_of(std::get<std::string>(request.ring));
  }
  std::vector<double> numbers = request.places;
  if (option.form != StudyOption::kPlaces) numbers = {request.bandwidth.value_or(0.1 * focal_sigma)};
  std::vector<Wanted> wanted;
  for (const double dz :
       kind_of_key(name).plane == FocalPlane::kGiven ? request.planes : std::vector<double>{0})
    for (const double number : numbers) {
      options.dz = dz;
      options.number = number;
      wanted.push_back({statistic_of_key(name, options), request.value, request.standard_error,
                        request.tolerance, request.asked});
    }
  return wanted;
}

}  // namespace aberfit::internal
