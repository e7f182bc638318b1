// The rules by which faces of a surface may be exchanged for others, and what the exchange is
// judged by: the original surface, and what is near.
//
// Each face knows the original faces that it stands for, and these know it: each point of a face is
// near those, and of an original near these. So all distances are to the original surface and do
// not add up.
//
// Decisions are functions of coordinates and numbering. Thread-compatible.
#ifndef DYNMESH_CLIENT_CLEANING_PATCH_RULES_H_
#define DYNMESH_CLIENT_CLEANING_PATCH_RULES_H_

#include <cstdint>
#include <optional>
#include <set>
#include <span>
#include <vector>

#include "client/cleaning/contact_index.h"
#include "client/cleaning/patch_distance.h"
#include "client/cleaning/patch_mesh.h"

namespace dynmesh::cleaning {

struct PatchLimits {
  double angle = 0;      // in degrees, above 0 and below 90
  double within = 0;     // of the original surface, and it of the result; positive
  double tolerance = 0;  // what does not meet is this far apart; positive
};

// Faces that change, and what they become.
struct PatchChange {
  std::vector<std::uint32_t> old;    // ascending: all at a node, or at an edge
  std::vector<std::uint32_t> moved;  // those of `old` that do not go
  std::vector<PatchFace> now;        // what these become
  Node pivot = 0;                    // a corner of all old faces
  std::optional<Node> dropped;
  std::vector<Node> ends;  // of the dropped node's sharp edges, which become one: two, or none

  bool HasOld(std::uint32_t f) const;
};

class PatchRules {
 public:
  // Edges and points without faces are obstacles. The mesh must live as long.
  PatchRules(PatchMesh& mesh, std::span<const ContactElement> obstacles, const PatchLimits& limits);

  // Makes the change, if it keeps all rules. O(k lg k) expected for k originals that its faces
  // stand for.
  bool Try(const PatchChange& change);

  // False if Try would be, as far as the old faces alone say: as long as these do not change, and
  // AllowNarrow is not called. O(1).
  bool MayKeep(const PatchChange& change) const;

  // From now on faces in a plane may have angles down to 10 degrees.
  void AllowNarrow() { allows_narrow_ = true; }

 private:
  using Uses = std::vector<std::vector<std::uint32_t>>;  // by new face: originals

  // Is the dropped node near one of the new faces? Mostly what is too far away is so there.
  bool IsNear(const PatchChange& change) const;
  bool KeepsShape(const PatchChange& change) const;
  bool KeepsEdges(const PatchChange& change) const;
  bool KeepsEdge(NodePair edge, const PatchChange& change, const std::set<NodePair>& old_edges,
                 double narrowest) const;
  bool KeepsChain(const PatchChange& change) const;
  bool HasContacts(const PatchChange& change) const;
  bool KeepsDistance(const PatchChange& change, Uses& uses) const;
  void Apply(const PatchChange& change, Uses uses);

  PatchMesh& mesh_;
  const PatchLimits limits_;
  const DeviationLimit angle_, half_angle_, plane_angle_;
  bool allows_narrow_ = false;
  ContactIndex contacts_;
  std::vector<TriangleCorners> originals_;
  std::vector<std::vector<std::uint32_t>> stands_for_;  // by face: originals, ascending
  std::vector<std::vector<std::uint32_t>> carriers_;    // by original: faces, ascending
};

}  // namespace dynmesh::cleaning

#endif  // DYNMESH_CLIENT_CLEANING_PATCH_RULES_H_
