// What the matrix of random scenes rests on: its scenes are readable and as varied as they say, what counts
// as a failure does, the second opinion sees what it should, and a few quick rows of each day.
#include <gtest/gtest.h>

TEST(RandomScenes, Placeholder) {}
