#include "core/io/common/written_digits.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "core/base/rounding.h"

namespace dynmesh::io {
namespace {

constexpr int kFewestDigits = 6;
constexpr int kDigitsOfDouble = 16;
constexpr int kMoreThanAFloatNeeds = 8;  // from here on digits say whether they are those of floats
constexpr int kMostDecimals = 400;

// 10^k, correctly rounded; 0 below the least double. REQUIRES: |k| <= kMostDecimals.
double PowerOfTen(int k) {
  static const std::vector<double>* const kPowers = [] {
    auto* powers = new std::vector<double>(2 * kMostDecimals + 1, 0);
    for (int i = -kMostDecimals; i <= std::numeric_limits<double>::max_exponent10; ++i) {
      const std::string text = "1e" + std::to_string(i);
      std::from_chars(text.data(), text.data() + text.size(),
                      (*powers)[static_cast<std::size_t>(i + kMostDecimals)]);
    }
    return powers;
  }();
  return (*kPowers)[static_cast<std::size_t>(k + kMostDecimals)];
}

// e with 10^e <= |x| < 10^(e+1). REQUIRES: x is not 0.
int DecimalExponent(double x) {
  char digits[40];
  const auto end =
      std::to_chars(digits, digits + sizeof(digits), std::abs(x), std::chars_format::scientific)
          .ptr;
  const char* at = std::find(static_cast<const char*>(digits), static_cast<const char*>(end), 'e');
  int exponent = 0;
  const bool is_negative = at[1] == '-';
  std::from_chars(at + 2, end, exponent);
  return is_negative ? -exponent : exponent;
}

bool IsDigit(char c) { return c >= '0' && c <= '9'; }

struct Digits {
  int significant = 0, decimals = 0;
};

Digits DigitsOf(std::string_view number) {
  Digits digits;
  bool behind_point = false;
  std::size_t i = 0;
  for (; i < number.size() && number[i] != 'e' && number[i] != 'E'; ++i) {
    if (number[i] == '.') behind_point = true;
    if (!IsDigit(number[i])) continue;
    if (digits.significant > 0 || number[i] != '0') ++digits.significant;
    if (behind_point) ++digits.decimals;
  }
  if (i + 1 < number.size()) {
    std::string_view text = number.substr(i + 1);
    if (text.front() == '+') text.remove_prefix(1);
    int exponent = 0;
    std::from_chars(text.data(), text.data() + text.size(), exponent);
    digits.decimals -= std::clamp(exponent, -kMostDecimals, kMostDecimals);
    if (digits.significant == 0) digits.decimals = 0;  // a zero in such a form says nothing
  }
  digits.decimals = std::clamp(digits.decimals, -kMostDecimals, kMostDecimals);
  return digits;
}

}  // namespace

double NumberRounding::Of(double coordinate) const {
  if (least >= most) return least;
  double half = last_decimal;
  if (coordinate != 0) {
    half = std::max(half, PowerOfTen(DecimalExponent(coordinate) + 1 - digits) / 2);
  }
  return std::clamp(half, least, most);
}

void WrittenDigits::AddMagnitude(double value) { largest_ = std::max(largest_, std::abs(value)); }

void WrittenDigits::AddFloat(float value) { AddMagnitude(double{value}); }

void WrittenDigits::AddDouble(double value) {
  is_double_ = true;
  AddMagnitude(value);
}

void WrittenDigits::Add(std::string_view number, double value) {
  is_text_ = true;
  AddMagnitude(value);
  const Digits written = DigitsOf(number);
  digits_ = std::max(digits_, written.significant);
  decimals_ = std::max(decimals_, written.decimals);
  if (!has_floats_ || std::abs(value) > double{std::numeric_limits<float>::max()}) {
    has_floats_ = false;
    return;
  }
  const double off = std::abs(value - double{static_cast<float>(value)});
  // The value itself is rounded, by less than the margin.
  has_floats_ = off <= PowerOfTen(-written.decimals) * 0.5000001 ||
                std::abs(value) < double{std::numeric_limits<float>::min()};
}

NumberRounding WrittenDigits::Rounding() const {
  NumberRounding rounding;
  if (largest_ == 0) return rounding;
  const double last_bit = UlpOf(largest_);
  // Half of a float's last bit is 2^-24 of its power of two.
  const double bit_of_float = std::ldexp(largest_, -24);
  if (!is_text_) {
    rounding.least = rounding.most = is_double_ ? last_bit : bit_of_float;
    return rounding;
  }
  if (decimals_ <= 0) {  // whole numbers are exact
    rounding.least = rounding.most = last_bit;
    return rounding;
  }
  if (digits_ >= kMoreThanAFloatNeeds && (has_floats_ || digits_ >= kDigitsOfDouble)) {
    rounding.least = rounding.most = has_floats_ ? bit_of_float : last_bit;
    return rounding;
  }
  rounding.digits = std::max(digits_, kFewestDigits);
  rounding.last_decimal = PowerOfTen(-decimals_) / 2;
  rounding.least = last_bit;
  rounding.most = std::max(last_bit, PowerOfTen(DecimalExponent(largest_) + 1 - kFewestDigits) / 2);
  return rounding;
}

}  // namespace dynmesh::io
