// One round of cleaning a surface: finds all faults of one kind and repairs them.
//
// Each contact becomes a node: an existing one if it is within the tolerance, else a new one. An
// edge with nodes on it becomes the chain through them, for all simplices that have it. So what was
// closed stays closed. A face with nodes on its edges or over its inside becomes a triangulation of
// these. Where two faces cross, both get the edge between the nodes; where three do, their common
// node comes at once.
//
// Rounds mostly end: a new node has all others farther away than the tolerance, and what remains
// after the first two are places where rounding moved a face over a node, or nodes a few tolerances
// apart. There repairs of two edges may undo each other, for ever: CleanSurfaces then takes a
// larger tolerance.
//
// If the surface may be contracted, rounds make fewer nodes of needles, which are long, so that
// many of their edges meet at nearly no angle, each time elsewhere. Edges wait with crossings until
// they go through all nodes on them. From the second round on, a face with a corner on its opposite
// edge loses the shorter one of its other edges, and with it the corner, if that is short enough.
//
// All decisions are functions of coordinates.
#ifndef DYNMESH_CLIENT_CLEANING_SURFACE_ROUND_H_
#define DYNMESH_CLIENT_CLEANING_SURFACE_ROUND_H_

#include <cstddef>
#include <cstdint>
#include <set>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/status/statusor.h"
#include "client/cleaning/surface.h"
#include "client/cleaning/surface_contacts.h"

namespace dynmesh::cleaning {

class SurfaceRounds {
 public:
  // The surface must be settled. `max_crossings` is per round. `effort` must outlive this.
  SurfaceRounds(Surface& surface, std::size_t max_crossings, Effort& effort)
      : surface_(surface), max_crossings_(max_crossings), effort_(effort) {}

  // False if there was nothing left to do. RESOURCE_EXHAUSTED above max_crossings, if no fault that
  // was found can be repaired, or if the effort is spent.
  absl::StatusOr<bool> Run();

  // Number of faults found by the last round, and the position of one.
  std::size_t found() const { return found_; }
  const Point3& where() const { return where_; }
  // Those of all.
  const std::vector<StuckPlace>& places() const { return places_; }

 private:
  struct EdgeNode {
    NodePair edge;
    Node at = 0;
    SurfaceChangeKind kind = SurfaceChangeKind::kEdgeSplit;
  };
  // What one face gets in this round.
  struct FaceWork {
    std::vector<Node> nodes;
    std::vector<NodePair> lines;  // between nodes of the face
  };

  void Postpone(Contacts& contacts);
  void Take(const std::vector<ThinFace>& thin);
  bool TakeContraction(const ThinFace& thin);
  void Take(std::vector<Contact>& contacts);
  void TakePart(std::uint32_t simplex, int part, Node at, SurfaceChangeKind kind);
  void Report(const Contact& contact);
  void TakeLines(const Contact* begin, const Contact* end);
  void PutOnEdge(NodePair edge, Node at, SurfaceChangeKind kind);
  void PutInFace(std::uint32_t face, Node at);
  absl::Status SpentError() const;
  void JoinLines();
  void MakeChains();
  bool Apply();
  bool ApplyTo(std::uint32_t simplex);
  std::vector<std::array<Node, 3>> PiecesOf(const Simplex& face, const FaceWork& work) const;
  FeatureId NameOf(NodePair edge) const;
  Point3 NormalOf(const Simplex& face) const;
  void SortAlong(std::vector<Node>& nodes, const Point3& direction) const;

  Surface& surface_;
  const std::size_t max_crossings_;
  Effort& effort_;
  int seen_ = 0;  // all contacts of simplices born before this round are repaired
  std::size_t found_ = 0;
  Point3 where_{};
  std::vector<StuckPlace> places_;
  // Of this round.
  Surface::EdgeMap edges_;
  std::vector<EdgeNode> edge_nodes_;
  absl::flat_hash_map<NodePair, std::vector<Node>> chains_;  // inner nodes, from the first end
  absl::flat_hash_map<std::uint32_t, FaceWork> faces_;
  std::vector<std::uint32_t> concerned_;
  std::vector<NodePair> contractions_;
  std::set<std::pair<SurfaceChangeKind, std::vector<FeatureId>>> told_;
};

}  // namespace dynmesh::cleaning

#endif  // DYNMESH_CLIENT_CLEANING_SURFACE_ROUND_H_
