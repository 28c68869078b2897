#pragma once
#include <string>

namespace aberfit {

/// A text file of the source tree that the library contains, by its name, such as "report.html": templates,
/// plot scripts, starter studies. Throws std::out_of_range for another name.
const std::string& embedded_text(const std::string& name);
/// The commit of the built library, "-dirty" added if files had been changed; empty outside of a clone.
const char* source_commit();

}  // namespace aberfit
