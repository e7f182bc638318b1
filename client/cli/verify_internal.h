// The parts of `verify` (verify.h says what each checks), for verify.cc and its tests.
#ifndef DYNMESH_CLIENT_CLI_VERIFY_INTERNAL_H_
#define DYNMESH_CLIENT_CLI_VERIFY_INTERNAL_H_

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "client/cli/verify.h"

namespace dynmesh::cli {

// Collects the failures of one check; keeps the first few, counts all.
class Findings {
 public:
  explicit Findings(std::string name) { check_.name = std::move(name); }
  void Add(std::string what) {
    if (++check_.failures <= kMostExamples) check_.examples.push_back(std::move(what));
  }
  std::uint64_t count() const { return check_.failures; }
  VerifyCheck Take() { return std::move(check_); }

 private:
  static constexpr std::uint64_t kMostExamples = 5;
  VerifyCheck check_;
};

// A triangle's side, from corner k to corner k + 1.
struct Side {
  std::uint32_t a = 0;  // the edge's lesser vertex
  std::uint32_t b = 0;  // its greater vertex
  std::uint32_t triangle = 0;
  std::uint8_t k = 0;
  bool forward = false;  // runs from a to b
};

// All sides, those of one edge together, edges in lexicographic order.
std::vector<Side> CollectSides(const io::IndexedMesh& mesh);
// Calls f(first, count) for the sides of each edge.
template <class F>
void ForEachEdge(const std::vector<Side>& sides, F f) {
  for (std::size_t i = 0; i < sides.size();) {
    std::size_t j = i + 1;
    while (j < sides.size() && sides[j].a == sides[i].a && sides[j].b == sides[i].b) ++j;
    f(&sides[i], j - i);
    i = j;
  }
}

// Vertices and triangles as the files number them.
std::string VertexName(std::uint32_t vertex);
std::string EdgeName(std::uint32_t a, std::uint32_t b);
std::string TriangleName(std::uint32_t triangle);

VerifyCheck CheckVertices(const io::IndexedMesh& mesh);
VerifyCheck CheckOrientation(const io::IndexedMesh& mesh);
VerifyCheck CheckManifold(const io::IndexedMesh& mesh, const std::vector<Side>& sides);
VerifyCheck CheckBox(const io::IndexedMesh& mesh, const std::vector<Side>& sides);
VerifyCheck CheckDelaunay(const io::IndexedMesh& mesh, const std::vector<Side>& sides);
VerifyCheck CheckEdges(const io::MeshFiles& files, const std::vector<Side>& sides);
// Fills the measures of `report` too.
VerifyCheck CheckQuality(const io::IndexedMesh& mesh, double rho, VerifyReport& report);
VerifyCheck CheckInput(const io::IndexedMesh& mesh, const std::vector<Feature>& features);
// Expected O((n + m) lg m + k) for n triangles, m edges of polygons and k crossings of these
// with horizontal lines through the triangles.
VerifyCheck CheckRegions(const io::IndexedMesh& mesh, const std::vector<Feature>& features);

// The spacing of doubles at the largest coordinate of the mesh.
double LargestUlp(const io::IndexedMesh& mesh);

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_CLI_VERIFY_INTERNAL_H_
