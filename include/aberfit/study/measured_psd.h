#pragma once
#include <string>

#include "aberfit/study/study.h"

namespace aberfit {

/// The `where` of measurements given on the command line: messages then name options as typed, otherwise keys
/// of a study.
inline constexpr const char* kCommandLine = "command line";

/// Reads one measurement, scales its heights and takes its clear part, which `clear` describes. The file's
/// path is relative to `folder`. Throws an InputError that names `where`, `pointer` and the file.
Measurement load_measurement(const MeasuredFile& file, const std::string& folder, const std::string& where,
                             const std::string& pointer, ClearRegion* clear);

/// Measurement -> PSD -> model: fills data, estimate and result of `measured`. Its paths are relative to
/// `folder`. Throws an InputError that names `where` and `pointer` if the data give no PSD.
void measure_psd(MeasuredPsd& measured, const std::string& folder, const std::string& where,
                 const std::string& pointer, int threads);

}  // namespace aberfit
