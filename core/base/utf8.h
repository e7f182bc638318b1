// Reads text in UTF-8. Pure functions, O(1).
#ifndef DYNMESH_CORE_BASE_UTF8_H_
#define DYNMESH_CORE_BASE_UTF8_H_

#include <cstddef>
#include <string_view>

namespace dynmesh::utf8 {

// Reads the character at the start of `text` and returns its number of bytes; 0 if the bytes are no
// character. Surrogates, longer forms than needed and what is above U+10FFFF are none. REQUIRES:
// `text` is not empty.
inline std::size_t ReadCharacter(std::string_view text, char32_t* character) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(0);
  const std::size_t length = first < 0x80   ? 1
                             : first < 0xc2 ? 0
                             : first < 0xe0 ? 2
                             : first < 0xf0 ? 3
                             : first < 0xf5 ? 4
                                            : 0;
  if (length == 0 || length > text.size()) return 0;
  constexpr char32_t kBitsOfFirst[] = {0, 0x7f, 0x1f, 0x0f, 0x07};
  constexpr char32_t kLeast[] = {0, 0, 0x80, 0x800, 0x10000};
  char32_t c = first & kBitsOfFirst[length];
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return 0;
    c = c << 6 | (byte(i) & 0x3f);
  }
  *character = c;
  const bool is_surrogate = c >= 0xd800 && c < 0xe000;
  return c < kLeast[length] || is_surrogate || c > 0x10ffff ? 0 : length;
}

}  // namespace dynmesh::utf8

#endif  // DYNMESH_CORE_BASE_UTF8_H_
