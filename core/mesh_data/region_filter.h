// The part of a mesh, or of a diff, that lies in chosen polygons. Pure functions of rows, no
// geometry: a simplex's region determines whether it is inside. Labels are those of all features.
// Thread-safe.
#ifndef DYNMESH_CORE_MESH_DATA_REGION_FILTER_H_
#define DYNMESH_CORE_MESH_DATA_REGION_FILTER_H_

#include <span>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "dynmesh/mesh.h"

namespace dynmesh::mesh_data {

// Chooses simplices in at least one polygon of `in` and in none of `out`. With in_any, `in` means
// all polygons present. Without `in` and in_any, all simplices count as in it.
struct RegionChoice {
  std::vector<FeatureId> in;  // ascending, none twice
  bool in_any = false;
  std::vector<FeatureId> out;  // ascending, none twice
  bool IsEverything() const { return in.empty() && !in_any && out.empty(); }
  bool Has(std::span<const FeatureId> polygons) const;
  friend bool operator==(const RegionChoice&, const RegionChoice&) = default;
};
// Sorts both lists and removes duplicates.
void Normalize(RegionChoice& choice);

// Decides once per region. `sets` of the mesh or diff, by ascending id, must outlive it.
// Thread-compatible.
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

// The chosen simplices, their vertices, and the subsegments and subfacets that are their edges and
// facets. Keeps the order of rows and the revision. The hash is that of the result. O(mesh).
Mesh OnlyInside(const Mesh& mesh, const RegionChoice& choice);
// The same for the simplices with `keep`, an entry for each row.
Mesh OnlyRows(const Mesh& mesh, const std::vector<bool>& keep);

// The chosen simplices with all vertices, subsegments and subfacets: a diff does not show which of
// these are in use. The hash is that of the result.
Mesh SimplicesInside(const Mesh& mesh, const RegionChoice& choice);

// The same for a diff. `hidden` is the sum of the hashes of the simplices omitted so far; it is
// updated. The hash becomes that of the result.
MeshDiff SimplicesInside(const MeshDiff& diff, const RegionChoice& choice, MeshHash& hidden);

}  // namespace dynmesh::mesh_data

#endif  // DYNMESH_CORE_MESH_DATA_REGION_FILTER_H_
