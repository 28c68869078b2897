#pragma once
#include <chrono>
#include <string>

namespace aberfit::internal {

/// Full path of the gnuplot program on PATH; empty when there is none.
std::string find_gnuplot();

/// Runs `gnuplot --default-settings script` in `directory` without a shell, so any folder name is safe. Stops
/// gnuplot after `longest`, so that a picture cannot block a run. Returns an empty text on success, else the
/// message of gnuplot or the system on one line.
std::string run_gnuplot(const std::string& gnuplot, const std::string& directory, const std::string& script,
                        std::chrono::seconds longest = std::chrono::seconds(120));

}  // namespace aberfit::internal
