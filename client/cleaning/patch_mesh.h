// A surface whose triangles change: faces by their corners, and the edges that stay sharp.
//
// Nodes are numbered in the order of coordinates, faces have ascending corners and are numbered by
// them. So all that depends on numbers here is a function of coordinates, and what is computed from
// a face does not depend on its orientation. Thread-compatible. Expected O(1) per operation and
// face at a node.
#ifndef DYNMESH_CLIENT_CLEANING_PATCH_MESH_H_
#define DYNMESH_CLIENT_CLEANING_PATCH_MESH_H_

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <span>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/container/inlined_vector.h"
#include "client/cleaning/node_table.h"
#include "client/cleaning/patch_distance.h"
#include "client/cleaning/surface.h"
#include "client/cleaning/vectors3.h"
#include "dynmesh/feature.h"

namespace dynmesh::cleaning {

// Directions may deviate by this angle, in degrees: above 0, below 90.
class DeviationLimit {
 public:
  explicit DeviationLimit(double degrees) : tangent_(std::tan(degrees * std::numbers::pi / 180)) {}
  // Of vectors of length 1.
  bool IsKept(const Point3& a, const Point3& b) const {
    const Point3 cross = Cross(a, b);
    const double cosine = Dot(a, b);
    return cosine > 0 && std::sqrt(Dot(cross, cross)) <= tangent_ * cosine;
  }

 private:
  double tangent_;
};

struct PatchFace {
  std::array<Node, 3> v{};  // ascending
  bool is_flipped = false;  // its orientation is v[0], v[2], v[1]
  bool is_alive = true;
  bool is_changed = false;
  std::uint32_t group = 0;  // edges between groups are sharp
  FeatureId source = kNoFeature;

  bool Has(Node n) const { return v[0] == n || v[1] == n || v[2] == n; }
  // The third corner. REQUIRES: it has a and b.
  Node ApexOf(Node a, Node b) const {
    return v[0] != a && v[0] != b ? v[0] : v[1] != a && v[1] != b ? v[1] : v[2];
  }
  // Has it the orientation of these, its corners?
  bool IsOriented(Node a, Node b, Node c) const { return IsEven({a, b, c}) != is_flipped; }
  void Orient(Node a, Node b, Node c);
  // Has n instead of `old`, and keeps its orientation.
  void Replace(Node old, Node n);
};

// Calls visit(edge, third corner) for the edges of a face.
template <class Visitor>
void VisitEdges(const PatchFace& face, Visitor visit) {
  for (std::size_t i = 0; i < 3; ++i) {
    visit(Ordered(face.v[i], face.v[(i + 1) % 3]), face.v[(i + 2) % 3]);
  }
}

using FaceIndices = absl::InlinedVector<std::uint32_t, 8>;
using Nodes = absl::InlinedVector<Node, 8>;

class PatchMesh {
 public:
  // Faces in ascending order of corners, without repetition. Edges of `kept` are sharp, and their
  // ends corners, as all edges that do not have two faces of one group with normals within the
  // limit. Corners are nodes without faces; with one sharp edge, with three or more; with two that
  // turn by more than the limit; and where faces meet in the node only.
  PatchMesh(std::vector<Point3> points, std::vector<PatchFace> faces,
            const std::vector<NodePair>& kept, const DeviationLimit& limit);

  const std::vector<Point3>& points() const { return points_; }
  const Point3& at(Node v) const { return points_[v]; }
  std::size_t node_count() const { return points_.size(); }
  const std::vector<PatchFace>& faces() const { return faces_; }
  const FaceIndices& FacesAt(Node v) const { return faces_at_[v]; }
  bool IsCorner(Node v) const { return is_corner_[v]; }
  bool IsSharp(Node a, Node b) const { return sharp_.contains(Ordered(a, b)); }
  std::size_t sharp_count() const { return sharp_.size(); }
  // The nodes that a sharp edge went through before.
  const std::vector<Node>& HiddenIn(Node a, Node b) const { return sharp_.at(Ordered(a, b)); }

  TriangleCorners CornersOf(const std::array<Node, 3>& v) const {
    return {points_[v[0]], points_[v[1]], points_[v[2]]};
  }
  // Of length 1, of the face with these corners, the edge counter-clockwise.
  Point3 NormalBeside(NodePair edge, Node apex) const {
    return UnitOf(NormalOf(at(edge.first), at(edge.second), at(apex)));
  }
  // Ascending.
  Nodes NeighboursOf(Node v) const;
  Nodes SharpNeighboursOf(Node v) const;
  // The third corners of the faces at an edge.
  Nodes ApexesOf(Node a, Node b) const;

  // The boundaries of what is left when v's faces go, v no corner: a closed chain of nodes; at two
  // sharp edges one for each part between these, from the lesser end to the other one. The
  // direction of the former is to the lesser neighbour of its first and least node.
  std::vector<Nodes> HolesAt(Node v) const;

  // Faces `old` go, but for those of `moved`, which become `now`.
  void Exchange(std::span<const std::uint32_t> old, std::span<const std::uint32_t> moved,
                std::span<const PatchFace> now);
  // Sharp edges between v and a and between v and b become one between a and b.
  void JoinSharp(Node v, Node a, Node b);

 private:
  void FindSharp(const std::vector<NodePair>& kept, const DeviationLimit& limit);
  // Do the faces at v make one disc, or half-discs between both sharp edges?
  bool IsRegular(Node v, const Nodes& sharp) const;
  // From face to face around v, from its edge to `first` and that face on, until it is there again
  // or at a sharp edge: the other ends of the edges passed. The last one is again the first or that
  // of a sharp edge.
  Nodes Walk(Node v, Node first, std::uint32_t face) const;

  std::vector<Point3> points_;
  std::vector<PatchFace> faces_;
  std::vector<FaceIndices> faces_at_;  // by node
  std::vector<bool> is_corner_;
  absl::flat_hash_map<NodePair, std::vector<Node>> sharp_;
};

}  // namespace dynmesh::cleaning

#endif  // DYNMESH_CLIENT_CLEANING_PATCH_MESH_H_
