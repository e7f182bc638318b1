// Colours by value, for pictures. Pure functions.
#ifndef DYNMESH_CORE_IO_PICTURES_COLOUR_RAMP_H_
#define DYNMESH_CORE_IO_PICTURES_COLOUR_RAMP_H_

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <string_view>

#include "absl/strings/str_format.h"

namespace dynmesh::io {

struct Rgb {
  double r, g, b;  // 0 to 255
};
template <std::size_t N>
using ColourRamp = std::array<Rgb, N>;

// Bad to good: values that no mesh of dynmesh has are red, usual ones are pale.
inline constexpr ColourRamp<7> kQualityRamp = {{{178, 24, 43},
                                                {214, 96, 77},
                                                {249, 214, 178},
                                                {246, 238, 226},
                                                {221, 234, 242},
                                                {180, 211, 230},
                                                {130, 178, 210}}};
// Fine to coarse: blue over green to pale yellow, each step lighter, all light enough for dark
// lines.
inline constexpr ColourRamp<6> kSizeRamp = {{{52, 98, 178},
                                             {38, 142, 190},
                                             {66, 178, 182},
                                             {132, 206, 170},
                                             {204, 230, 176},
                                             {252, 249, 220}}};

// "#rrggbb" at t, 0 (start of the ramp) to 1.
template <std::size_t N>
std::string ColourAt(const ColourRamp<N>& ramp, double t) {
  const double at = std::clamp(t, 0.0, 1.0) * (N - 1);
  const std::size_t i = std::min(static_cast<std::size_t>(at), N - 2);
  const double f = at - static_cast<double>(i);
  const auto blend = [f](double a, double b) {
    return static_cast<unsigned>(std::lround(a + (b - a) * f));
  };
  return absl::StrFormat("#%02x%02x%02x", blend(ramp[i].r, ramp[i + 1].r),
                         blend(ramp[i].g, ramp[i + 1].g), blend(ramp[i].b, ramp[i + 1].b));
}

// "#rrggbb", darker: `light` from 0 to 1.
inline std::string ShadedColour(std::string_view colour, double light) {
  std::string shaded = "#";
  for (std::size_t k = 1; k + 1 < colour.size(); k += 2) {
    const auto digit = [&](std::size_t i) {
      return colour[i] <= '9' ? colour[i] - '0' : colour[i] - 'a' + 10;
    };
    const double channel = light * (16 * digit(k) + digit(k + 1));
    shaded += absl::StrFormat("%02x", static_cast<unsigned>(std::lround(channel)));
  }
  return shaded;
}

// "#rrggbb" for item n of any number of items. Hues are a golden angle apart, so no two of a long
// run are close to each other. Light and dark alternate, so neighbours also differ without hues.
inline std::string DistinctColour(std::size_t n) {
  const double hue = std::fmod(0.618033988749895 * static_cast<double>(n), 1.0);
  const double lightness = n % 2 == 0 ? 0.82 : 0.66;
  const double reach = 0.6 * (1 - std::abs(2 * lightness - 1)) / 2;
  const auto channel = [&](double offset) {
    // Around the circle: rises for a sixth, constant for a third, falls for a sixth.
    const double at = std::fmod(hue + offset, 1.0) * 6;
    const double level = std::clamp(std::abs(at - 3) - 1, 0.0, 1.0);
    return static_cast<unsigned>(std::lround(255 * (lightness + reach * (2 * level - 1))));
  };
  return absl::StrFormat("#%02x%02x%02x", channel(0), channel(2.0 / 3), channel(1.0 / 3));
}

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_PICTURES_COLOUR_RAMP_H_
