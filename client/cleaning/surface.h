// A surface during cleaning: nodes, which are positions of points, and the triangles, edges of
// segments and single points that have them as corners.
//
// All numbering is by coordinates (nodes in order of insertion, in each round by coordinates; the
// others by their corners). So results of iterations in this order do not depend on the input's
// order. They may depend on the round in which a node was made: what decides whether there is a
// fault must be a function of coordinates alone, or a result that is cleaned again has new faults.
// Thread-compatible.
#ifndef DYNMESH_CLIENT_CLEANING_SURFACE_H_
#define DYNMESH_CLIENT_CLEANING_SURFACE_H_

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/container/inlined_vector.h"
#include "client/cleaning/clean_surfaces.h"
#include "client/cleaning/node_table.h"
#include "client/cleaning/tolerance_field.h"

namespace dynmesh::cleaning {

inline NodePair Ordered(Node a, Node b) { return a < b ? NodePair(a, b) : NodePair(b, a); }

// From the least corner on, does the lesser of the others come first? REQUIRES: they differ.
inline bool IsEven(std::array<Node, 3> v) {
  std::rotate(v.begin(), std::min_element(v.begin(), v.end()), v.end());
  return v[1] < v[2];
}

// The input's faces, or segments, that contain it an odd number of times; ascending.
using Sources = absl::InlinedVector<FeatureId, 1>;

// A triangle, a segment's edge, or a point: of 3, 2 or 1 corners.
struct Simplex {
  std::array<Node, 3> v{};  // the first `size`; in a triangle oriented as in the input
  int size = 0;
  int born = 0;  // what it meets is unchecked since this round
  Sources sources;

  // Ascending corners.
  std::array<Node, 3> Key() const;
  bool Has(Node n) const;
  int edge_count() const { return size == 3 ? 3 : size - 1; }
  // Edge i, of which a triangle has three, an edge one.
  NodePair Edge(int i) const { return Ordered(v[i], v[(i + 1) % 3 == size ? 0 : (i + 1) % 3]); }
};

class Surface {
 public:
  // The field must live as long, and not change.
  explicit Surface(const ToleranceField& tolerances)
      : nodes(tolerances.least(), tolerances.most_level()), field(tolerances) {}

  // A node made in this round, for a point with id `id`.
  Node AddNode(const Point3& p, FeatureId id);
  // The node nearest to p within the tolerance there, or what it was joined with.
  std::optional<Node> Near(const Point3& p) const {
    const std::optional<Node> near = nodes.Near(p, field.LevelAt(p));
    if (!near) return near;
    const auto it = joined.find(*near);
    return it == joined.end() ? near : it->second;
  }
  // Or a new one.
  Node NodeAt(const Point3& p);

  // Joins the nodes of each pair: the first by coordinates stays. To be settled.
  void Join(const std::vector<NodePair>& pairs);

  // Adds a simplex, unless corners are equal. To be settled.
  void Add(std::span<const Node> corners, const Sources& sources);
  // To be called after simplices were added or their sources cleared: sorts, joins equal ones,
  // removes those without sources.
  void Settle();

  // The simplices, by corners, that have an edge of two corners or more at each pair of nodes.
  using EdgeMap = absl::flat_hash_map<NodePair, std::vector<std::uint32_t>>;
  EdgeMap EdgesOf() const;

  // A strict order of all pairs of nodes by length; ties by coordinates.
  bool IsShorter(NodePair a, NodePair b) const;
  // A face's corners, by their coordinates alone. The first one is opposite to the longest edge:
  // the normal of a thin face rounds least from there.
  std::array<Node, 3> CornersOf(const Simplex& face) const;
  const Point3& at(Node v) const { return nodes.at(v); }

  // The greatest tolerance at a corner.
  double ToleranceOf(const Simplex& s) const;

  NodeTable3 nodes;
  const ToleranceField& field;
  double least_sine = 0;        // what meets at a common corner at a lesser angle is to become one
  double most_contraction = 0;  // SurfaceCleanOptions
  absl::flat_hash_map<Node, Node> joined;  // what no simplex has any more, with what stayed
  std::vector<FeatureId> point_ids;        // by node
  FeatureId next_id = 0;                   // of the next new node
  std::vector<Simplex> simplices;          // by corners, points first
  std::vector<SurfaceChange> changes;
  int round = 0;
};

}  // namespace dynmesh::cleaning

#endif  // DYNMESH_CLIENT_CLEANING_SURFACE_H_
