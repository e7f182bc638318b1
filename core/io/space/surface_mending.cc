#include "core/io/space/surface_mending.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/container/flat_hash_set.h"
#include "core/base/feature_kinds.h"
#include "core/base/ring_walk.h"
#include "core/coplanar/needles.h"
#include "core/geometry/point.h"

namespace dynmesh::io {

namespace {

class Mender {
  using Corner = coplanar::Corner;
  using CornerPair = coplanar::CornerPair;
  using CornerRing = coplanar::CornerRing;
  using Point3 = geometry::Point3;

 public:
  Mender(double distance, FileFeatures& file) : distance_(distance), file_(file) {
    for (std::size_t i = 0; i < file.features.size(); ++i) {
      Feature& f = file.features[i];
      if (!IsPoint(f)) continue;
      for (double& x : f.position) x += 0.0;  // -0 is 0
      points_.push_back(i);
    }
    std::stable_sort(points_.begin(), points_.end(), [&](std::size_t a, std::size_t b) {
      const Feature &p = file.features[a], &q = file.features[b];
      return std::tie(p.position, p.id) < std::tie(q.position, q.id);
    });
    for (const std::size_t i : points_) {
      const Feature& f = file.features[i];
      if (positions_.empty() || positions_.back().c != f.position) {
        positions_.push_back({f.position});
        ids_.push_back(f.id);
      } else {
        ++mends_.equal_points;
      }
      corner_.emplace(f.id, static_cast<Corner>(positions_.size() - 1));
    }
  }

  SurfaceMends Run() {
    ReadFaces();
    JoinNearPoints();
    std::vector<std::size_t> sources;
    std::vector<CornerRing> rings = SplitFaces(sources);
    const std::vector<CornerPair> segments = Segments();
    DropTwice(rings);
    const std::size_t needles = coplanar::DropNeedles(
        positions_, [](Corner) { return 0.0; }, segments, rings);
    mends_.faces_without_area += needles;
    if (needles > 0) DropTwice(rings);  // what got corners
    Write(rings, sources);
    return mends_;
  }

 private:
  void ReadFaces() {
    uses_.assign(positions_.size(), 0);
    for (std::size_t i = 0; i < file_.features.size(); ++i) {
      const Feature& f = file_.features[i];
      if (!Is<APolygon>(f, Not<APoint, ASegment, ASize>)) continue;
      CornerRing& ring = faces_.emplace_back();
      for (const FeatureId id : f.rings.front()) {
        ring.push_back(corner_.at(id));
        ++uses_[ring.back()];
      }
      polygons_.push_back(i);
    }
  }

  // ---- near points: cells that are much larger than the distance, and whose sides avoid round
  // numbers, so that few points need a look at more than one
  static constexpr double kCell = 64, kShift = 0.37;
  using Cell = std::array<std::int64_t, 3>;

  Corner RootOf(Corner c) {
    while (root_[c] != c) c = root_[c] = root_[root_[c]];
    return c;
  }

  void JoinNearPoints() {
    root_.resize(positions_.size());
    for (Corner c = 0; c < root_.size(); ++c) root_[c] = c;
    if (!(distance_ > 0)) return;
    absl::flat_hash_map<Cell, std::vector<Corner>> cells;
    for (Corner c = 0; c < positions_.size(); ++c) {
      std::array<std::array<std::int64_t, 2>, 3> range{};
      for (int k = 0; k < 3; ++k) {
        const double at = positions_[c][k] / (kCell * distance_) + kShift;
        // Beyond, neighbouring doubles are farther apart.
        if (!(std::abs(at) < 0x1p52)) break;
        range[static_cast<std::size_t>(k)] = {
            static_cast<std::int64_t>(std::floor(at - 1 / kCell)),
            static_cast<std::int64_t>(std::floor(at + 1 / kCell))};
      }
      for (std::int64_t x = range[0][0]; x <= range[0][1]; ++x) {
        for (std::int64_t y = range[1][0]; y <= range[1][1]; ++y) {
          for (std::int64_t z = range[2][0]; z <= range[2][1]; ++z) {
            std::vector<Corner>& others = cells[{x, y, z}];
            for (const Corner other : others) JoinIfNear(other, c);
            others.push_back(c);
          }
        }
      }
    }
    // The place of most faces.
    std::vector<Corner> best(root_.size());
    for (Corner c = 0; c < root_.size(); ++c) best[c] = c;
    for (Corner c = 0; c < root_.size(); ++c) {
      Corner& of = best[RootOf(c)];
      if (uses_[c] > uses_[of] || (uses_[c] == uses_[of] && c < of)) of = c;
    }
    std::vector<Corner> to(root_.size());
    for (Corner c = 0; c < root_.size(); ++c) {
      to[c] = best[RootOf(c)];
      if (to[c] != c) ++mends_.near_points;
    }
    for (Corner c = 0; c < to.size(); ++c) ids_[to[c]] = std::min(ids_[to[c]], ids_[c]);
    root_ = std::move(to);
  }

  void JoinIfNear(Corner p, Corner q) {
    if (geometry::SquaredDistance(positions_[p], positions_[q]) >= distance_ * distance_) return;
    p = RootOf(p);
    q = RootOf(q);
    root_[std::max(p, q)] = std::min(p, q);
  }

  // ---- faces

  // REQUIRES: no two neighbours are the same.
  static bool VisitsNoCornerTwice(const CornerRing& ring) {
    if (ring.size() == 3) return true;
    CornerRing sorted = ring;
    std::sort(sorted.begin(), sorted.end());
    return std::adjacent_find(sorted.begin(), sorted.end()) == sorted.end();
  }

  // Each as rings that visit no corner twice.
  std::vector<CornerRing> SplitFaces(std::vector<std::size_t>& sources) {
    std::vector<CornerRing> rings;
    for (std::size_t f = 0; f < faces_.size(); ++f) {
      CornerRing ring;
      for (const Corner c : faces_[f]) {
        const Corner to = root_[c];
        if (ring.empty() || ring.back() != to) ring.push_back(to);
      }
      while (ring.size() > 1 && ring.back() == ring.front()) ring.pop_back();
      const bool is_whole = ring.size() == faces_[f].size() && VisitsNoCornerTwice(ring);
      std::vector<CornerRing> parts;
      if (is_whole) {  // it keeps its first corner and its direction
        parts.push_back(std::move(ring));
      } else if (ring.size() > 2) {
        // From the least corner to its lesser neighbour, so that cuts do not depend on the start.
        ring = coplanar::Canonical({std::move(ring)}).front();
        ring.push_back(ring.front());
        std::size_t at = 0;
        WalkRings(
            ring.front(),
            [&](Corner) -> std::optional<Corner> {
              if (++at == ring.size()) return std::nullopt;
              return ring[at];
            },
            parts);
        std::erase_if(parts, [](const CornerRing& part) { return part.size() < 3; });
      }
      if (parts.empty()) ++mends_.faces_without_area;
      for (CornerRing& part : parts) {
        rings.push_back(std::move(part));
        sources.push_back(f);
      }
    }
    return rings;
  }

  void DropTwice(std::vector<CornerRing>& rings) {
    absl::flat_hash_set<CornerRing> known;
    for (CornerRing& ring : rings) {
      if (ring.empty()) continue;
      if (known.insert(coplanar::Canonical({ring}).front()).second) continue;
      ring.clear();
      ++mends_.faces_twice;
    }
  }

  CornerPair EndsOf(const Feature& segment) const {
    return std::minmax(root_[corner_.at(segment.ends[0])], root_[corner_.at(segment.ends[1])]);
  }

  std::vector<CornerPair> Segments() const {
    std::vector<CornerPair> segments;
    for (const Feature& f : file_.features) {
      if (Is<ASegment>(f, Not<APoint, APolygon, ASize>)) segments.push_back(EndsOf(f));
    }
    std::sort(segments.begin(), segments.end());
    return segments;
  }

  // By what is left.
  std::vector<bool> Named(const std::vector<CornerRing>& rings) const {
    std::vector<bool> named(positions_.size(), false);
    for (const CornerRing& ring : rings) {
      for (const Corner c : ring) named[c] = true;
    }
    for (const CornerPair& ends : Segments()) named[ends.first] = named[ends.second] = true;
    return named;
  }

  void Write(const std::vector<CornerRing>& rings, const std::vector<std::size_t>& sources) {
    const std::vector<bool> named = Named(rings);
    std::vector<bool> was_named(positions_.size(), false);
    for (Corner c = 0; c < root_.size(); ++c) {
      if (uses_[c] != 0) was_named[root_[c]] = true;
    }
    std::vector<Feature> features;
    std::set<CornerPair> joined;
    for (Feature& f : file_.features) {
      if (Is<APolygon, ASize>(f, Not<APoint, ASegment>)) continue;
      if (IsPoint(f)) {
        const Corner c = root_[corner_.at(f.id)];
        if (ids_[c] != f.id || (was_named[c] && !named[c])) continue;
        f.position = positions_[c].c;
        features.push_back(std::move(f));
      } else {
        const CornerPair ends = EndsOf(f);
        if (ends.first == ends.second || !joined.insert(ends).second) continue;
        for (FeatureId& end : f.ends) end = ids_[root_[corner_.at(end)]];
        features.push_back(std::move(f));
      }
    }
    std::size_t last = std::numeric_limits<std::size_t>::max();
    for (std::size_t i = 0; i < rings.size(); ++i) {
      if (rings[i].empty()) continue;
      const FeatureId source = file_.features[polygons_[sources[i]]].id;
      FeatureId id = source;
      if (sources[i] == last) {
        file_.lines.push_back(file_.lines[source - 1]);
        id = file_.lines.size();
      }
      last = sources[i];
      std::vector<FeatureId> ring;
      for (const Corner c : rings[i]) ring.push_back(ids_[c]);
      features.push_back(Feature::Polygon(id, {std::move(ring)}));
    }
    file_.features = std::move(features);
  }

  const double distance_;
  FileFeatures& file_;
  SurfaceMends mends_;
  std::vector<std::size_t> points_;  // in the order of coordinates, then ids
  std::vector<Point3> positions_;    // no two equal ones
  std::vector<FeatureId> ids_;       // of positions
  absl::flat_hash_map<FeatureId, Corner> corner_;
  std::vector<std::size_t> uses_;  // of positions by faces
  std::vector<Corner> root_;       // of positions: the one that it is made one with
  std::vector<CornerRing> faces_;
  std::vector<std::size_t> polygons_;  // of faces: indices of features
};

}  // namespace

SurfaceMends MendSurface(double distance, FileFeatures& file) {
  return Mender(distance, file).Run();
}

}  // namespace dynmesh::io
