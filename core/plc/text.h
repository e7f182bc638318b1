// Numbers and positions in messages. Pure functions.
#ifndef DYNMESH_CORE_PLC_TEXT_H_
#define DYNMESH_CORE_PLC_TEXT_H_

#include <algorithm>
#include <array>
#include <charconv>
#include <string>

#include "absl/strings/str_cat.h"
#include "core/geometry/point.h"

namespace dynmesh::plc {

inline std::string Shortest(double x) {
  std::array<char, 32> text;
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), x).ptr};
}

// "(0.5, 1)".
template <int D>
std::string Text(const geometry::Point<D>& p) {
  std::string text = "(";
  for (int i = 0; i < D; ++i) absl::StrAppend(&text, i == 0 ? "" : ", ", Shortest(p[i]));
  return text + ")";
}

template <int D>
geometry::Point<D> CornerOf(const std::array<double, 3>& c) {
  geometry::Point<D> p;
  std::copy_n(c.begin(), D, p.c.begin());
  return p;
}

}  // namespace dynmesh::plc

#endif  // DYNMESH_CORE_PLC_TEXT_H_
