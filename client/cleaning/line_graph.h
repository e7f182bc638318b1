// The input during cleaning: nodes, which are positions of points, and edges between them.
//
// All numbering is by coordinates (nodes in order of insertion, in each round by coordinates;
// edges by their ends). So results of iterations in this order do not depend on the input's order.
// Thread-compatible.
#ifndef DYNMESH_CLIENT_CLEANING_LINE_GRAPH_H_
#define DYNMESH_CLIENT_CLEANING_LINE_GRAPH_H_

#include <cstdint>
#include <utility>
#include <vector>

#include "absl/container/inlined_vector.h"
#include "client/cleaning/clean_input.h"
#include "client/cleaning/node_table.h"

namespace dynmesh::cleaning {

// Ascending. Usually few: on a map an edge borders two polygons.
using EdgePolygons = absl::InlinedVector<FeatureId, 2>;

struct Edge {
  Node a = 0;  // a < b
  Node b = 0;
  FeatureId owner = kNoFeature;  // the input segment that contains it, the least id
  int born = 0;                  // its intersections are unchecked since this round
  EdgePolygons polygons;         // that contain it an odd number of times

  // For reports: the segment, else the least polygon.
  FeatureId name() const { return owner != kNoFeature ? owner : polygons.front(); }
  bool IsDead() const { return owner == kNoFeature && polygons.empty(); }
};

class LineGraph {
 public:
  explicit LineGraph(double tolerance) : nodes(tolerance) {}

  // A node made in this round, for a point with id `id`.
  Node AddNode(const Point& p, FeatureId id);
  // The node nearest to p within the tolerance.
  std::optional<Node> Near(const Point& p) const { return nodes.Near(p); }

  // Adds an edge, in any order, unless both ends are equal.
  void Connect(Node a, Node b, FeatureId owner, const EdgePolygons& polygons = {});
  // To be called after edges were added or marked dead: sorts, removes dead and duplicate edges.
  void Settle();

  void Kill(std::size_t edge) {
    edges[edge].owner = kNoFeature;
    edges[edge].polygons.clear();
  }

  // The ends in lexicographic order of their coordinates.
  std::pair<Node, Node> Ordered(const Edge& e) const;
  // A strict order of all pairs of nodes by distance; ties by coordinates.
  bool IsShorter(Node a, Node b, const Edge& than) const;

  NodeTable nodes;
  std::vector<FeatureId> point_ids;  // by node
  std::vector<int> node_born;        // by node: the round
  std::vector<Edge> edges;
  std::vector<Change> changes;
  int round = 0;

 private:
  void Lay(const Edge& e, Edge& on);
};

}  // namespace dynmesh::cleaning

#endif  // DYNMESH_CLIENT_CLEANING_LINE_GRAPH_H_
