#include "core/coplanar/needles.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <span>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "core/base/rings.h"
#include "core/coplanar/facet_rings.h"
#include "core/geometry/circumball.h"
#include "core/geometry/collinear.h"

namespace dynmesh::coplanar {

using geometry::Point3;

namespace {

constexpr std::size_t kMostCorners = 16;

class NeedleDropper {
 public:
  NeedleDropper(const std::vector<Point3>& positions, const std::function<double(Corner)>& within,
                const std::vector<CornerPair>& segments, std::vector<CornerRing>& rings)
      : positions_(positions), within_(within), segments_(segments), rings_(rings) {}

  std::size_t Run() {
    for (std::size_t f = 0; f < rings_.size(); ++f) Look(f);
    if (open_.empty()) return 0;
    for (std::size_t f = 0; f < rings_.size(); ++f) {
      ForEachEdgeOf(std::span(&rings_[f], 1), [&](Corner p, Corner q) { Add(p, q, f); });
    }
    std::size_t dropped = 0;
    while (!open_.empty()) {
      const std::size_t f = open_.begin()->second;
      open_.erase(open_.begin());
      if (Drop(f)) ++dropped;
    }
    return dropped;
  }

 private:
  // The corners of a ring along its line; empty if it has an area.
  std::vector<Corner> AlongLine(const CornerRing& ring) const {
    if (ring.size() < 3 || ring.size() > kMostCorners) return {};
    CornerPair ends;
    double longest = -1;
    for (const Corner p : ring) {
      for (const Corner q : ring) {
        const double length2 = geometry::SquaredDistance(positions_[p], positions_[q]);
        if (!(p < q) || length2 < longest) continue;
        if (length2 == longest && ends <= CornerPair(p, q)) continue;
        longest = length2;
        ends = {p, q};
      }
    }
    const Point3 &from = positions_[ends.first], &to = positions_[ends.second];
    const geometry::Vector3 way = geometry::Difference(to.c, from.c);
    for (const Corner c : ring) {
      if (c == ends.first || c == ends.second) continue;
      const double within = within_(c);
      if (within > 0 && geometry::DistanceToLine(positions_[c], from, to) <= within) continue;
      if (!geometry::AreCollinear(from, positions_[c], to)) return {};
    }
    std::vector<std::pair<double, Corner>> along;
    for (const Corner c : ring) {
      along.emplace_back(geometry::Dot(geometry::Difference(positions_[c].c, from.c), way), c);
    }
    std::sort(along.begin(), along.end());
    std::vector<Corner> corners;
    for (const auto& [at, c] : along) corners.push_back(c);
    return corners;
  }

  void Look(std::size_t f) {
    if (!AlongLine(rings_[f]).empty()) open_.emplace(Canonical({rings_[f]}), f);
  }

  // The corners on the line strictly between p and q, from p on.
  static std::vector<Corner> Between(const std::vector<Corner>& along, Corner p, Corner q) {
    const auto at_p = std::find(along.begin(), along.end(), p);
    const auto at_q = std::find(along.begin(), along.end(), q);
    if (at_p < at_q) return {at_p + 1, at_q};
    std::vector<Corner> between(at_q + 1, at_p);
    std::reverse(between.begin(), between.end());
    return between;
  }

  bool Drop(std::size_t f) {
    const CornerRing ring = rings_[f];
    const std::vector<Corner> along = AlongLine(ring);
    if (along.empty()) return false;
    bool good = true;
    ForEachEdgeOf(std::span(&ring, 1), [&](Corner p, Corner q) {
      const std::vector<Corner> between = Between(along, p, q);
      if (between.empty()) return;
      good = good &&
             !std::binary_search(segments_.begin(), segments_.end(), CornerPair(std::minmax(p, q)));
      for (const std::size_t g : uses_[std::minmax(p, q)]) {
        if (g == f) continue;
        good = good && std::none_of(between.begin(), between.end(), [&](Corner c) {
                 return std::find(rings_[g].begin(), rings_[g].end(), c) != rings_[g].end();
               });
      }
    });
    if (!good) return false;
    std::vector<std::size_t> changed;
    ForEachEdgeOf(std::span(&ring, 1), [&](Corner p, Corner q) {
      const std::vector<Corner> between = Between(along, p, q);
      if (between.empty()) return;
      const std::set<std::size_t> uses = uses_[std::minmax(p, q)];
      for (const std::size_t g : uses) {
        if (g == f) continue;
        Insert(g, p, q, between);
        changed.push_back(g);
      }
    });
    ForEachEdgeOf(std::span(&ring, 1), [&](Corner p, Corner q) { Remove(p, q, f); });
    rings_[f].clear();
    for (const std::size_t g : changed) Look(g);
    return true;
  }

  void Insert(std::size_t g, Corner p, Corner q, std::vector<Corner> between) {
    CornerRing& ring = rings_[g];
    open_.erase({Canonical({ring}), g});
    auto at = std::find(ring.begin(), ring.end(), p);
    const bool ahead = ring[static_cast<std::size_t>(at - ring.begin() + 1) % ring.size()] == q;
    if (!ahead) {
      std::reverse(between.begin(), between.end());
      at = std::find(ring.begin(), ring.end(), q);
    }
    ring.insert(at + 1, between.begin(), between.end());
    Remove(p, q, g);
    Corner last = ahead ? p : q;
    for (const Corner c : between) {
      Add(last, c, g);
      last = c;
    }
    Add(last, ahead ? q : p, g);
  }

  void Add(Corner p, Corner q, std::size_t f) { uses_[std::minmax(p, q)].insert(f); }
  void Remove(Corner p, Corner q, std::size_t f) { uses_[std::minmax(p, q)].erase(f); }

  const std::vector<Point3>& positions_;
  const std::function<double(Corner)>& within_;
  const std::vector<CornerPair>& segments_;
  std::vector<CornerRing>& rings_;
  absl::flat_hash_map<CornerPair, std::set<std::size_t>> uses_;
  std::set<std::pair<FaceRings, std::size_t>> open_;  // rings without area
};

}  // namespace

std::size_t DropNeedles(const std::vector<Point3>& positions,
                        const std::function<double(Corner)>& within,
                        const std::vector<CornerPair>& segments, std::vector<CornerRing>& rings) {
  return NeedleDropper(positions, within, segments, rings).Run();
}

}  // namespace dynmesh::coplanar
