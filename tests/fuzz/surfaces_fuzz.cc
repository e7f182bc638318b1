#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "client/cleaning/clean_surfaces.h"
#include "tests/client/cleaning/surface_oracle.h"
#include "tests/fuzz/targets.h"

namespace dynmesh::fuzz {
namespace {

constexpr std::size_t kMostFaces = 20;

// A byte has the size of steps beside a lattice, then a face is a byte with its number of corners
// and three bytes a corner: a place of the lattice, and steps from it.
std::vector<Feature> FeaturesOf(std::string_view bytes) {
  std::vector<Feature> points, faces;
  std::size_t next = 0;
  const auto take = [&] {
    return next < bytes.size() ? static_cast<unsigned char>(bytes[next++]) : 0;
  };
  const double step = std::ldexp(1.0, -1 - take() % 50);
  FeatureId id = 0;
  while (next < bytes.size() && faces.size() < kMostFaces) {
    const int kind = take();
    std::vector<FeatureId> ring;
    for (int corners = kind % 4 == 0 ? 4 : kind % 32 == 1 ? 2 : 3; corners > 0; --corners) {
      std::array<double, 3> p{};
      for (double& x : p) {
        const int value = take();
        x = value % 8 + (value / 8 % 8 == 0 ? value / 64 * step : 0);
      }
      points.push_back(Feature::Point(++id, p[0], p[1], p[2]));
      ring.push_back(id);
    }
    faces.push_back(ring.size() == 2 ? Feature::Segment(0, ring[0], ring[1])
                                     : Feature::Polygon(0, {std::move(ring)}));
  }
  for (Feature& f : faces) {
    f.id = ++id;
    points.push_back(std::move(f));
  }
  return points;
}

}  // namespace

std::string FuzzSurfaces(std::string_view bytes) {
  const std::vector<Feature> features = FeaturesOf(bytes);
  cleaning::SurfaceCleanOptions options;
  options.tolerance = 0x1p-36;
  options.max_crossings = 20'000;
  const auto cleaned = cleaning::CleanSurfaces(features, options);
  if (!cleaned.ok()) {
    return absl::IsResourceExhausted(cleaned.status()) ? "" : cleaned.status().ToString();
  }
  if (cleaned->features.size() > 3000) return "";  // the oracle looks at all pairs
  if (auto fault = cleaning::FaultOf(cleaning::PlainOf(cleaned->features)); !fault.empty()) {
    return fault;
  }
  const auto again = cleaning::CleanSurfaces(cleaned->features, options);
  if (!again.ok()) return again.status().ToString();
  if (again->features != cleaned->features) return "cleaned again, it is another surface";
  std::vector<Feature> backwards(features.rbegin(), features.rend());
  for (Feature& f : backwards) {
    for (auto& ring : f.rings) std::reverse(ring.begin(), ring.end());
  }
  const auto turned = cleaning::CleanSurfaces(backwards, options);
  if (!turned.ok()) return turned.status().ToString();
  return cleaning::FacesOf(turned->features) == cleaning::FacesOf(cleaned->features)
             ? ""
             : "the result depends on the order of faces";
}

}  // namespace dynmesh::fuzz
