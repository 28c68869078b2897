#include "aberfit/theory/vocabulary.h"

#include <gtest/gtest.h>

using namespace aberfit;

TEST(Vocabulary, EveryTheoryAndModelHasItsWord) {
  EXPECT_EQ(to_string(Theory::kGeometric), "geometric");
  EXPECT_EQ(to_string(Theory::kRays), "rays");
  EXPECT_EQ(to_string(Theory::kGhs), "ghs");
  EXPECT_EQ(to_string(FocusModel::kRays), "rays");
  EXPECT_EQ(to_string(FocusModel::kWaves), "waves");
}

TEST(Vocabulary, AModelAndItsClosedFormBelongTogether) {
  EXPECT_EQ(model_of(Theory::kGhs), FocusModel::kWaves);
  EXPECT_EQ(model_of(Theory::kGeometric), FocusModel::kRays);
  EXPECT_EQ(model_of(Theory::kRays), FocusModel::kRays);
}
