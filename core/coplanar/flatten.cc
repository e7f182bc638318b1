#include "core/coplanar/flatten.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>

#include "core/base/rounding.h"
#include "core/base/union_find.h"
#include "core/coplanar/facet_rings.h"
#include "core/coplanar/flatten_system.h"
#include "core/coplanar/plane_fit.h"
#include "core/geometry/space_predicates.h"

namespace dynmesh::coplanar {

using geometry::Point3;
using geometry::Vector3;

namespace {

constexpr int kMostTurns = 8, kMostStepsOfTurn = 400;
constexpr std::size_t kMostSteps = 200'000'000;  // of corners
// From here on all that is not flat stays, not only what is farthest off.
constexpr int kPatience = 16;
// Of heights, in ulps of the patch's largest coordinate: patches that are nearer stay; patches that
// are farther off are not flat.
constexpr double kStill = 1.5, kFlat = 12;
// How far coordinates of one value may be from it, in roundings: each is within one of what was
// meant.
constexpr double kOneValue = 2;

class Flattener {
 public:
  Flattener(const std::vector<FaceRings>& patches, const std::vector<Vector3>& roundings,
            const std::vector<Point3>& positions)
      : roundings_(roundings),
        before_(positions),
        positions_(positions),
        patches_(patches.size()),
        at_(positions.size()),
        number_(positions.size(), kNone) {
    for (std::size_t i = 0; i < patches.size(); ++i) Read(patches[i], i);
  }

  std::vector<std::size_t> Run(std::vector<Point3>& positions) {
    std::vector<std::size_t> dropped;
    for (std::vector<std::size_t>& group : Groups()) {
      const std::vector<std::size_t> bad = FlattenGroup(std::move(group));
      dropped.insert(dropped.end(), bad.begin(), bad.end());
    }
    std::sort(dropped.begin(), dropped.end());
    if (dropped.empty()) positions = std::move(positions_);
    return dropped;
  }

 private:
  static constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

  struct Patch {
    std::vector<Corner> corners;
    Vector3 normal{};
    double area = 0, ulp = 0;
    bool is_exact = false;
    // A plane that is kept: of one coordinate, or as it is.
    bool is_fixed = false;
    std::optional<std::size_t> axis;
    double value = 0;
    double off = 0;  // in ulps
    bool is_dropped = false;
  };

  void Read(const FaceRings& faces, std::size_t i) {
    Patch& patch = patches_[i];
    std::vector<PointRing> rings;
    std::size_t largest = 0;
    patch.area = -1;
    for (const CornerRing& ring : faces) {
      PointRing& points = rings.emplace_back();
      for (const Corner c : ring) points.push_back(before_[c]);
      patch.corners.insert(patch.corners.end(), ring.begin(), ring.end());
      const Vector3 vector = AreaVector(points);
      const double size = geometry::Dot(vector, vector);
      if (size <= patch.area) continue;
      patch.area = size;
      largest = rings.size() - 1;
      patch.normal = vector;
    }
    std::sort(patch.corners.begin(), patch.corners.end());
    patch.corners.erase(std::unique(patch.corners.begin(), patch.corners.end()),
                        patch.corners.end());
    double magnitude = 0;
    for (const Corner c : patch.corners) {
      at_[c].push_back(i);
      for (int k = 0; k < 3; ++k) magnitude = std::max(magnitude, std::abs(before_[c][k]));
    }
    patch.ulp = magnitude > 0 ? UlpOf(magnitude) : 0;
    patch.is_exact = IsExact(rings[largest], patch.corners);
    FindAxis(patch);
    patch.is_fixed = patch.is_exact || patch.axis;
  }

  bool IsExact(const PointRing& ring, const std::vector<Corner>& corners) const {
    const auto view = ViewOf(ring);
    if (!view) return false;
    const auto three = LeastCorner(ring, *view);
    return std::all_of(corners.begin(), corners.end(), [&](Corner c) {
      return geometry::Orientation(three[0], three[1], three[2], before_[c]) == 0;
    });
  }

  // Is it a plane of one coordinate, within rounding? Its value is the one that most corners have,
  // of several that in the middle.
  void FindAxis(Patch& patch) const {
    std::size_t axis = 0;
    for (std::size_t k = 1; k < 3; ++k) {
      if (std::abs(patch.normal[k]) > std::abs(patch.normal[axis])) axis = k;
    }
    std::vector<double> values;
    for (const Corner c : patch.corners) values.push_back(before_[c].c[axis]);
    std::sort(values.begin(), values.end());
    const double middle = values.front() + (values.back() - values.front()) / 2;
    std::ptrdiff_t most = 0;
    double value = middle;
    for (auto from = values.begin(); from != values.end();) {
      const auto to = std::upper_bound(from, values.end(), *from);
      if (to - from > most ||
          (to - from == most && std::abs(*from - middle) < std::abs(value - middle))) {
        most = to - from;
        value = *from;
      }
      from = to;
    }
    for (const Corner c : patch.corners) {
      if (!(std::abs(before_[c].c[axis] - value) <= kOneValue * roundings_[c][axis])) return;
    }
    patch.axis = axis;
    patch.value = value;
  }

  // Patches with common corners.
  std::vector<std::vector<std::size_t>> Groups() const {
    UnionFind sets(patches_.size());
    for (const std::vector<std::size_t>& patches : at_) {
      for (const std::size_t i : patches) sets.Unite(patches.front(), i);
    }
    std::vector<std::vector<std::size_t>> groups;
    std::vector<std::size_t> group_of(patches_.size(), kNone);
    for (std::size_t i = 0; i < patches_.size(); ++i) {
      std::size_t& group = group_of[sets.Find(i)];
      if (group == kNone) {
        group = groups.size();
        groups.emplace_back();
      }
      groups[group].push_back(i);
    }
    return groups;
  }

  // Returns those that cannot be flat, and places the corners of the others.
  std::vector<std::size_t> FlattenGroup(std::vector<std::size_t> group) {
    std::vector<std::size_t> dropped;
    for (int round = 0; !group.empty(); ++round) {
      Solve(group);
      std::vector<std::size_t> bad = Bad(group, round >= kPatience);
      if (bad.empty()) break;
      if (Release(bad)) continue;
      for (const std::size_t i : bad) patches_[i].is_dropped = true;
      dropped.insert(dropped.end(), bad.begin(), bad.end());
      for (const std::size_t i : bad) {
        for (const Corner c : patches_[i].corners) positions_[c] = before_[c];
      }
      std::erase_if(group, [&](std::size_t i) { return patches_[i].is_dropped; });
    }
    return dropped;
  }

  // Lets go the planes that are kept at the corners of patches; false if there is none.
  bool Release(const std::vector<std::size_t>& bad) {
    bool any = false;
    for (const std::size_t i : bad) {
      for (const Corner c : patches_[i].corners) {
        for (const std::size_t other : at_[c]) {
          Patch& patch = patches_[other];
          if (!patch.is_fixed || patch.is_dropped) continue;
          patch.is_fixed = false;
          any = true;
        }
      }
    }
    return any;
  }

  // ---- the motion of a group

  // Puts corners into planes of one coordinate. Returns what may move.
  std::vector<Vector3> Start(const std::vector<std::size_t>& group,
                             const std::vector<Corner>& corners) {
    std::vector<Vector3> weights;
    for (const Corner c : corners) {
      positions_[c] = before_[c];
      weights.push_back(roundings_[c]);
    }
    std::vector<std::size_t> order = group;
    std::stable_sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) {
      return patches_[i].area > patches_[j].area;
    });
    for (const std::size_t i : order) {
      Patch& patch = patches_[i];
      if (!patch.is_fixed || !patch.axis) continue;
      const std::size_t k = *patch.axis;
      const bool agrees = std::all_of(patch.corners.begin(), patch.corners.end(), [&](Corner c) {
        return weights[number_[c]][k] > 0 || positions_[c].c[k] == patch.value;
      });
      if (!agrees) {  // with a larger one
        patch.axis.reset();
        patch.is_fixed = patch.is_exact;
        continue;
      }
      for (const Corner c : patch.corners) {
        positions_[c].c[k] = patch.value;
        weights[number_[c]][k] = 0;
      }
    }
    return weights;
  }

  PlaneFit PlaneOf(const Patch& patch) const {
    return PlaneFit(PointsAt(patch.corners, positions_), patch.normal);
  }

  bool IsInAxis(const Patch& patch) const {
    return patch.axis && std::all_of(patch.corners.begin(), patch.corners.end(), [&](Corner c) {
             return positions_[c].c[*patch.axis] == patch.value;
           });
  }

  // How far it is off its plane, in ulps.
  double OffOf(const Patch& patch) const {
    if (IsInAxis(patch)) return 0;
    const PlaneFit plane = PlaneOf(patch);
    double off = 0;
    for (const Corner c : patch.corners) {
      off = std::max(off, std::abs(plane.Height(positions_[c])) / patch.ulp);
    }
    return off;
  }

  double Measure(const std::vector<std::size_t>& group) {
    double worst = 0;
    for (const std::size_t i : group) {
      patches_[i].off = OffOf(patches_[i]);
      worst = std::max(worst, patches_[i].off);
    }
    return worst;
  }

  void Solve(const std::vector<std::size_t>& group) {
    std::vector<Corner> corners;
    for (const std::size_t i : group) {
      corners.insert(corners.end(), patches_[i].corners.begin(), patches_[i].corners.end());
    }
    std::sort(corners.begin(), corners.end());
    corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
    for (std::size_t i = 0; i < corners.size(); ++i) number_[corners[i]] = i;
    const std::vector<Vector3> weights = Start(group, corners);
    double least = Measure(group);
    std::vector<Point3> best = PointsAt(corners, positions_);
    for (int turn = 0, fails = 0; turn < kMostTurns && least > kStill && fails < 2; ++turn) {
      Turn(group, corners, weights);
      const double worst = Measure(group);
      if (worst < least) {
        fails = worst < least / 2 ? 0 : fails + 1;
        least = worst;
        best = PointsAt(corners, positions_);
      } else {
        ++fails;
      }
    }
    for (std::size_t i = 0; i < corners.size(); ++i) positions_[corners[i]] = best[i];
    Measure(group);
  }

  static std::vector<Point3> PointsAt(const std::vector<Corner>& corners,
                                      const std::vector<Point3>& positions) {
    std::vector<Point3> points;
    for (const Corner c : corners) points.push_back(positions[c]);
    return points;
  }

  void Turn(const std::vector<std::size_t>& group, const std::vector<Corner>& corners,
            const std::vector<Vector3>& weights) {
    FlattenSystem system(weights);
    double enough = std::numeric_limits<double>::infinity();
    for (const std::size_t i : group) {
      const Patch& patch = patches_[i];
      if (IsInAxis(patch) && patch.is_fixed) continue;  // its corners cannot leave it
      double scale = 0;
      const bool is_fixed = patch.is_fixed;
      const PlaneFit plane =
          is_fixed ? PlaneFit(PointsAt(patch.corners, before_), patch.normal) : PlaneOf(patch);
      std::vector<FlattenSystem::Row> rows;
      for (const Corner c : patch.corners) {
        const std::array<double, 2> place = plane.PlaceOf(positions_[c]);
        // A plane that is kept is where its corners were, to the last bit.
        const double height =
            is_fixed
                ? geometry::Dot(plane.normal(), geometry::Difference(positions_[c].c, before_[c].c))
                : plane.Height(positions_[c]);
        rows.push_back({number_[c], place[0], place[1], height});
        scale = std::max(scale, RoundingAlong(plane.normal(), roundings_[c]));
      }
      if (!(scale > 0)) continue;
      enough = std::min(enough, patch.ulp / 8 / scale);
      system.AddPatch(plane.normal(), std::move(rows), scale, is_fixed);
    }
    if (system.size() == 0) return;
    const int most_steps = static_cast<int>(std::min<std::size_t>(
        kMostStepsOfTurn,
        (kMostSteps - std::min(kMostSteps, steps_)) / (system.size() * kMostTurns)));
    const std::vector<Vector3> motions = system.Solve(enough, most_steps);
    steps_ += system.taken();
    for (std::size_t i = 0; i < corners.size(); ++i) {
      for (std::size_t k = 0; k < 3; ++k) positions_[corners[i]].c[k] += motions[i][k];
    }
  }

  // Of corners that went too far the smallest patch; if none did, the patches that are farthest
  // off, or `all` that are.
  std::vector<std::size_t> Bad(const std::vector<std::size_t>& group, bool all) const {
    std::vector<std::size_t> bad;
    double worst = kFlat;
    for (const std::size_t i : group) {
      worst = std::max(worst, patches_[i].off);
      for (const Corner c : patches_[i].corners) {
        if (IsFar(c) && (all || SmallestAt(c) == i)) bad.push_back(i);
      }
    }
    if (bad.empty() || all) {
      for (const std::size_t i : group) {
        const double off = patches_[i].off;
        if (off > kFlat && (all || off > worst / 2)) bad.push_back(i);
      }
    }
    std::sort(bad.begin(), bad.end());
    bad.erase(std::unique(bad.begin(), bad.end()), bad.end());
    return bad;
  }

  bool IsFar(Corner c) const {
    for (std::size_t k = 0; k < 3; ++k) {
      const double moved = std::abs(positions_[c].c[k] - before_[c].c[k]);
      if (!(moved <= kMostRoundings * roundings_[c][k])) return true;
    }
    return false;
  }

  std::size_t SmallestAt(Corner c) const {
    std::size_t smallest = kNone;
    for (const std::size_t i : at_[c]) {
      if (patches_[i].is_dropped) continue;
      if (smallest == kNone || patches_[i].area < patches_[smallest].area) smallest = i;
    }
    return smallest;
  }

  const std::vector<Vector3>& roundings_;
  const std::vector<Point3> before_;
  std::vector<Point3> positions_;
  std::vector<Patch> patches_;
  std::vector<std::vector<std::size_t>> at_;  // patches, by corner
  std::vector<std::size_t> number_;           // of corners, in their group
  std::size_t steps_ = 0;
};

}  // namespace

std::vector<std::size_t> Flatten(const std::vector<FaceRings>& patches,
                                 const std::vector<Vector3>& roundings,
                                 std::vector<Point3>& positions) {
  return Flattener(patches, roundings, positions).Run(positions);
}

}  // namespace dynmesh::coplanar
