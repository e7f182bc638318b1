// Collects points, segments and faces of a 3D file into features: the common part of all readers.
// Points become 1..n; segments follow, then polygons. Thread-compatible. A face costs O(corners lg
// corners).
#ifndef DYNMESH_CORE_IO_SPACE_SURFACE_WORK_H_
#define DYNMESH_CORE_IO_SPACE_SURFACE_WORK_H_

#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/container/flat_hash_set.h"
#include "absl/status/status.h"
#include "core/io/common/file_features.h"
#include "core/io/common/written_digits.h"
#include "core/io/space/face_rules.h"

namespace dynmesh::io {

class SurfaceWork {
 public:
  using Vertex = std::uint32_t;  // from 0
  using Ring = std::vector<Vertex>;

  // `file` contains the faces; its first vertex has the number `first_number` in messages.
  SurfaceWork(std::string file, std::uint64_t first_number, FaceRules rules = FaceRules::kStrict)
      : file_(std::move(file)), first_number_(first_number), rules_(rules) {}

  Vertex AddPoint(const std::array<double, 3>& position, int line);
  // Starts with points that were read already, from this or another file, and their data.
  void StartFrom(FileFeatures points) { input_ = std::move(points); }
  std::size_t point_count() const { return input_.features.size(); }
  const std::array<double, 3>& position(Vertex v) const { return input_.features[v].position; }

  // Collects the digits of the points' coordinates.
  WrittenDigits& digits() { return digits_; }

  // A repeated segment is added once, with its first marker. Equal ends are an error.
  absl::Status AddSegment(Vertex p, Vertex q, int line, std::uint64_t marker = 0);

  // A polygon of rings, which may touch in corners. Errors: a ring of fewer than three corners or
  // with a repeated corner, a repeated edge, and a second face with the same corners.
  // With FaceRules::kMended a triangle may have a corner twice, a polygon one after the other, and
  // faces may have the same corners. With FaceRules::kAsTheyCome nothing is an error, and rings
  // without corners are left out.
  absl::Status AddFace(std::vector<Ring> rings, int line, std::uint64_t marker = 0);

  FileFeatures Take();

 private:
  absl::Status Error(int line, const std::string& message) const;
  std::string Name(Vertex v) const;
  absl::Status CheckRing(const Ring& ring, int line) const;
  absl::Status CheckEdges(const std::vector<Ring>& rings, int line) const;

  struct Segment {
    Vertex p, q;
    int line;
    std::uint64_t marker;
  };
  struct Face {
    std::vector<Ring> rings;
    int line;
    std::uint64_t marker;
  };
  std::string file_;
  std::uint64_t first_number_;
  FaceRules rules_;
  FileFeatures input_;  // points only
  WrittenDigits digits_;
  std::vector<Segment> segments_;
  std::vector<Face> faces_;
  absl::flat_hash_set<std::pair<Vertex, Vertex>> joined_;
  absl::flat_hash_map<Ring, int> line_of_;  // by all corners of a face, sorted
};

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_SPACE_SURFACE_WORK_H_
