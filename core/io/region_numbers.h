// Regions by small numbers, for files: region ids are hashes where polygons overlap, and a
// file has to say which polygons a number stands for.
//
// The regions that occur are numbered from 1, in the lexicographic order of their polygons'
// ids; 0 is in no polygon. So a number is a function of the mesh, and every writer takes it
// from here. Plain data.
#ifndef DYNMESH_CORE_IO_REGION_NUMBERS_H_
#define DYNMESH_CORE_IO_REGION_NUMBERS_H_

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
  // Of a number from 0 on: "domain", "polygon 12", "polygons 12 40".
  std::string Name(std::uint32_t number) const;
  friend bool operator==(const RegionNumbers&, const RegionNumbers&) = default;
};

// Columns of `mesh` must agree. O(n + k lg k), k the number of regions.
RegionNumbers NumberRegions(const Mesh& mesh);
// The other way: mesh.regions and mesh.region_sets, of simplices in the order of `numbers`.
void SetRegions(const RegionNumbers& regions, Mesh& mesh);

// "12 40": what NumberRegions and its readers mean by the polygons of a row.
std::string FormatPolygons(std::span<const FeatureId> polygons);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_REGION_NUMBERS_H_
