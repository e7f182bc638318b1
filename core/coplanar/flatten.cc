#include "core/coplanar/flatten.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/base/rounding.h"
#include "core/coplanar/facet_rings.h"
#include "core/coplanar/plane_fit.h"
#include "core/geometry/space_predicates.h"

namespace dynmesh::coplanar {

using geometry::Point3;
using geometry::Vector3;

namespace {

constexpr int kMostTurns = 600;
constexpr std::size_t kMostSteps = 20'000'000;  // of corners
// Of heights, in ulps of the patch's largest coordinate: corners that are nearer do not move;
// patches that are farther off are not flat.
constexpr double kStill = 1, kFlat = 12;

class Flattener {
 public:
  Flattener(const std::vector<FaceRings>& patches, const std::vector<Vector3>& roundings,
            const std::vector<Point3>& positions)
      : roundings_(roundings), before_(positions), patches_(patches.size()), at_(positions.size()) {
    for (std::size_t i = 0; i < patches.size(); ++i) {
      Patch& patch = patches_[i];
      std::set<Corner> corners;
      std::size_t largest = 0;
      double area = -1;
      std::vector<PointRing> rings;
      for (const CornerRing& ring : patches[i]) {
        PointRing& points = rings.emplace_back();
        for (const Corner c : ring) points.push_back(positions[c]);
        corners.insert(ring.begin(), ring.end());
        const Vector3 vector = AreaVector(points);
        const double size = geometry::Dot(vector, vector);
        if (size <= area) continue;
        area = size;
        largest = rings.size() - 1;
        patch.normal = vector;
      }
      patch.area = area;
      patch.corners.assign(corners.begin(), corners.end());
      double magnitude = 0;
      for (const Corner c : patch.corners) {
        at_[c].push_back(i);
        for (int k = 0; k < 3; ++k) magnitude = std::max(magnitude, std::abs(positions[c][k]));
      }
      patch.ulp = magnitude > 0 ? UlpOf(magnitude) : 0;
      patch.is_exact = IsExact(rings[largest], patch.corners);
    }
  }

  std::vector<std::size_t> Run(std::vector<Point3>& positions) {
    std::vector<std::size_t> bad;
    for (const bool keeps_planes : {true, false}) {
      positions_ = before_;
      keeps_planes_ = keeps_planes;
      Pull();
      bad = Bad();
      if (!bad.empty()) continue;
      positions = positions_;
      break;
    }
    return bad;
  }

 private:
  struct Patch {
    std::vector<Corner> corners;
    Vector3 normal{};
    double area = 0, ulp = 0;
    bool is_exact = false;
    bool is_due = true;
  };

  bool IsExact(const PointRing& ring, const std::vector<Corner>& corners) const {
    const auto view = ViewOf(ring);
    if (!view) return false;
    const auto three = LeastCorner(ring, *view);
    return std::all_of(corners.begin(), corners.end(), [&](Corner c) {
      return geometry::Orientation(three[0], three[1], three[2], before_[c]) == 0;
    });
  }

  static std::vector<Point3> Of(const std::vector<Corner>& corners,
                                const std::vector<Point3>& positions) {
    std::vector<Point3> points;
    for (const Corner c : corners) points.push_back(positions[c]);
    return points;
  }

  PlaneFit PlaneOf(const Patch& patch) const {
    const bool is_kept = keeps_planes_ && patch.is_exact;
    return PlaneFit(Of(patch.corners, is_kept ? before_ : positions_), patch.normal);
  }

  void Pull() {
    for (Patch& patch : patches_) patch.is_due = true;
    std::size_t steps = 0;
    for (int turn = 0; turn < kMostTurns && steps < kMostSteps; ++turn) {
      bool any = false;
      for (Patch& patch : patches_) {
        if (!patch.is_due) continue;
        patch.is_due = false;
        steps += patch.corners.size();
        const PlaneFit plane = PlaneOf(patch);
        const Vector3& n = plane.normal();
        for (const Corner c : patch.corners) {
          const double height = plane.Height(positions_[c]);
          if (!(std::abs(height) > kStill * patch.ulp)) continue;
          // To the plane, along the way that is shortest in roundings.
          Vector3 way{};
          double along = 0;
          for (std::size_t k = 0; k < 3; ++k) {
            way[k] = roundings_[c][k] * roundings_[c][k] * n[k];
            along += way[k] * n[k];
          }
          if (!(along > 0)) continue;
          for (std::size_t k = 0; k < 3; ++k) positions_[c].c[k] -= height / along * way[k];
          any = true;
          for (const std::size_t other : at_[c]) patches_[other].is_due = true;
        }
      }
      if (!any) return;
    }
  }

  std::vector<std::size_t> Bad() const {
    std::set<std::size_t> bad;
    // Of corners that went too far, the smallest patch.
    for (Corner c = 0; c < at_.size(); ++c) {
      bool is_far = false;
      for (std::size_t k = 0; k < 3; ++k) {
        const double moved = std::abs(positions_[c].c[k] - before_[c].c[k]);
        is_far = is_far || !(moved <= kMostRoundings * roundings_[c][k]);
      }
      if (!is_far || at_[c].empty()) continue;
      bad.insert(*std::min_element(at_[c].begin(), at_[c].end(), [&](std::size_t p, std::size_t q) {
        return patches_[p].area != patches_[q].area ? patches_[p].area < patches_[q].area : p < q;
      }));
    }
    if (!bad.empty()) return {bad.begin(), bad.end()};
    std::vector<double> off(patches_.size());
    double worst = kFlat;
    for (std::size_t i = 0; i < patches_.size(); ++i) {
      const Patch& patch = patches_[i];
      const PlaneFit plane(Of(patch.corners, positions_), patch.normal);
      for (const Corner c : patch.corners) {
        off[i] = std::max(off[i], std::abs(plane.Height(positions_[c])) / patch.ulp);
      }
      worst = std::max(worst, off[i]);
    }
    for (std::size_t i = 0; i < off.size(); ++i) {
      if (off[i] > kFlat && off[i] > worst / 2) bad.insert(i);
    }
    return {bad.begin(), bad.end()};
  }

  const std::vector<Vector3>& roundings_;
  const std::vector<Point3> before_;
  std::vector<Point3> positions_;
  std::vector<Patch> patches_;
  std::vector<std::vector<std::size_t>> at_;  // patches, by corner
  bool keeps_planes_ = true;
};

}  // namespace

std::vector<std::size_t> Flatten(const std::vector<FaceRings>& patches,
                                 const std::vector<Vector3>& roundings,
                                 std::vector<Point3>& positions) {
  return Flattener(patches, roundings, positions).Run(positions);
}

}  // namespace dynmesh::coplanar
