// Small text functions with std::string_view. Abseil's string_view may be another type, depending
// on its build. Pure functions.
#ifndef DYNMESH_CORE_BASE_TEXT_H_
#define DYNMESH_CORE_BASE_TEXT_H_

#include <charconv>
#include <concepts>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "absl/strings/string_view.h"

namespace dynmesh::text {

// Abseil's string_view as std::string_view.
inline std::string_view View(absl::string_view text) { return {text.data(), text.size()}; }

inline void Append(std::string& to, std::string_view text) { to.append(text); }
inline void Append(std::string& to, char c) { to.push_back(c); }
template <class T>
requires std::integral<T> || std::floating_point<T>
void Append(std::string& to, T value) {  // floating point: shortest, reads back exactly
  char digits[32];
  to.append(digits, std::to_chars(digits, digits + sizeof(digits), value).ptr);
}

// The concatenation of texts, characters and numbers.
template <class... Parts>
std::string Concat(const Parts&... parts) {
  std::string result;
  (Append(result, parts), ...);
  return result;
}

// 16 lower-case hexadecimal digits.
inline std::string Hex(std::uint64_t word) {
  std::string digits(16, '0');
  for (std::size_t i = 16; i-- > 0; word >>= 4) digits[i] = "0123456789abcdef"[word & 15];
  return digits;
}

// Quoted for a message: without control characters, cut after 40 bytes. The input may be binary or
// very long.
inline std::string Quoted(std::string_view text) {
  constexpr std::size_t kLongest = 40;
  std::string result = "'";
  for (const char c : text.substr(0, kLongest)) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte >= 0x20 && byte != 0x7f) {
      result.push_back(c);
    } else {
      constexpr char kDigits[] = "0123456789abcdef";
      result += {'\\', 'x', kDigits[byte >> 4], kDigits[byte & 15]};
    }
  }
  return result + (text.size() > kLongest ? "...'" : "'");
}

// The parts between separators, including empty ones.
inline std::vector<std::string_view> Split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (;;) {
    const std::size_t end = text.find(separator);
    parts.push_back(text.substr(0, end));
    if (end == std::string_view::npos) return parts;
    text.remove_prefix(end + 1);
  }
}

}  // namespace dynmesh::text

#endif  // DYNMESH_CORE_BASE_TEXT_H_
