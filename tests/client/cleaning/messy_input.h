// Random input of all kinds that a mesh refuses.
#ifndef DYNMESH_TESTS_CLIENT_CLEANING_MESSY_INPUT_H_
#define DYNMESH_TESTS_CLIENT_CLEANING_MESSY_INPUT_H_

#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "dynmesh/feature.h"

namespace dynmesh::cleaning {

// Points and segments in the unit square: random ones that cross, copies of points and
// points a fraction of `near` away, points on and beside segments, T-junctions, segments that
// share a part or stand twice, needles, segments of no length. Some on a coarse grid, so
// that everything is collinear with something.
class MessyInput {
 public:
  MessyInput(std::uint64_t seed, double near) : random_(seed), near_(near) {
    on_grid_ = Below(3) == 0;
    const int steps = 5 + Below(25);
    for (int i = 0; i < steps; ++i) Step();
  }

  // Points 1..n, then segments.
  std::vector<Feature> Features() const {
    std::vector<Feature> features;
    FeatureId id = 0;
    for (const auto& p : points_) features.push_back(Feature::Point(++id, p[0], p[1]));
    for (const auto& s : segments_) {
      features.push_back(Feature::Segment(++id, s[0] + 1, s[1] + 1));
    }
    return features;
  }

 private:
  using Point = std::array<double, 2>;

  int Below(int n) { return static_cast<int>(random_() % static_cast<std::uint64_t>(n)); }
  double Unit() { return static_cast<double>(random_() >> 11) * 0x1p-53; }
  double Coordinate() { return on_grid_ ? Below(9) / 8.0 : Unit(); }
  double Clip(double x) const { return std::min(1.0, std::max(0.0, x)); }

  std::size_t Add(Point p) {
    points_.push_back({Clip(p[0]), Clip(p[1])});
    return points_.size() - 1;
  }
  std::size_t AddAnywhere() { return Add({Coordinate(), Coordinate()}); }
  std::size_t AnyPoint() { return points_.empty() ? AddAnywhere() : random_() % points_.size(); }
  std::size_t AddBeside(const Point& p, double distance) {
    const double angle = 6.283185307179586 * Unit();
    return Add({p[0] + distance * std::cos(angle), p[1] + distance * std::sin(angle)});
  }
  void Join(std::size_t a, std::size_t b) { segments_.push_back({a, b}); }
  Point On(const std::array<std::size_t, 2>& s, double t) const {
    const Point &p = points_[s[0]], &q = points_[s[1]];
    return {p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])};
  }

  void Step() {
    if (segments_.empty()) Join(AddAnywhere(), AddAnywhere());
    const auto s = segments_[random_() % segments_.size()];
    switch (Below(11)) {
      case 0:
        AddAnywhere();
        break;
      case 1:
      case 2:
        Join(AddAnywhere(), AddAnywhere());
        break;
      case 3:
        Join(AnyPoint(), AnyPoint());  // maybe of no length
        break;
      case 4:
        Add(points_[AnyPoint()]);
        break;
      case 5:
        AddBeside(points_[AnyPoint()], near_ * 1.5 * Unit());
        break;
      case 6:  // a T, nearly
        Join(AddBeside(On(s, Unit()), near_ * Unit()), AddAnywhere());
        break;
      case 7:  // a part of s, and more
        Join(Add(On(s, Unit())), Add(On(s, 2 * Unit() - 0.5)));
        break;
      case 8:
        Join(s[Below(2)], s[Below(2)]);  // again, maybe backwards
        break;
      case 9:  // along s, a little off
        Join(AddBeside(On(s, Unit()), near_ * Unit()), AddBeside(On(s, Unit()), near_ * Unit()));
        break;
      default:  // a needle
        Join(s[0], AddBeside(On(s, Unit()), 1e-6 * Unit()));
        break;
    }
  }

  std::mt19937_64 random_;
  double near_;
  bool on_grid_ = false;
  std::vector<Point> points_;
  std::vector<std::array<std::size_t, 2>> segments_;
};

}  // namespace dynmesh::cleaning

#endif  // DYNMESH_TESTS_CLIENT_CLEANING_MESSY_INPUT_H_
