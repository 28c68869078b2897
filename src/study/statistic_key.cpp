#include "statistic_key.h"

namespace aberfit::internal {

// Leading and trailing zeros are not allowed, so each statistic has one key and duplicates are found.
const char* const kEncircledEnergyName =
    R"(ee(0\.(0[0-9]{0,2}[1-9]|[0-9]{0,3}[1-9])|[1-9][0-9]?(\.[0-9]{0,3}[1-9])?))";

namespace {

const std::string kRingPrefix = "ring_fwhm@", kDiameterSuffix = "_diameter";
const char* const kHalfEnergyWidth = "hew";  // the diameter of ee50

}  // namespace

const std::vector<KeyPattern>& statistic_keys() {
  static const std::vector<KeyPattern> patterns = [] {
    std::vector<KeyPattern> keys = {{"", kEncircledEnergyName, "ee50"},
                                    {"", kEncircledEnergyName + kDiameterSuffix, "ee80_diameter"},
                                    {kHalfEnergyWidth, "", kHalfEnergyWidth},
                                    {"", kRingPrefix + kEncircledEnergyName, "ring_fwhm@ee50"},
                                    {"ring_profile", "", "ring_profile"}};
    for (const std::string& key : request_keys()) keys.push_back({key, "", key});
    return keys;
  }();
  return patterns;
}

std::vector<std::string> keys_of(const std::vector<StatisticRequest>& requests) {
  // The plain key stands for a given length or, if there is none, for the usual ring.
  bool length_given = false;
  for (const StatisticRequest& request : requests)
    length_given |= request.name == "ring_fwhm" && std::holds_alternative<double>(request.ring);
  std::vector<std::string> keys;
  for (const StatisticRequest& request : requests) {
    const std::string* ring = std::get_if<std::string>(&request.ring);
    const bool in_key = request.name == "ring_fwhm" && ring != nullptr && (*ring != "ee90" || length_given);
    const std::string& name = request.asked.name.empty() ? request.name : request.asked.name;
    keys.push_back(in_key ? kRingPrefix + *ring : name);
  }
  return keys;
}

bool is_diameter(const std::string& key) { return key == kHalfEnergyWidth || key.ends_with(kDiameterSuffix); }

StatisticRequest request_of(const std::string& key) {
  StatisticRequest request;
  request.name = key;
  if (key.starts_with(kRingPrefix)) {
    request.name = "ring_fwhm";
    request.ring = key.substr(kRingPrefix.size());
  }
  if (is_diameter(key)) {
    request.name = key == kHalfEnergyWidth ? "ee50" : key.substr(0, key.size() - kDiameterSuffix.size());
    request.asked = {key, "", 2};
  }
  return request;
}

}  // namespace aberfit::internal
