// A 2D mesh that changes, as an animated SVG (SMIL, which browsers play in an <img>, too). What an
// edit adds is orange in its frame. A triangle is written once, with the frames in which it shows,
// so the file grows with what edits change.
#ifndef DYNMESH_CORE_IO_PICTURES_MESH_ANIMATION_H_
#define DYNMESH_CORE_IO_PICTURES_MESH_ANIMATION_H_

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/status/status.h"
#include "dynmesh/mesh.h"
#include "dynmesh/options.h"

namespace dynmesh::io {

struct AnimationOptions {
  Box crop;              // what is shown
  double width = 1000;   // pixels; the height follows
  double seconds = 0.2;  // of a frame
};

// Thread-compatible. REQUIRES: dimension 2; each diff continues the one before.
class MeshAnimation {
 public:
  // The next revision. Until Begin all are part of the first frame. O(diff) expected.
  void Add(const MeshDiff& diff);
  // The mesh so far is the first frame: each further diff is a frame.
  void Begin() { has_begun_ = true; }
  int frames() const { return frame_ + 1; }
  // The box of all vertices so far. O(n).
  Box Extent() const;

  // Ends where it began, and repeats. UNAVAILABLE, naming the path, if it cannot be written.
  absl::Status Write(const AnimationOptions& options, const std::string& path) const;

 private:
  // The frames in which rows of K vertices show: from the first on, before the second.
  using Frames = std::pair<int, int>;
  template <std::size_t K>
  struct Rows {
    absl::flat_hash_map<std::array<VertexId, K>, int> present;  // since which frame
    std::map<Frames, std::vector<std::array<VertexId, K>>> gone;
    void Remove(const std::array<VertexId, K>& row, int frame);
    // All rows that ever showed, those present to the end, in the order of their ids.
    std::map<Frames, std::vector<std::array<VertexId, K>>> All(int frames) const;
  };

  absl::flat_hash_map<VertexId, std::array<double, 2>> positions_;  // of all vertices ever
  Rows<3> triangles_;
  Rows<2> segments_;  // of features, without the box
  bool has_begun_ = false;
  int frame_ = 0;
};

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_PICTURES_MESH_ANIMATION_H_
