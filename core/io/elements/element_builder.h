// Fills an ElementMesh with elements of any type, by the numbers of vertices in a file.
#ifndef DYNMESH_CORE_IO_ELEMENTS_ELEMENT_BUILDER_H_
#define DYNMESH_CORE_IO_ELEMENTS_ELEMENT_BUILDER_H_

#include <span>
#include <string>

#include "absl/container/flat_hash_map.h"
#include "core/base/text.h"
#include "core/io/elements/element_mesh.h"

namespace dynmesh::io {

class ElementBuilder {
 public:
  explicit ElementBuilder(std::string file) { mesh_.file = std::move(file); }

  ElementMesh& mesh() { return mesh_; }

  // A vertex with a number of its own, as in Gmsh. An error if it is there already.
  absl::Status AddVertex(std::uint64_t number, const std::array<double, 3>& position, int line) {
    const auto index = static_cast<std::uint32_t>(mesh_.positions.size());
    if (!index_of_.emplace(number, index).second) {
      return Error(line, text::Concat("vertex ", number, " stands twice"));
    }
    mesh_.positions.push_back(position);
    mesh_.lines.push_back(line);
    return absl::OkStatus();
  }

  // An element whose first 1 to 4 `corners` are numbers of vertices, by their count.
  absl::Status AddElement(std::span<const std::uint64_t> corners, std::int64_t marker, int line) {
    switch (corners.size()) {
      case 1:
        return Add(corners, marker, line, mesh_.points);
      case 2:
        return Add(corners, marker, line, mesh_.segments);
      case 3:
        return Add(corners, marker, line, mesh_.triangles);
      default:
        return Add(corners, marker, line, mesh_.tetrahedra);
    }
  }

  // 3 if there are tetrahedra or different z.
  ElementMesh Take() {
    bool is_flat = mesh_.tetrahedra.empty();
    for (const auto& p : mesh_.positions) is_flat &= p[2] == mesh_.positions[0][2];
    mesh_.dimension = is_flat ? 2 : 3;
    return std::move(mesh_);
  }

  absl::Status Error(int line, std::string_view message) const {
    return TextReader::ErrorAt(mesh_.file, line, message);
  }

 private:
  template <std::size_t N>
  absl::Status Add(std::span<const std::uint64_t> corners, std::int64_t marker, int line,
                   std::vector<Element<N>>& elements) {
    Element<N> element;
    for (std::size_t k = 0; k < N; ++k) {
      const auto it = index_of_.find(corners[k]);
      if (it == index_of_.end()) {
        return Error(line, text::Concat("vertex ", corners[k], " does not exist"));
      }
      element.corners[k] = it->second;
      for (std::size_t j = 0; j < k; ++j) {
        if (element.corners[j] == it->second) {
          return Error(line, text::Concat("an element has vertex ", corners[k], " twice"));
        }
      }
    }
    element.marker = marker;
    element.line = line;
    elements.push_back(element);
    return absl::OkStatus();
  }

  ElementMesh mesh_;
  absl::flat_hash_map<std::uint64_t, std::uint32_t> index_of_;
};

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_ELEMENTS_ELEMENT_BUILDER_H_
