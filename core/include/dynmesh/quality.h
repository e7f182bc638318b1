// Quality of a mesh: radius-edge ratios and angles, in 3D dihedral angles. Pure functions,
// thread-safe.
//
//   const dynmesh::QualityReport report = dynmesh::MeasureQuality(mesh, options);
//   const bool good = report.over_rho == report.exempt;
#ifndef DYNMESH_QUALITY_H_
#define DYNMESH_QUALITY_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "dynmesh/feature.h"
#include "dynmesh/mesh.h"
#include "dynmesh/options.h"

namespace dynmesh {

// Quality of a triangle. A flat or inverted one has ratio infinity.
struct TriangleQuality {
  double radius_edge = 0;    // circumradius / shortest edge, at least 1 / sqrt(3)
  double shortest_edge = 0;  // in the units of the coordinates
  double min_angle_deg = 0;  // of the three angles, in degrees
  double max_angle_deg = 0;  // of the three angles, in degrees
  std::array<double, 3> angles_deg = {0, 0, 0};  // at a, b, c
};

// The quality of the triangle `a`, `b`, `c`: two coordinates each. Relative error about 1e-15 of
// the triangle as given, if the differences of its coordinates are 0 or normal numbers. Also for a
// tiny triangle far from the origin: differences are taken first, then scaled.
TriangleQuality MeasureTriangle(const double* a, const double* b, const double* c);

// Quality of a tetrahedron. A flat or inverted one has ratio infinity.
struct TetrahedronQuality {
  double radius_edge = 0;    // circumradius / shortest edge, at least sqrt(3/8)
  double shortest_edge = 0;  // in the units of the coordinates
  double min_angle_deg = 0;  // of the six dihedral angles, in degrees
  double max_angle_deg = 0;  // of the six dihedral angles, in degrees
  std::array<double, 6> angles_deg = {0, 0, 0, 0, 0, 0};  // at ab, ac, ad, bc, bd, cd
};

// The quality of the tetrahedron `a`, `b`, `c`, `d`: three coordinates each. However thin it is,
// "flat" is exact and the ratio has a relative error below 1e-10 (about 1e-15 if it is no sliver):
// exact integers decide where doubles cannot. Angles have an error of some 1e-9 degrees, more in
// needles. Outside coordinates of 2^-250 to 2^250 a tetrahedron counts as flat if doubles cannot
// decide.
TetrahedronQuality MeasureTetrahedron(const double* a, const double* b, const double* c,
                                      const double* d);

// The spacing of doubles at the largest magnitude among `coordinates`; 0 if all are 0.
double CoordinateUnit(std::span<const double> coordinates);

// The slack h of the test ratio > rho (1 + h). Coordinates are multiples of the `unit` u. So a
// point placed at distance e, such as `shortest_edge`, is off by about u / e relatively, which no
// refinement can improve. h = 2e-9 + 8 u / e', with e' = sqrt(2^k), 2^k <= e^2 < 2^(k+1): the last
// bit of e does not matter.
double QualitySlack(double shortest_edge, double unit);

// triangle.radius_edge > rho (1 + QualitySlack(triangle.shortest_edge, unit)).
bool IsOverRho(const TriangleQuality& triangle, double rho, double unit);

// The verdict on a simplex.
enum class SimplexVerdict : std::uint8_t {
  kGood = 0,             // within rho
  kSmallInputAngle = 1,  // over rho because a small input angle makes one edge short; within rho of
                         // its shortest other edge
  kOverRho = 2,          // over rho without an excuse
  kTerminationGuard = 3,  // over rho: fixing it would split a subsegment that is too short for its
                          // surroundings already, which might never end
  kUnsplit = 5,  // over rho: the point that would fix it lies, or lay when it was tried, in the
                 // circle over an unsplit segment (Feature::unsplit)
  kBelowDihedral = 4,  // a tetrahedron within rho with a dihedral angle below min_dihedral; in a
                       // mesh made with that, no tried Steiner point was good
};

// Is a simplex with the verdict `v` over rho, excused or not?
inline bool IsOverRho(SimplexVerdict v) {
  return v != SimplexVerdict::kGood && v != SimplexVerdict::kBelowDihedral;
}

// Is a simplex over rho with the verdict `v` excused? One within rho needs no excuse: false.
inline bool IsExempt(SimplexVerdict v) {
  return v == SimplexVerdict::kSmallInputAngle || v == SimplexVerdict::kTerminationGuard ||
         v == SimplexVerdict::kUnsplit;
}

// The verdict on each simplex of `mesh`, in its order. A function of the mesh, of `options`.quality
// and, in 3D, of `options`.min_dihedral. O(size), if something is unsplit O(size lg size).
//
// 2D: the guard leaves single triangles. If more than 1,000 are over rho without a small input
// angle, the others are kOverRho. 3D: exact with the bound rho (1 + h) as rounded, and the guard
// exempts no simplex.
//
// kBelowDihedral is what the mesher takes for a sliver, to the bit. A tetrahedron that is not
// kBelowDihedral has no angle less than the bound, except angles that a small input angle makes:
// opposite to an edge between segments that it makes short. A tetrahedron may be kBelowDihedral
// with a least angle slightly above the bound: by up to 1e-9 degrees if the bound is 5 degrees or
// more, by up to 1e-4 if it is close to 0.
//
// `features`: of the mesh's input, for kUnsplit; points and what is unsplit count. Without them an
// unsplit segment excuses nothing.
std::vector<SimplexVerdict> JudgeSimplices(const Mesh& mesh, const MeshOptions& options,
                                           std::span<const Feature> features = {});

// A tetrahedron with one of the least dihedral angles.
struct WorstTetrahedron {
  double angle_deg = 0;                        // the least of its six, in degrees
  std::uint64_t index = 0;                     // in the mesh's order of simplices, from 0
  std::array<double, 3> centroid = {0, 0, 0};  // the mean of its corners
  friend bool operator==(const WorstTetrahedron&, const WorstTetrahedron&) = default;
};

// The most entries of QualityReport::worst_dihedral.
inline constexpr std::size_t kWorstDihedral = 10;

// Quality of a whole mesh.
struct QualityReport {
  double worst_radius_edge = 0;         // the largest circumradius / shortest edge
  double min_angle_deg = 0;             // the least angle, in degrees; dihedral in 3D
  double max_angle_deg = 0;             // the greatest angle, in degrees; dihedral in 3D
  std::uint64_t over_rho = 0;           // simplices over rho, exempt ones included
  std::uint64_t exempt = 0;             // of these, the exempt ones
  std::uint64_t exempt_by_guard = 0;    // of these, those by kTerminationGuard
  std::uint64_t exempt_by_unsplit = 0;  // of the exempt ones, those by kUnsplit
  // 2D: angles of all simplices, in steps of 10 degrees: [0, 10), ... [170, 180].
  std::array<std::uint64_t, 18> angle_histogram = {};
  // 3D: dihedral angles of all, six each, in steps of 5 degrees: [0, 5), ... [175, 180].
  std::array<std::uint64_t, 36> dihedral_histogram = {};
  // 3D: the share of tetrahedra with a dihedral angle below 5 degrees. No bound on the ratio
  // excludes these slivers.
  double share_below_5_deg = 0;
  double share_below_10_deg = 0;  // the same below 10 degrees
  // 3D: tetrahedra below MeshOptions::min_dihedral by the test of JudgeSimplices, those over rho
  // and flat ones included; 0 if min_dihedral is 0.
  std::uint64_t below_dihedral = 0;
  // 3D: tetrahedra that are not, but have an angle below the bound because of a small input angle.
  std::uint64_t exempt_dihedral = 0;
  // 3D: the kWorstDihedral tetrahedra with the least angles (all, if there are fewer), the least
  // first; equal angles by index. Those that name an unknown vertex are left out.
  std::vector<WorstTetrahedron> worst_dihedral;
};

// Measures all simplices of `mesh`, the domain's border included; angles are dihedral in 3D. The
// bounds are `options`.quality and `options`.min_dihedral. A simplex that names an unknown vertex
// counts as flat. O(size).
// `features`: as for JudgeSimplices.
QualityReport MeasureQuality(const Mesh& mesh, const MeshOptions& options,
                             std::span<const Feature> features = {});

// The local feature size (Def. 1.3.1 of the thesis) at each of n `points` (n x dimension
// coordinates): the radius of the least ball about the point that meets two disjoint features;
// infinity if there are no such two. `features`: of a mesh of `dimension`; points, segments, edges
// of polygons, and in 3D polygons count, those that name absent points do not. Expected
// O((features + n) lg features), and for each point the features within that distance.
std::vector<double> LocalFeatureSizes(std::span<const Feature> features, int dimension,
                                      std::span<const double> points);

}  // namespace dynmesh

#endif  // DYNMESH_QUALITY_H_
