// Makes the nearly flat patches of a surface coarse: points are dropped, one after the other, as
// long as all rules are kept. Corners and sharp edges stay.
//
// The hole that a point leaves gets the triangulation with the largest least angle; if that breaks
// a rule, one of those from a single neighbour, which are edge collapses. First comes what makes
// the smallest circumscribed circles. Then edges around the hole are flipped where that makes the
// least angle of both faces larger.
//
// The result is a function of coordinates. Thread-compatible. Expected O(n lg n) for n faces, if
// patches shrink by a bounded factor as edges get longer.
#ifndef DYNMESH_CLIENT_CLEANING_COLLAPSES_H_
#define DYNMESH_CLIENT_CLEANING_COLLAPSES_H_

#include <compare>
#include <functional>
#include <optional>
#include <queue>
#include <set>
#include <vector>

#include "client/cleaning/patch_mesh.h"
#include "client/cleaning/patch_rules.h"

namespace dynmesh::cleaning {

class Collapses {
 public:
  // Both must live as long; the rules are the mesh's.
  Collapses(const PatchMesh& mesh, PatchRules& rules) : mesh_(mesh), rules_(rules) {}

  // Drops nodes until no other one may go. Returns them, in this order.
  std::vector<Node> Run();

 private:
  // To drop v, with the best triangulation or that from u.
  struct Candidate {
    double cost = 0;  // CostOf
    Node v = 0;
    bool is_fan = false;
    Node u = 0;
    auto operator<=>(const Candidate&) const = default;
  };

  void DropAll(std::vector<Node>& dropped);
  void Offer(Node v);
  // The largest squared circumradius of the new faces.
  double CostOf(const PatchChange& change) const;
  // At least what `old`, `dropped` and `ends` say; nothing if that cannot be.
  std::optional<PatchChange> StarOf(Node v) const;
  std::optional<PatchChange> FanOf(Node v, Node u) const;
  std::optional<PatchChange> RemovalOf(Node v) const;
  std::optional<PatchChange> FlipOf(NodePair edge) const;
  // Adds the triangulation of a hole.
  bool Fill(const Nodes& hole, Node v, PatchChange& change) const;
  // Adds the corners of new faces to `near`.
  void FlipEdges(const std::vector<PatchFace>& faces, std::set<Node>& near);

  const PatchMesh& mesh_;
  PatchRules& rules_;
  std::priority_queue<Candidate, std::vector<Candidate>, std::greater<>> queue_;
};

}  // namespace dynmesh::cleaning

#endif  // DYNMESH_CLIENT_CLEANING_COLLAPSES_H_
