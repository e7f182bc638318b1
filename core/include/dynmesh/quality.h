// How good a mesh is: radius-edge ratios and angles, in space those between the faces of a
// tetrahedron (dihedral). Pure functions, thread-safe.
#ifndef DYNMESH_QUALITY_H_
#define DYNMESH_QUALITY_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "dynmesh/mesh.h"
#include "dynmesh/options.h"

namespace dynmesh {

// Of one triangle. A flat or inverted one has ratio infinity.
struct TriangleQuality {
  double radius_edge = 0;    // circumradius / shortest edge, at least 1 / sqrt(3)
  double shortest_edge = 0;  // in the units of the coordinates
  double min_angle_deg = 0;  // of the three angles, in degrees
  double max_angle_deg = 0;  // of the three angles, in degrees
  std::array<double, 3> angles_deg = {0, 0, 0};  // at a, b, c
};

// The quality of the triangle `a`, `b`, `c`: two coordinates each. Differences are taken first and
// scaled, so that a tiny triangle far from the origin loses nothing that its coordinates still
// have; relative error about 1e-15 of the triangle as given, for coordinates whose differences are
// 0 or normal numbers.
TriangleQuality MeasureTriangle(const double* a, const double* b, const double* c);

// Of one tetrahedron. A flat or inverted one has ratio infinity.
struct TetrahedronQuality {
  double radius_edge = 0;    // circumradius / shortest edge, at least sqrt(3/8)
  double shortest_edge = 0;  // in the units of the coordinates
  double min_angle_deg = 0;  // of the six dihedral angles, in degrees
  double max_angle_deg = 0;  // of the six dihedral angles, in degrees
  std::array<double, 6> angles_deg = {0, 0, 0, 0, 0, 0};  // at ab, ac, ad, bc, bd, cd
};

// The quality of the tetrahedron `a`, `b`, `c`, `d`: three coordinates each. However thin it is:
// where doubles do not tell, exact integers do, so that the ratio has a relative error below 1e-10
// (about 1e-15 if it is no sliver) and "flat" is exact; angles are right to some 1e-9 degrees, in
// needles less. Only beyond coordinates of 2^-250 to 2^250 one that doubles do not tell counts as
// flat.
TetrahedronQuality MeasureTetrahedron(const double* a, const double* b, const double* c,
                                      const double* d);

// The spacing of doubles at the largest magnitude among `coordinates`; 0 if all are 0.
double CoordinateUnit(std::span<const double> coordinates);

// The slack h of the test ratio > rho (1 + h). Coordinates are rounded to the `unit` u, so
// points placed at distance e, such as that of the `shortest_edge`, are off by about u / e
// relatively, and no refinement could do better:  h = 2e-9 + 8 u / e',  e' the square root of the
// largest power of two that is at most e^2 (so that the last bit of e does not matter).
double QualitySlack(double shortest_edge, double unit);

// triangle.radius_edge > rho (1 + QualitySlack(triangle.shortest_edge, unit)).
bool IsOverRho(const TriangleQuality& triangle, double rho, double unit);

// What is to be said of a simplex.
enum class SimplexVerdict : std::uint8_t {
  kGood = 0,              // within rho
  kSmallInputAngle = 1,   // over rho, for the sake of an edge that is as short as an angle of the
                          // input makes it; within rho of its shortest other edge
  kOverRho = 2,           // over rho without excuse
  kTerminationGuard = 3,  // over rho, because mending it would split a subsegment that is too
                          // short for its surroundings already: that might never end
  kBelowDihedral = 4,     // a tetrahedron within rho with a dihedral angle below min_dihedral: of
                          // a mesh made with that, no place tried for a Steiner point would do
};

// Is a simplex with the verdict `v` over rho, excused or not?
inline bool IsOverRho(SimplexVerdict v) {
  return v != SimplexVerdict::kGood && v != SimplexVerdict::kBelowDihedral;
}

// Is a simplex over rho with the verdict `v` excused? One within rho needs no excuse: false.
inline bool IsExempt(SimplexVerdict v) {
  return v == SimplexVerdict::kSmallInputAngle || v == SimplexVerdict::kTerminationGuard;
}

// The verdict on each simplex of `mesh`, in its order. A function of the mesh, of
// `options`.quality and, in space, of `options`.min_dihedral.
// O(size). In space exact with the bound rho (1 + h) as rounded, and none is exempt. In the
// plane the guard leaves single triangles: of a mesh with more than 1,000 that no angle
// excuses, the others are kOverRho.
// Below min_dihedral is what the mesher takes for a sliver, to the bit: tetrahedra that it calls
// good are not below, and none that is not below has an angle less than the bound. One whose
// least angle is the bound but for rounding may count as below: up to 1e-9 degrees more where the
// bound is 5 degrees or more, up to 1e-4 more where it is next to nothing.
std::vector<SimplexVerdict> JudgeSimplices(const Mesh& mesh, const MeshOptions& options);

// A tetrahedron that stands out by its least dihedral angle.
struct WorstTetrahedron {
  double angle_deg = 0;                        // the least of its six, in degrees
  std::uint64_t index = 0;                     // in the mesh's order of simplices, from 0
  std::array<double, 3> centroid = {0, 0, 0};  // the mean of its corners
  friend bool operator==(const WorstTetrahedron&, const WorstTetrahedron&) = default;
};

// How many QualityReport::worst_dihedral holds at most.
inline constexpr std::size_t kWorstDihedral = 10;

// How good a whole mesh is.
struct QualityReport {
  double worst_radius_edge = 0;       // the largest circumradius / shortest edge
  double min_angle_deg = 0;           // the least angle, in degrees; dihedral in space
  double max_angle_deg = 0;           // the greatest angle, in degrees
  std::uint64_t over_rho = 0;         // simplices over rho, exempt ones included
  std::uint64_t exempt = 0;           // of these, how many are allowed to be
  std::uint64_t exempt_by_guard = 0;  // of these, how many by kTerminationGuard
  // In the plane, angles of all simplices, in steps of 10 degrees: [0, 10), ... [170, 180].
  std::array<std::uint64_t, 18> angle_histogram = {};
  // In space, dihedral angles of all, six each, in steps of 5 degrees: [0, 5), ... [175, 180].
  std::array<std::uint64_t, 36> dihedral_histogram = {};
  // In space, the share of tetrahedra with a dihedral angle below 5 degrees. No bound on the ratio
  // excludes these slivers.
  double share_below_5_deg = 0;
  double share_below_10_deg = 0;  // the same below 10 degrees
  // In space, tetrahedra below MeshOptions::min_dihedral as JudgeSimplices has it, those over rho
  // and flat ones included; 0 if that is 0.
  std::uint64_t below_dihedral = 0;
  // In space, the kWorstDihedral tetrahedra with the least angles, all if there are fewer, the
  // least first; of equal angles the lesser index. Those that name an unknown vertex are left out.
  std::vector<WorstTetrahedron> worst_dihedral;
};

// Of all simplices of `mesh`, the domain's border included; angles are dihedral in space. The
// bounds are `options`.quality and `options`.min_dihedral. O(size). A simplex that names an unknown
// vertex counts as flat.
QualityReport MeasureQuality(const Mesh& mesh, const MeshOptions& options);

}  // namespace dynmesh

#endif  // DYNMESH_QUALITY_H_
