#include "core/coplanar/straight_corners.h"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <optional>

#include "core/coplanar/facet_rings.h"
#include "core/geometry/predicates.h"

namespace dynmesh::coplanar {

using geometry::Point3;

namespace {

class Dropper {
 public:
  Dropper(const std::vector<Point3>& positions, const std::vector<bool>& kept,
          const std::vector<FaceRings>& faces)
      : positions_(positions), kept_(kept), at_(positions.size()) {
    for (const FaceRings& face : faces) {
      for (const CornerRing& ring : face) AddRing(ring);
    }
  }

  void Run() {
    std::vector<Corner> open(positions_.size());
    std::iota(open.begin(), open.end(), Corner{0});
    while (!open.empty()) {
      const Corner c = open.back();
      open.pop_back();
      const std::optional<CornerPair> ends = EndsOf(c);
      if (!ends) continue;
      for (const std::size_t n : at_[c]) {
        nodes_[nodes_[n].before].behind = nodes_[n].behind;
        nodes_[nodes_[n].behind].before = nodes_[n].before;
        nodes_[n].gone = true;
        --sizes_[nodes_[n].ring];
      }
      at_[c].clear();
      open.push_back(ends->first);  // their neighbours have changed
      open.push_back(ends->second);
    }
  }

  void Write(std::vector<FaceRings>& faces) const {
    auto node = nodes_.begin();
    for (FaceRings& face : faces) {
      for (CornerRing& ring : face) {
        std::erase_if(ring, [&](Corner) { return (node++)->gone; });
      }
    }
  }

 private:
  struct Node {
    Corner corner;
    std::size_t before, behind, ring;
    bool gone = false;
  };

  void AddRing(const CornerRing& ring) {
    const std::size_t first = nodes_.size(), n = ring.size();
    for (std::size_t i = 0; i < n; ++i) {
      at_[ring[i]].push_back(nodes_.size());
      nodes_.push_back({ring[i], first + (i + n - 1) % n, first + (i + 1) % n, sizes_.size()});
    }
    sizes_.push_back(n);
  }

  bool IsOnLine(Corner p, Corner c, Corner q) const {
    for (const AxisView view : {AxisView{0, 1}, AxisView{1, 2}, AxisView{2, 0}}) {
      if (geometry::Orientation(view.Of(positions_[p]), view.Of(positions_[c]),
                                view.Of(positions_[q])) != 0) {
        return false;
      }
    }
    return true;
  }

  // The two corners around c, if c is not needed between them.
  std::optional<CornerPair> EndsOf(Corner c) const {
    if (kept_[c] || at_[c].empty()) return std::nullopt;
    std::optional<CornerPair> ends;
    for (const std::size_t n : at_[c]) {
      const Node& node = nodes_[n];
      if (sizes_[node.ring] <= 3) return std::nullopt;
      const CornerPair pair = std::minmax(nodes_[node.before].corner, nodes_[node.behind].corner);
      if (ends && *ends != pair) return std::nullopt;
      ends = pair;
    }
    // On a line the lexicographic order is that along it.
    const auto [p, q] = *ends;
    if (!(positions_[p] < positions_[c] && positions_[c] < positions_[q]) || !IsOnLine(p, c, q)) {
      return std::nullopt;
    }
    return ends;
  }

  const std::vector<Point3>& positions_;
  const std::vector<bool>& kept_;
  std::vector<Node> nodes_;                   // ring by ring
  std::vector<std::size_t> sizes_;            // of rings
  std::vector<std::vector<std::size_t>> at_;  // nodes, by corner
};

}  // namespace

void DropStraightCorners(const std::vector<Point3>& positions, const std::vector<bool>& kept,
                         std::vector<FaceRings>& faces) {
  Dropper dropper(positions, kept, faces);
  dropper.Run();
  dropper.Write(faces);
}

}  // namespace dynmesh::coplanar
