#include <strings.h>

#include <cfloat>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <system_error>

namespace std {
namespace {

constexpr int kLongest = 32;  // "-1.7976931348623157e+308" and the exact digits of a fixed form

// Of double and float: how many digits each number of so many digits keeps, and how many suffice.
struct OfDouble {
  static constexpr int kKept = DBL_DIG, kEnough = DBL_DECIMAL_DIG;
  static constexpr double kLeastNormal = DBL_MIN;
  static double Read(const char* text, char** end) { return strtod(text, end); }
};
struct OfFloat {
  static constexpr int kKept = FLT_DIG, kEnough = FLT_DECIMAL_DIG;
  static constexpr double kLeastNormal = FLT_MIN;
  static float Read(const char* text, char** end) { return strtof(text, end); }
};

to_chars_result Put(char* first, char* last, const char* text, size_t length) {
  if (static_cast<size_t>(last - first) < length) return {last, errc::value_too_large};
  memcpy(first, text, length);
  return {first + length, errc()};
}

// "-d.ddde-05": the fewest digits that read back. Those that a number of kKept digits keeps are
// the fewest without their last zeros; denormal numbers keep fewer.
template <class Of, class T>
int PutScientific(T value, char (&text)[kLongest]) {
  int digits = fabs(value) < Of::kLeastNormal ? 1 : Of::kKept;
  int length = 0;
  for (; digits <= Of::kEnough; ++digits) {
    length = snprintf(text, sizeof text, "%.*e", digits - 1, double{value});
    if (Of::Read(text, nullptr) == value) break;
  }
  char* const exponent = strchr(text, 'e');
  char* end = exponent;
  if (strchr(text, '.') != nullptr) {
    while (end[-1] == '0') --end;
    if (end[-1] == '.') --end;
  }
  memmove(end, exponent, static_cast<size_t>(text + length - exponent) + 1);
  return length - static_cast<int>(exponent - end);
}

template <class Of, class T>
to_chars_result PutShortest(char* first, char* last, T value) {
  if (!isfinite(value)) {
    const char* const name = isnan(value) ? "-nan" : "-inf";
    return signbit(value) ? Put(first, last, name, 4) : Put(first, last, name + 1, 3);
  }
  if (value == 0) return signbit(value) ? Put(first, last, "-0", 2) : Put(first, last, "0", 1);
  char scientific[kLongest];
  const int length = PutScientific<Of>(value, scientific);
  const char* const at = strchr(scientific, 'e');
  const int exponent = atoi(at + 1);
  const int sign = scientific[0] == '-';
  const auto mantissa = static_cast<int>(at - scientific) - sign;
  const int digits = mantissa == 1 ? 1 : mantissa - 1;
  const int decimals = max(digits - 1 - exponent, 0);
  const int whole = max(exponent, 0) + 1;
  const int fixed_length = sign + whole + (decimals > 0 ? decimals + 1 : 0);
  if (fixed_length > length) return Put(first, last, scientific, static_cast<size_t>(length));
  char fixed[kLongest];
  snprintf(fixed, sizeof fixed, "%.*f", decimals, double{value});
  return Put(first, last, fixed, static_cast<size_t>(fixed_length));
}

bool IsDigit(char c) { return c >= '0' && c <= '9'; }

// Behind the number that begins at `at`; `at` if there is none.
const char* EndOfNumber(const char* at, const char* last) {
  const char* const begin = at;
  if (at != last && *at == '-') ++at;
  for (const char* const name : {"infinity", "inf", "nan"}) {
    const size_t length = strlen(name);
    if (static_cast<size_t>(last - at) >= length && strncasecmp(at, name, length) == 0) {
      return at + length;
    }
  }
  int digits = 0;
  for (; at != last && IsDigit(*at); ++at) ++digits;
  if (at != last && *at == '.') {
    const char* const point = at++;
    for (; at != last && IsDigit(*at); ++at) ++digits;
    if (at == point + 1 && digits == 0) at = point;
  }
  if (digits == 0) return begin;
  if (at == last || (*at != 'e' && *at != 'E')) return at;
  const char* power = at + 1;
  if (power != last && (*power == '-' || *power == '+')) ++power;
  if (power == last || !IsDigit(*power)) return at;
  while (power != last && IsDigit(*power)) ++power;
  return power;
}

template <class Of, class T>
from_chars_result Read(const char* first, const char* last, T& value) {
  const char* const end = EndOfNumber(first, last);
  if (end == first) return {first, errc::invalid_argument};
  const string text(first, end);
  const T read = Of::Read(text.c_str(), nullptr);
  const char* const digits = text.c_str() + (text[0] == '-');
  const bool is_too_large = isinf(read) && digits[0] != 'i' && digits[0] != 'I';
  const auto mantissa = text.find_first_of("123456789");
  const bool is_too_small = read == 0 && mantissa < min(text.find_first_of("eE"), text.size());
  if (is_too_large || is_too_small) return {end, errc::result_out_of_range};
  value = read;
  return {end, errc()};
}

}  // namespace

to_chars_result to_chars(char* first, char* last, double value) {
  return PutShortest<OfDouble>(first, last, value);
}

to_chars_result to_chars(char* first, char* last, float value) {
  return PutShortest<OfFloat>(first, last, value);
}

to_chars_result to_chars(char* first, char* last, double value, chars_format format) {
  if (format != chars_format::scientific) return PutShortest<OfDouble>(first, last, value);
  char text[kLongest];
  return Put(first, last, text, static_cast<size_t>(PutScientific<OfDouble>(value, text)));
}

to_chars_result to_chars(char* first, char* last, double value, chars_format, int precision) {
  char text[kLongest];
  const int length = snprintf(text, sizeof text, "%.*g", precision, value);
  return Put(first, last, text, static_cast<size_t>(length));
}

from_chars_result from_chars(const char* first, const char* last, double& value) {
  return Read<OfDouble>(first, last, value);
}

from_chars_result from_chars(const char* first, const char* last, float& value) {
  return Read<OfFloat>(first, last, value);
}

}  // namespace std
