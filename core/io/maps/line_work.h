// Points, lines and polygons of a map as features: equal coordinates are one point, a repeated edge
// is one segment, an edge of length 0 is omitted. Thread-compatible.
#ifndef DYNMESH_CORE_IO_MAPS_LINE_WORK_H_
#define DYNMESH_CORE_IO_MAPS_LINE_WORK_H_

#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/container/flat_hash_set.h"
#include "core/io/common/file_features.h"

namespace dynmesh::io {

class LineWork {
 public:
  // The index of a position, repeated positions included once. `line` is its line in the file.
  using Node = std::uint32_t;
  Node Add(const std::array<double, 2>& position, int line);
  void Connect(Node from, Node to, int line);

  // A polygon of closed chains of positions; the last one is joined to the first. Without a chain
  // none is added. `names` need no id.
  void AddPolygon(std::vector<std::vector<Node>> rings, PolygonName names, int line);

  // Points 1..n in the order of first addition, segments n+1..n+m likewise, then polygons.
  FileFeatures Take(const std::string& file);

 private:
  struct Polygon {
    std::vector<std::vector<Node>> rings;
    PolygonName names;
    int line;
  };
  bool IsAcross(Node from, Node to) const;

  using Bits = std::pair<std::uint64_t, std::uint64_t>;
  absl::flat_hash_map<Bits, Node> node_at_;
  absl::flat_hash_set<std::pair<Node, Node>> joined_;
  std::vector<std::array<double, 2>> positions_;
  std::vector<int> point_lines_;
  std::vector<std::pair<Node, Node>> edges_;
  std::vector<int> edge_lines_;
  std::vector<Polygon> polygons_;
};

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_MAPS_LINE_WORK_H_
