// The progress line of a fit: set of terms, distance from the tolerances, expected end.
#include "../../src/method/fit_progress.h"

#include <gtest/gtest.h>

#include <cmath>

namespace aberfit::internal {
namespace {

// A mismatch that falls by e in each iteration of 0.5 s.
FitProgress falling(int iteration, double from) {
  FitProgress p;
  p.iteration = iteration;
  p.worst_mismatch = from * std::exp(-iteration);
  p.seconds = 0.5 * iteration;
  return p;
}

TEST(FitProgressLine, EndsWhereAGeometricFallReachesTheTolerances) {
  // From e^6 to 1 takes six iterations, four of which are left after two.
  EXPECT_NEAR(seconds_left(falling(0, std::exp(6.0)), falling(2, std::exp(6.0))), 2, 1e-12);
  // A mismatch within the tolerances has nothing left.
  EXPECT_EQ(seconds_left(falling(0, std::exp(2.0)), falling(3, std::exp(2.0))), 0);
  FitProgress rests = falling(0, 7);
  rests.iteration = 3;
  EXPECT_TRUE(std::isnan(seconds_left(falling(0, 7), rests)));
}

TEST(FitProgressLine, SaysSetIterationDistanceTimeAndEnd) {
  FitProgressLine line(1650, 2, 3);
  EXPECT_EQ(line(falling(0, std::exp(6.0))),
            "fit: set 2 of at most 3, 1650 terms; iteration 0, largest mismatch 403 tolerances, 0.0 s");
  EXPECT_EQ(line(falling(2, std::exp(6.0))),
            "fit: set 2 of at most 3, 1650 terms; iteration 2, largest mismatch 54.6 tolerances, 1.0 s, "
            "probably 3 s in all");
}

TEST(FitProgressLine, WithoutAPaceSaysARangeOrThatNoEndIsInSight) {
  FitProgressLine line(12);
  line(falling(0, 5));
  FitProgress p = falling(0, 5);
  p.iteration = 1;
  p.seconds = 0.5;
  EXPECT_NE(line(p).find("probably 5 to 20 s in all"), std::string::npos) << line(p);
  p.iteration = 20;
  p.seconds = 10;
  EXPECT_NE(line(p).find("end not foreseeable"), std::string::npos) << line(p);
}

TEST(FitProgressLine, CountsThePaceOfOneSolve) {
  FitProgressLine line(12);
  line(falling(0, std::exp(6.0)));
  FitProgress p = falling(4, std::exp(10.0));
  p.solve = 1;
  EXPECT_EQ(line(p).find("end"), std::string::npos) << line(p);
  FitProgress next = p;  // from e^6 by e^2 in 0.5 s: two iterations are left
  next.iteration = 5;
  next.seconds += 0.5;
  next.worst_mismatch = std::exp(4.0);
  EXPECT_NE(line(next).find("probably 3.5 s in all"), std::string::npos) << line(next);
}

}  // namespace
}  // namespace aberfit::internal
