// Leaves as cells of a VTK file.
#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "core/io/common/file_writer.h"
#include "core/io/common/vtu_array.h"
#include "core/io/quadtrees/leaf_list.h"

namespace dynmesh::io {

absl::Status WriteLeafVtu(const LeafList& list, const std::string& path) {
  constexpr std::uint8_t kVtkQuad = 9, kVtkHexahedron = 12;
  // Counter-clockwise; bit k: the upper end along axis k.
  constexpr std::array kAround = {0, 1, 3, 2, 4, 5, 7, 6};
  const auto width = static_cast<std::size_t>(list.dimension);
  const std::size_t corners = std::size_t{1} << width;

  // Common corners have the same coordinates, to the bit.
  absl::flat_hash_map<std::array<std::uint64_t, 3>, std::int64_t> numbers;
  std::vector<double> points, sides;
  std::vector<std::int64_t> connectivity, offsets;
  std::vector<std::uint8_t> levels;
  std::vector<std::uint64_t> ids;
  for (const LeafList::Leaf& leaf : list.leaves) {
    for (std::size_t i = 0; i < corners; ++i) {
      std::array<double, 3> p = {0, 0, 0};
      std::array<std::uint64_t, 3> key = {0, 0, 0};
      for (std::size_t k = 0; k < width; ++k) {
        p[k] = (kAround[i] >> k & 1 ? leaf.cell.box.hi : leaf.cell.box.lo)[k] + 0.0;
        key[k] = std::bit_cast<std::uint64_t>(p[k]);
      }
      const auto [at, is_new] = numbers.try_emplace(key, static_cast<std::int64_t>(numbers.size()));
      if (is_new) points.insert(points.end(), p.begin(), p.end());
      connectivity.push_back(at->second);
    }
    offsets.push_back(static_cast<std::int64_t>(connectivity.size()));
    levels.push_back(static_cast<std::uint8_t>(leaf.cell.level));
    sides.push_back(leaf.cell.side);
    ids.push_back(leaf.id);
  }

  FileWriter out(path);
  out << kVtuBegin << "    <Piece NumberOfPoints=\"" << numbers.size() << "\" NumberOfCells=\""
      << list.leaves.size() << "\">\n      <Points>\n";
  WriteArray("Float64", "Points", 3, points, out);
  out << "      </Points>\n      <Cells>\n";
  WriteArray("Int64", "connectivity", 1, connectivity, out);
  WriteArray("Int64", "offsets", 1, offsets, out);
  WriteArray("UInt8", "types", 1,
             std::vector<std::uint8_t>(list.leaves.size(), width == 2 ? kVtkQuad : kVtkHexahedron),
             out);
  out << "      </Cells>\n      <CellData Scalars=\"level\">\n";
  WriteArray("UInt8", "level", 1, levels, out);
  WriteArray("Float64", "side", 1, sides, out);
  WriteArray("UInt64", "id", 1, ids, out);
  out << "      </CellData>\n    </Piece>\n" << kVtuEnd;
  return out.Close();
}

}  // namespace dynmesh::io
