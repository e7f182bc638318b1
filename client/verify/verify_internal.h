// The parts of `verify`, for verify.cc and its tests (verify.h describes the checks).
#ifndef DYNMESH_CLIENT_VERIFY_VERIFY_INTERNAL_H_
#define DYNMESH_CLIENT_VERIFY_VERIFY_INTERNAL_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "client/verify/verify.h"
#include "core/base/union_find.h"

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

// An edge of the mesh's simplices.
struct MeshEdge {
  std::uint32_t a = 0;  // the lesser vertex
  std::uint32_t b = 0;
  bool on_border = false;
};

// A triangle's side, from corner k to corner k + 1.
struct Side {
  std::uint32_t a = 0;  // the edge's lesser vertex
  std::uint32_t b = 0;  // its greater vertex
  std::uint32_t triangle = 0;
  std::uint8_t k = 0;
  bool forward = false;  // runs from a to b
};

// All sides; those of one edge are adjacent, edges in lexicographic order.
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

// Each edge once, in lexicographic order.
std::vector<MeshEdge> EdgesOf(const std::vector<Side>& sides);

// A side of a tetrahedron, opposite corner k.
struct Face {
  std::array<std::uint32_t, 3> v = {0, 0, 0};  // ascending
  std::uint32_t tetrahedron = 0;
  std::uint8_t k = 0;
  bool even = false;  // v has the tetrahedron's orientation
};

// All faces; those of one triangle are adjacent, triangles in lexicographic order.
std::vector<Face> CollectFaces(const io::IndexedMesh& mesh);
// Calls f(first, count) for the faces of each triangle.
template <class F>
void ForEachTriangle(const std::vector<Face>& faces, F f) {
  for (std::size_t i = 0; i < faces.size();) {
    std::size_t j = i + 1;
    while (j < faces.size() && faces[j].v == faces[i].v) ++j;
    f(&faces[i], j - i);
    i = j;
  }
}
// Each edge of a tetrahedron once, in lexicographic order.
std::vector<MeshEdge> EdgesOf(const io::IndexedMesh& mesh, const std::vector<Face>& faces);

// Names of vertices and simplices, numbered as in the files.
std::string VertexName(std::uint32_t vertex);
std::string EdgeName(std::uint32_t a, std::uint32_t b);
std::string FaceName(const std::array<std::uint32_t, 3>& v);
std::string TriangleName(std::uint32_t triangle);
std::string TetrahedronName(std::uint32_t tetrahedron);

// Two points joined by a segment or by an edge of a polygon, and the feature that owns the chain of
// edges between them.
struct Joint {
  const Feature* feature;
  FeatureId from;
  FeatureId to;
};
// All joints. The owner of one is its segment, else the first of its polygons. O(n lg n).
std::vector<Joint> JointsOf(const std::vector<Feature>& features);

// Equal for equal places: zero has no sign, and in 2D z is 0, whatever the file has.
using PositionKey = std::array<std::uint64_t, 3>;
PositionKey PositionKeyOf(const std::array<double, 3>& p, int dimension);

// For both dimensions.
VerifyCheck CheckVertices(const io::IndexedMesh& mesh);
VerifyCheck CheckOrientation(const io::IndexedMesh& mesh);
// `is_whole`: the border is the box's, marked -1.
VerifyCheck CheckEdges(const io::MeshFiles& files, const std::vector<MeshEdge>& edges,
                       bool is_whole = true);
// The result of CheckInput for CheckFacets: the chain of vertices between two joined points, by
// their ids, the lesser first. Incorrect chains are absent.
using Chains = std::map<std::pair<FeatureId, FeatureId>, std::vector<std::uint32_t>>;
VerifyCheck CheckInput(const io::IndexedMesh& mesh, const std::vector<Feature>& features,
                       Chains* chains = nullptr);
// The same for a part of a mesh. Without `has_edges` no marker is known: then points only. O(n lg
// n), plus for each edge on the rest of a joint whose ends are not in the part O(joints of its
// feature).
VerifyCheck CheckPartInput(const io::IndexedMesh& mesh, const std::vector<Feature>& features,
                           bool has_edges);
// O(n lg n), plus for each sizing feature O(simplices that are too long for it), mostly a
// comparison of boxes.
VerifyCheck CheckSizes(const io::IndexedMesh& mesh, const std::vector<Feature>& features);

// For 2D.
// `is_whole`: the triangles are one disc, with one fan around each vertex. Else only sides count.
VerifyCheck CheckManifold(const io::IndexedMesh& mesh, const std::vector<Side>& sides,
                          bool is_whole = true);
VerifyCheck CheckOverlap(const io::IndexedMesh& mesh, const std::vector<Side>& sides);
VerifyCheck CheckBox(const io::IndexedMesh& mesh, const std::vector<Side>& sides);
// `is_constrained`: subsegments block the view across them.
VerifyCheck CheckDelaunay(const io::IndexedMesh& mesh, const std::vector<Side>& sides,
                          bool is_constrained);
// Also fills the measures of `report`. `features`: for what unsplit segments excuse; null: unknown.
VerifyCheck CheckQuality(const io::IndexedMesh& mesh, double rho, VerifyReport& report,
                         const std::vector<Feature>* features = nullptr);
VerifyCheck CheckUnsplit(const io::IndexedMesh& mesh, const std::vector<Side>& sides,
                         const std::vector<Feature>& features);
// Expected O((n + m) lg m + k) for n triangles, m edges of polygons and k crossings of these
// with horizontal lines through the triangles.
VerifyCheck CheckRegions(const io::IndexedMesh& mesh, const std::vector<Feature>& features);

// For 3D.
VerifyCheck CheckManifold(const io::IndexedMesh& mesh, const std::vector<Face>& faces);
VerifyCheck CheckOverlap(const io::IndexedMesh& mesh, const std::vector<Face>& faces);
VerifyCheck CheckBox(const io::IndexedMesh& mesh, const std::vector<Face>& faces);
VerifyCheck CheckDelaunay(const io::IndexedMesh& mesh, const std::vector<Face>& faces);
VerifyCheck CheckFaces(const io::MeshFiles& files, const std::vector<Face>& faces);
VerifyCheck CheckSpaceQuality(const io::IndexedMesh& mesh, double rho, VerifyReport& report);
// Reports the worst first. Fills below_dihedral of `report`.
VerifyCheck CheckDihedral(const io::IndexedMesh& mesh, double min_dihedral, VerifyReport& report);
VerifyCheck CheckFacets(const io::IndexedMesh& mesh, const std::vector<Feature>& features,
                        const Chains& chains);
VerifyCheck CheckRegions(const io::IndexedMesh& mesh, const std::vector<Face>& faces,
                         const std::vector<Feature>& features);

// Measures of a simplex: circumradius / shortest edge, and angles in degrees, dihedral in 3D. The
// initial values are for a flat or inverted simplex.
struct Shape {
  double ratio = std::numeric_limits<double>::infinity();
  double shortest = 0;
  double min_angle = 0;
  double max_angle = 180;
  double least_area = 0;  // of a tetrahedron: least of 2 area of a face / (longest edge)^2
};
// Updates the measures of the report.
void Record(const Shape& shape, VerifyReport& report);

// The spacing of doubles at the largest coordinate of the mesh.
double LargestUlp(const io::IndexedMesh& mesh);
// Vertices that refinement puts on a segment or a polygon are rounded to doubles. Each may inherit
// the rounding errors of the vertices between which it was placed. So a vertex is on a segment if
// it is at most so many ulps of the mesh's largest coordinate from its line.
inline constexpr double kStraightnessUlps = 16;
// The tolerance of rho for rounded coordinates: 2e-9 + 8 u / e', where e' is the root of the
// largest power of two <= e^2, e the shortest edge and u the ulp.
double Slack(double shortest, double ulp);

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_VERIFY_VERIFY_INTERNAL_H_
