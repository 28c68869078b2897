#include "aberfit/theory/vocabulary.h"

namespace aberfit {

std::string to_string(Theory theory) {
  switch (theory) {
    case Theory::kGeometric:
      return "geometric";
    case Theory::kRays:
      return "rays";
    case Theory::kGhs:
      break;
  }
  return "ghs";
}

std::string to_string(FocusModel model) { return model == FocusModel::kWaves ? "waves" : "rays"; }

FocusModel model_of(Theory theory) { return theory == Theory::kGhs ? FocusModel::kWaves : FocusModel::kRays; }

}  // namespace aberfit
