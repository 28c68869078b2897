#pragma once
#include <string>

#include "aberfit/study/study.h"

namespace aberfit {

/// The `where` of measurements that no study names: messages then have options as they are typed, else the
/// keys of a study.
inline constexpr const char* kCommandLine = "command line";

/// Reads one measurement, heights scaled, and takes its clear part. clear: what that is. `folder`: what its
/// file is relative to. Throws InputError that names `where` and `pointer`, and the file in what was found.
Measurement load_measurement(const MeasuredFile& file, const std::string& folder, const std::string& where,
                             const std::string& pointer, ClearRegion* clear);

/// Measurement -> PSD -> model: fills data, estimate and result of `measured`. `folder`: what its files are
/// relative to; `where`, `pointer`: named in errors, which are InputErrors for data no PSD can be had from.
void measure_psd(MeasuredPsd& measured, const std::string& folder, const std::string& where,
                 const std::string& pointer, int threads);

}  // namespace aberfit
