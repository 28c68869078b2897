#include "aberfit/core/text.h"

#include <gtest/gtest.h>

namespace aberfit {
namespace {

TEST(Text, QuotesKeepCharactersOfUtf8Whole) {
  EXPECT_EQ(in_quotes("20 \u00c5"), "'20 \u00c5'");
  EXPECT_EQ(in_quotes("\u9ad8\u3055"), "'\u9ad8\u3055'");
  EXPECT_EQ(in_quotes(std::string("a\x01\xff z", 5)), "'a?? z'");
  EXPECT_EQ(in_quotes(std::string(39, 'x') + "\u00c5y"), "'" + std::string(39, 'x') + "\u00c5...'");
}

TEST(Text, LinesThatAreNoUtf8AreWindows1252) {
  EXPECT_EQ(with_plain_blanks("\xb5m"), "\u00b5m");
  EXPECT_EQ(with_plain_blanks("1\xa0nm"), "1 nm");
  EXPECT_EQ(with_plain_blanks("1\u00a0nm\u2009\u202f"), "1 nm  ");
  EXPECT_EQ(with_plain_blanks("1 \u00b5m"), "1 \u00b5m");
}

TEST(Text, Utf16IsKnownByItsMarkOrItsZeros) {
  EXPECT_EQ(utf8_text(std::string("\xff\xfe"
                                  "a\0\xc5\0",
                                  6)),
            "\ufeffa\u00c5");
  EXPECT_EQ(utf8_text(std::string("\0a\0b\x9a\xd8", 6)), "ab\u9ad8");
  EXPECT_EQ(utf8_text(std::string("a\0b\0\x3c\xd8", 6)), "ab?");  // half of a pair
  const std::string binary("\x01\0Directory", 11);
  EXPECT_EQ(utf8_text(binary), binary);
}

TEST(Text, ADecimalCommaIsOneWhereAnotherSignSeparates) {
  for (const char* line :
       {"0,1;40,2", "0,1\t40,2", "0,1 40,2", "7 -0,1e-3", "\"0,1\",\"2\"", "x;0,5", " +0,1 ; 2"})
    EXPECT_TRUE(decimal_comma(line)) << line;
  EXPECT_EQ(decimal_comma("1;-2,5e-3").value_or(""), "-2,5e-3");
  for (const char* line :
       {"0,1", "0, 1", "0 ,1", "1,2,3", "1,2 ,3", "x, y", "1.5;2", "a,b;c", "1,234,567;8", ""})
    EXPECT_FALSE(decimal_comma(line)) << line;
}

}  // namespace
}  // namespace aberfit
