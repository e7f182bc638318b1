// The input while it is being cleaned: places, and edges between them.
//
// Everything is numbered by coordinates (places as they were added, in each round by
// coordinates; edges by their ends), so that whoever goes through it in order does what does
// not depend on the input's order. Thread-compatible.
#ifndef DYNMESH_CLIENT_CLEANING_LINE_GRAPH_H_
#define DYNMESH_CLIENT_CLEANING_LINE_GRAPH_H_

#include <cstdint>
#include <utility>
#include <vector>

#include "absl/container/inlined_vector.h"
#include "client/cleaning/clean_input.h"
#include "client/cleaning/point_places.h"

namespace dynmesh::cleaning {

// Ascending. Few: on a map an edge is the border of two.
using EdgePolygons = absl::InlinedVector<FeatureId, 2>;

struct Edge {
  Place a = 0;  // a < b
  Place b = 0;
  FeatureId owner = kNoFeature;  // the input's segment that it is a piece of; of several the least
  int born = 0;                  // the round since which it may have meetings nobody has seen
  EdgePolygons polygons;         // of which it is a piece of an odd number of edges

  // For reports: the segment, or else the least polygon.
  FeatureId name() const { return owner != kNoFeature ? owner : polygons.front(); }
  bool IsDead() const { return owner == kNoFeature && polygons.empty(); }
};

class LineGraph {
 public:
  explicit LineGraph(double tolerance) : places(tolerance) {}

  // A place made in this round, for a point with that id.
  Place AddPlace(const Point& p, FeatureId id);

  // Adds an edge, in any order, unless both ends are one.
  void Connect(Place a, Place b, FeatureId owner, const EdgePolygons& polygons = {});
  // After edges were added and marked dead: sorted again, none dead, none doubled.
  void Settle();

  void Kill(std::size_t edge) {
    edges[edge].owner = kNoFeature;
    edges[edge].polygons.clear();
  }

  // The ends in the order of their coordinates.
  std::pair<Place, Place> Ordered(const Edge& e) const;
  // A strict order of all pairs of places by their distance; ties by coordinates.
  bool IsShorter(Place a, Place b, const Edge& than) const;

  PointPlaces places;
  std::vector<FeatureId> point_ids;  // by place
  std::vector<int> place_born;       // by place: the round
  std::vector<Edge> edges;
  std::vector<Change> changes;
  int round = 0;

 private:
  void Lay(const Edge& e, Edge& on);
};

}  // namespace dynmesh::cleaning

#endif  // DYNMESH_CLIENT_CLEANING_LINE_GRAPH_H_
