#include "aberfit/theory/vocabulary.h"

namespace aberfit {

std::string to_string(Theory theory) {
  constexpr const char* kWords[] = {"geometric", "rays", "ghs"};  // in the order of the enum
  return kWords[int(theory)];
}

std::string to_string(FocusModel model) { return model == FocusModel::kWaves ? "waves" : "rays"; }

FocusModel model_of(Theory theory) { return theory == Theory::kGhs ? FocusModel::kWaves : FocusModel::kRays; }

}  // namespace aberfit
