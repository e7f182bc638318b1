#include "core/io/common/written_digits.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

namespace dynmesh::io::written_digits_test {
namespace {

NumberRounding Of(const std::vector<std::string>& numbers) {
  WrittenDigits digits;
  for (const std::string& number : numbers)
    digits.Add(number, std::strtod(number.c_str(), nullptr));
  return digits.Rounding();
}

TEST(WrittenDigits, OfSixDigitsAreHalfOfTheSixth) {
  const NumberRounding rounding = Of({"12.3456", "0.00123456", "-1.5", "0"});
  EXPECT_DOUBLE_EQ(rounding.Of(12.3456), 5e-5);
  EXPECT_DOUBLE_EQ(rounding.Of(-1.5), 5e-6);
  EXPECT_DOUBLE_EQ(rounding.Of(0.00123456), 5e-9);
  EXPECT_GT(rounding.Of(0), 0);
}

TEST(WrittenDigits, OfSixDecimalsAreHalfOfTheSixthEverywhere) {
  const NumberRounding rounding = Of({"123.456789", "1.345678", "0.001235", "0.000000"});
  for (const double x : {123.456789, 1.345678, 0.001235, 0.0})
    EXPECT_DOUBLE_EQ(rounding.Of(x), 5e-7);
}

TEST(WrittenDigits, RoundNumbersRoundNoMoreThanSixDigits) {
  const NumberRounding rounding = Of({"0.5", "1", "0"});
  EXPECT_DOUBLE_EQ(rounding.Of(1), 5e-6);
  EXPECT_DOUBLE_EQ(rounding.Of(0.5), 5e-6);
  EXPECT_EQ(Of({"1", "4", "1e3"}).Of(4), std::ldexp(1, -43));  // whole ones are exact
}

TEST(WrittenDigits, FloatsAreToldByTheirValues) {
  const double float_bit = std::ldexp(0.3f, -24);
  EXPECT_NEAR(Of({"0.300000012", "0.100000001"}).Of(0.1), float_bit, 1e-15);
  // The same with all digits of doubles.
  EXPECT_EQ(Of({"0.30000001192092896", "0.10000000149011612", "0.25"}).Of(0.1), float_bit);
  const double double_bit = std::ldexp(1, -54);
  EXPECT_EQ(Of({"0.30000000000000004", "0.10000000149011612"}).Of(0.1), double_bit);
  EXPECT_EQ(Of({"0.3000000000000000", "0.1"}).Of(0.1), double_bit);
}

TEST(WrittenDigits, BinaryNumbersAreTheirType) {
  WrittenDigits floats, doubles;
  floats.AddFloat(0.3f);
  floats.AddFloat(-4);
  doubles.AddDouble(0.3);
  doubles.AddDouble(-4);
  EXPECT_EQ(floats.Rounding().Of(0.3), std::ldexp(4, -24));
  EXPECT_EQ(doubles.Rounding().Of(0.3), std::ldexp(4, -52));
  EXPECT_EQ(WrittenDigits().Rounding().Of(1), 0);
}

}  // namespace
}  // namespace dynmesh::io::written_digits_test
