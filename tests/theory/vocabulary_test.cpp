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
  for (const FocusModel model : {FocusModel::kRays, FocusModel::kWaves})
    EXPECT_EQ(model_of(theory_of(model)), model);
  EXPECT_EQ(model_of(Theory::kRays), FocusModel::kRays);
}
