// Random polygons of all kinds that a mesh refuses, over messy points and segments.
#ifndef DYNMESH_TESTS_CLIENT_CLEANING_MESSY_POLYGONS_H_
#define DYNMESH_TESTS_CLIENT_CLEANING_MESSY_POLYGONS_H_

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <utility>
#include <vector>

#include "dynmesh/feature.h"
#include "tests/client/cleaning/messy_input.h"

namespace dynmesh::cleaning {

// In the unit square: polygons that overlap; neighbours that share points, or have copies of them
// up to `near` away; rings that cross themselves, visit a point twice, go there and back, are
// duplicated or are smaller than `near`; holes and islands; sizing polygons. Half of them among
// points and segments of MessyInput.
class MessyPolygons {
 public:
  MessyPolygons(std::uint64_t seed, double near) : random_(seed * 2 + 1), near_(near) {
    if (Below(2) == 0) features_ = MessyInput(seed, near).Features();
    for (const Feature& f : features_) {
      if (f.kind == FeatureKind::kPoint) at_.push_back({f.position[0], f.position[1]});
      if (f.kind == FeatureKind::kPoint) points_.push_back(f.id);
    }
    last_ = features_.size();
    const int count = 1 + Below(6);
    for (int i = 0; i < count; ++i) AddPolygon();
  }

  const std::vector<Feature>& Features() const { return features_; }

 private:
  using Ring = std::vector<FeatureId>;
  using Spot = std::array<double, 2>;

  int Below(int n) { return static_cast<int>(random_() % static_cast<std::uint64_t>(n)); }
  double Unit() { return static_cast<double>(random_() >> 11) * 0x1p-53; }

  FeatureId Add(Spot p) {
    for (double& x : p) x = std::min(1.0, std::max(0.0, x));
    features_.push_back(Feature::Point(++last_, p[0], p[1]));
    at_.push_back(p);
    points_.push_back(last_);
    return last_;
  }
  const Spot& At(FeatureId id) const {
    return at_[static_cast<std::size_t>(std::find(points_.begin(), points_.end(), id) -
                                        points_.begin())];
  }
  FeatureId Beside(FeatureId id, double distance) {
    const double angle = 6.283185307179586 * Unit();
    const Spot p = At(id);
    return Add({p[0] + distance * std::cos(angle), p[1] + distance * std::sin(angle)});
  }

  Ring Blob(double size) {
    const Spot middle = {Unit(), Unit()};
    const int corners = 3 + Below(7);
    Ring ring;
    for (int i = 0; i < corners; ++i) {
      const double angle = 6.283185307179586 * (i + 0.8 * Unit()) / corners;
      const double r = size * (0.3 + 0.7 * Unit());
      ring.push_back(Add({middle[0] + r * std::cos(angle), middle[1] + r * std::sin(angle)}));
    }
    return ring;
  }

  // Shares a run of the corners of another ring, exactly or nearly, and goes on elsewhere.
  Ring NeighbourOf(const Ring& other) {
    const bool exact = Below(2) == 0;
    Ring ring;
    const auto from = random_() % other.size();
    const auto run = 2 + random_() % other.size();
    for (std::size_t i = 0; i < std::min(run, other.size()); ++i) {
      const FeatureId corner = other[(from + i) % other.size()];
      ring.push_back(exact ? corner : Beside(corner, 0.9 * near_ * Unit()));
    }
    const int more = 1 + Below(3);
    for (int i = 0; i < more; ++i) ring.push_back(Add({Unit(), Unit()}));
    return ring;
  }

  Ring AnyRing() {
    switch (rings_.empty() ? Below(3) : Below(8)) {
      case 0:
      case 1:
        return Blob(0.05 + 0.5 * Unit());
      case 2: {  // crosses itself
        Ring ring;
        const int corners = 3 + Below(5);
        for (int i = 0; i < corners; ++i) ring.push_back(Add({Unit(), Unit()}));
        return ring;
      }
      case 3:  // smaller than a place
        return Blob(near_ * Unit());
      case 4:  // through points that are there
      {
        Ring ring;
        const int corners = 2 + Below(5);
        for (int i = 0; i < corners; ++i) ring.push_back(points_[random_() % points_.size()]);
        return ring;
      }
      default:
        return NeighbourOf(rings_[random_() % rings_.size()]);
    }
  }

  // Goes there and back, comes again, stands on the spot.
  void Spoil(Ring& ring) {
    const auto i = static_cast<std::ptrdiff_t>(random_() % ring.size());
    const FeatureId corner = ring[static_cast<std::size_t>(i)];
    switch (Below(6)) {
      case 0: {
        const Ring spike = {Add({Unit(), Unit()}), corner};
        ring.insert(ring.begin() + i + 1, spike.begin(), spike.end());
        break;
      }
      case 1:
        ring.insert(ring.begin() + i, corner);
        break;
      case 2:
        ring.push_back(corner);
        break;
      case 3:
        ring.insert(ring.begin() + i, Beside(corner, near_ * Unit()));
        break;
      default:
        break;
    }
  }

  void AddPolygon() {
    Rings rings;
    const int count = Below(3) == 0 ? 1 + Below(3) : 1;
    for (int i = 0; i < count; ++i) {
      Ring ring = AnyRing();
      Spoil(ring);
      rings_.push_back(ring);
      rings.push_back(std::move(ring));
    }
    if (Below(12) == 0) rings.push_back(rings.front());
    features_.push_back(Below(6) == 0 ? Feature::SizePolygon(++last_, std::move(rings), 0.1)
                                      : Feature::Polygon(++last_, std::move(rings)));
  }

  std::mt19937_64 random_;
  double near_;
  std::vector<Feature> features_;
  std::vector<FeatureId> points_;
  std::vector<Spot> at_;  // of points_
  std::vector<Ring> rings_;
  FeatureId last_ = 0;
};

}  // namespace dynmesh::cleaning

#endif  // DYNMESH_TESTS_CLIENT_CLEANING_MESSY_POLYGONS_H_
