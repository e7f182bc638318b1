#include "core/data/diff_meshes.h"

#include <algorithm>
#include <bit>
#include <cstdint>

namespace dynmesh::data {
namespace {

struct VertexRow {
  const VertexColumns* columns;
  std::size_t row;
};

// Same place, containing dimension and owner (-0 is +0, as in ids and hashes).
bool SameVertex(std::size_t d, const VertexColumns& a, std::size_t i, const VertexColumns& b,
                std::size_t j) {
  for (std::size_t k = 0; k < d; ++k) {
    const double x = a.coordinates[i * d + k] + 0.0;
    const double y = b.coordinates[j * d + k] + 0.0;
    if (std::bit_cast<std::uint64_t>(x) != std::bit_cast<std::uint64_t>(y)) return false;
  }
  return a.containing_dimensions[i] == b.containing_dimensions[j] && a.owners[i] == b.owners[j];
}

void AppendVertex(std::size_t d, const VertexColumns& from, std::size_t row, VertexColumns& to) {
  to.ids.push_back(from.ids[row]);
  for (std::size_t k = 0; k < d; ++k) to.coordinates.push_back(from.coordinates[row * d + k]);
  to.containing_dimensions.push_back(from.containing_dimensions[row]);
  to.owners.push_back(from.owners[row]);
}

// Both sorted by id: one merge.
void DiffVertices(std::size_t d, const VertexColumns& from, const VertexColumns& to,
                  MeshDiff& diff) {
  std::size_t i = 0;
  std::size_t j = 0;
  while (i < from.size() || j < to.size()) {
    if (j == to.size() || (i < from.size() && from.ids[i] < to.ids[j])) {
      diff.removed_vertices.push_back(from.ids[i++]);
    } else if (i == from.size() || to.ids[j] < from.ids[i]) {
      AppendVertex(d, to, j++, diff.added_vertices);
    } else {
      if (!SameVertex(d, from, i, to, j)) {
        diff.removed_vertices.push_back(from.ids[i]);
        AppendVertex(d, to, j, diff.added_vertices);
      }
      ++i;
      ++j;
    }
  }
}

void DiffSimplices(std::size_t width, const SimplexColumn& from, const SimplexColumn& to,
                   MeshDiff& diff) {
  const VertexId* a = from.data();
  const VertexId* b = to.data();
  const VertexId* const a_end = a + from.size();
  const VertexId* const b_end = b + to.size();
  while (a != a_end || b != b_end) {
    const bool a_first =
        b == b_end || (a != a_end && std::lexicographical_compare(a, a + width, b, b + width));
    const bool b_first =
        a == a_end || (b != b_end && std::lexicographical_compare(b, b + width, a, a + width));
    if (a_first) {
      diff.removed_simplices.insert(diff.removed_simplices.end(), a, a + width);
    } else if (b_first) {
      diff.added_simplices.insert(diff.added_simplices.end(), b, b + width);
    }
    if (!b_first) a += width;
    if (!a_first) b += width;
  }
}

using SubsegmentKey = std::array<std::uint64_t, 3>;

SubsegmentKey KeyOf(const SubsegmentColumns& s, std::size_t row) {
  return {s.ends[2 * row], s.ends[2 * row + 1], s.owners[row]};
}

void AppendSubsegment(const SubsegmentKey& key, SubsegmentColumns& to) {
  to.ends.insert(to.ends.end(), {key[0], key[1]});
  to.owners.push_back(key[2]);
}

void DiffSubsegments(const SubsegmentColumns& from, const SubsegmentColumns& to, MeshDiff& diff) {
  std::size_t i = 0;
  std::size_t j = 0;
  while (i < from.size() || j < to.size()) {
    if (j == to.size() || (i < from.size() && KeyOf(from, i) < KeyOf(to, j))) {
      AppendSubsegment(KeyOf(from, i++), diff.removed_subsegments);
    } else if (i == from.size() || KeyOf(to, j) < KeyOf(from, i)) {
      AppendSubsegment(KeyOf(to, j++), diff.added_subsegments);
    } else {
      ++i;
      ++j;
    }
  }
}

}  // namespace

MeshDiff DiffMeshes(const Mesh& from, const Mesh& to) {
  Mesh a = from;
  Mesh b = to;
  Canonicalize(a);
  Canonicalize(b);
  const std::size_t d = static_cast<std::size_t>(to.dimension);
  MeshDiff diff;
  diff.dimension = to.dimension;
  diff.from_revision = from.revision;
  diff.to_revision = to.revision;
  diff.hash = to.hash;
  DiffVertices(d, a.vertices, b.vertices, diff);
  DiffSimplices(d + 1, a.simplices, b.simplices, diff);
  DiffSubsegments(a.subsegments, b.subsegments, diff);
  return diff;
}

}  // namespace dynmesh::data
