#pragma once
#include <iosfwd>

namespace aberfit {

/// Answers requests, one JSON object a line of `in`, until its end, with lines of JSON on `out` (FORMATS,
/// "Requests and answers"). Requests run one after the other, in their order. A request to cancel another is
/// heard at once. threads: of each command; 0: all there are. Errors of a request are an answer; nothing is
/// thrown.
void serve(std::istream& in, std::ostream& out, int threads);

}  // namespace aberfit
