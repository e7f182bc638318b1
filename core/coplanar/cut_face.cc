#include "core/coplanar/cut_face.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "core/coplanar/facet_rings.h"
#include "core/geometry/circumball.h"

namespace dynmesh::coplanar {

using geometry::Cross;
using geometry::Difference;
using geometry::Dot;
using geometry::Point3;
using geometry::Vector3;

namespace {

constexpr std::size_t kMostCut = 200;

class EarCutter {
 public:
  EarCutter(const std::vector<Point3>& positions, CornerRing ring)
      : positions_(positions), ring_(std::move(ring)) {
    PointRing points;
    for (const Corner c : ring_) points.push_back(positions[c]);
    normal_ = AreaVector(points);
  }

  std::vector<CornerRing> Run() {
    std::vector<CornerRing> triangles;
    if (!(Dot(normal_, normal_) > 0)) return triangles;
    while (ring_.size() > 3) {
      std::size_t best = 0;
      double most = -std::numeric_limits<double>::infinity();
      for (std::size_t i = 0; i < ring_.size(); ++i) {
        const double quality = QualityOf(i);
        if (quality > most || (quality == most && ring_[i] < ring_[best])) {
          most = quality;
          best = i;
        }
      }
      triangles.push_back({At(best, -1), ring_[best], At(best, 1)});
      ring_.erase(ring_.begin() + static_cast<std::ptrdiff_t>(best));
    }
    triangles.push_back(ring_);
    return triangles;
  }

 private:
  Corner At(std::size_t i, int by) const {
    const std::size_t n = ring_.size();
    return ring_[(i + n + static_cast<std::size_t>(by + static_cast<int>(n))) % n];
  }
  double Side(Corner a, Corner b, Corner c) const {
    return Dot(normal_, Cross(Difference(positions_[b].c, positions_[a].c),
                              Difference(positions_[c].c, positions_[a].c)));
  }

  // The area over the square of the longest edge, less for what is no ear. For a quadrangle that of
  // the worse half.
  double QualityOf(std::size_t i) const {
    const Corner a = At(i, -1), b = ring_[i], c = At(i, 1);
    double quality = Shape(a, b, c);
    for (const Corner other : ring_) {
      if (other == a || other == b || other == c) continue;
      if (Side(a, b, other) >= 0 && Side(b, c, other) >= 0 && Side(c, a, other) >= 0) {
        quality = std::min(quality, -1.0);
      }
    }
    if (ring_.size() == 4) quality = std::min(quality, Shape(a, c, At(i, 2)));
    return quality;
  }

  double Shape(Corner a, Corner b, Corner c) const {
    const double longest = std::max({geometry::SquaredDistance(positions_[a], positions_[b]),
                                     geometry::SquaredDistance(positions_[b], positions_[c]),
                                     geometry::SquaredDistance(positions_[c], positions_[a])});
    return Side(a, b, c) / longest / std::sqrt(Dot(normal_, normal_));
  }

  const std::vector<Point3>& positions_;
  CornerRing ring_;
  Vector3 normal_;
};

}  // namespace

std::vector<CornerRing> CutFace(const std::vector<Point3>& positions, const CornerRing& ring) {
  if (ring.size() < 4 || ring.size() > kMostCut) return {};
  return EarCutter(positions, Canonical({ring}).front()).Run();
}

}  // namespace dynmesh::coplanar
