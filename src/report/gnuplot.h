#pragma once
#include <chrono>
#include <string>

namespace aberfit::internal {

/// Full path of the gnuplot program on PATH; empty when there is none.
std::string find_gnuplot();

/// Runs `gnuplot --default-settings script` in `directory` and waits for it. No shell takes part, so any
/// folder name will do. One that has not ended after `longest` is stopped: a picture is not worth a run that
/// hangs. Returns an empty text on success, else what gnuplot or the system said, on one line.
std::string run_gnuplot(const std::string& gnuplot, const std::string& directory, const std::string& script,
                        std::chrono::seconds longest = std::chrono::seconds(120));

}  // namespace aberfit::internal
