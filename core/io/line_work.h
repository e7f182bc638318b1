// Points and lines of a map as features: equal coordinates are one point, an edge that
// stands twice is one segment, an edge of no length is none. Thread-compatible.
#ifndef DYNMESH_CORE_IO_LINE_WORK_H_
#define DYNMESH_CORE_IO_LINE_WORK_H_

#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/container/flat_hash_set.h"
#include "core/io/planar_input.h"

namespace dynmesh::io {

class LineWork {
 public:
  // A position, or the one before it again. `line` is where it stands in the file.
  using Place = std::uint32_t;
  Place Add(const std::array<double, 2>& position, int line);
  void Connect(Place from, Place to, int line);

  // Points 1..n in the order in which they were first added, segments n+1..n+m likewise.
  PlanarInput Take(const std::string& file);

 private:
  using Bits = std::pair<std::uint64_t, std::uint64_t>;
  absl::flat_hash_map<Bits, Place> place_at_;
  absl::flat_hash_set<std::pair<Place, Place>> joined_;
  std::vector<std::array<double, 2>> positions_;
  std::vector<int> point_lines_;
  std::vector<std::pair<Place, Place>> edges_;
  std::vector<int> edge_lines_;
};

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_LINE_WORK_H_
