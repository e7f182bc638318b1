// The part of a mesh, or of a diff, that lies in chosen polygons. Pure functions of rows,
// no geometry: whether a simplex is inside, its region tells. Thread-safe.
#ifndef DYNMESH_CORE_DATA_REGION_FILTER_H_
#define DYNMESH_CORE_DATA_REGION_FILTER_H_

#include <span>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "dynmesh/mesh.h"

namespace dynmesh::data {

// A simplex is chosen if it lies in at least one polygon of `in` (with in_any: of all there
// are; if neither is given: anywhere, in polygons or not) and in none of `out`.
struct RegionChoice {
  std::vector<FeatureId> in;  // ascending, none twice
  bool in_any = false;
  std::vector<FeatureId> out;  // ascending, none twice
  bool IsEverything() const { return in.empty() && !in_any && out.empty(); }
  bool Has(std::span<const FeatureId> polygons) const;
  friend bool operator==(const RegionChoice&, const RegionChoice&) = default;
};
// Sorts both lists and drops what stands twice.
void Normalize(RegionChoice& choice);

// Decides region by region, each once. `sets` of the mesh or diff in question, by ascending
// id; they must outlive it. Thread-compatible.
class RegionFilter {
 public:
  RegionFilter(const RegionChoice& choice, std::span<const RegionSet> sets);
  bool Has(RegionId region);

 private:
  const RegionChoice& choice_;
  const std::span<const RegionSet> sets_;
  RegionId last_ = kNoRegion;
  bool has_last_;
  absl::flat_hash_map<RegionId, bool> known_;
};

// The chosen simplices with their vertices and those subsegments and subfacets that are edges
// and facets of them; rows in the order that they have, revision as it was, the hash that of
// what is left. O(mesh).
Mesh OnlyInside(const Mesh& mesh, const RegionChoice& choice);

// The chosen simplices with all vertices, subsegments and subfacets, as a diff can keep up
// with: which of them are in use it does not say. The hash is that of what is left.
Mesh SimplicesInside(const Mesh& mesh, const RegionChoice& choice);

// The same of a diff. `hidden` is the sum of the hashes of the simplices that were left out
// of the mesh so far, and is brought up to date; the hash becomes that of what is left.
MeshDiff SimplicesInside(const MeshDiff& diff, const RegionChoice& choice, MeshHash& hidden);

}  // namespace dynmesh::data

#endif  // DYNMESH_CORE_DATA_REGION_FILTER_H_
