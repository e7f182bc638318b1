// Small numbers for regions in files: region ids are hashes where polygons overlap, and a file must
// list the polygons of a number.
//
// The regions present are numbered from 1, in the lexicographic order of their polygons' ids; 0 is
// in no polygon. So a number is a function of the mesh, and all writers use it. Plain data.
#ifndef DYNMESH_CORE_IO_MESHES_REGION_NUMBERS_H_
#define DYNMESH_CORE_IO_MESHES_REGION_NUMBERS_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "dynmesh/mesh.h"

namespace dynmesh::io {

struct RegionNumbers {
  // Row k - 1: the polygons that region k lies in, ascending, at least one.
  std::vector<std::vector<FeatureId>> polygons;
  std::vector<std::uint32_t> numbers;  // of simplices; empty if all are 0

  std::uint32_t Of(std::size_t simplex) const { return numbers.empty() ? 0 : numbers[simplex]; }
  std::size_t count() const { return polygons.size(); }
  // The name of a number from 0 on: "domain", "polygon 12", "polygons 12 40".
  std::string Name(std::uint32_t number) const;
  friend bool operator==(const RegionNumbers&, const RegionNumbers&) = default;
};

// REQUIRES: columns of `mesh` agree. O(n + k lg k) for k regions.
RegionNumbers NumberRegions(const Mesh& mesh);
// The inverse: sets mesh.regions and mesh.region_sets, for simplices in the order of `numbers`.
void SetRegions(const RegionNumbers& regions, Mesh& mesh);

// "12 40": the format of a row's polygons.
std::string FormatPolygons(std::span<const FeatureId> polygons);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_MESHES_REGION_NUMBERS_H_
