// How good a mesh is: radius-edge ratios and angles. Pure functions, thread-safe.
#ifndef DYNMESH_QUALITY_H_
#define DYNMESH_QUALITY_H_

#include <array>
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
  double min_angle_deg = 0;
  double max_angle_deg = 0;
  std::array<double, 3> angles_deg = {0, 0, 0};  // at a, b, c
};

// a, b, c: two coordinates each. Differences are taken first and scaled, so that a
// tiny triangle far from the origin loses nothing that its coordinates still have;
// relative error about 1e-15 of the triangle as given, for coordinates whose
// differences are 0 or normal numbers.
TriangleQuality MeasureTriangle(const double* a, const double* b, const double* c);

// The spacing of doubles at the largest magnitude among `coordinates`; 0 if all are 0.
double CoordinateUnit(std::span<const double> coordinates);

// The slack h of the test ratio > rho (1 + h). Coordinates are rounded to the unit u,
// so points placed at distance e are off by about u / e relatively, and no refinement
// could do better:  h = 2e-9 + 8 u / e',  e' the square root of the largest power of
// two that is at most e^2 (so that nobody's last bit of e matters).
double QualitySlack(double shortest_edge, double unit);

// radius_edge > rho (1 + QualitySlack).
bool IsOverRho(const TriangleQuality& triangle, double rho, double unit);

// What is to be said of a simplex.
enum class SimplexVerdict : std::uint8_t {
  kGood = 0,              // within rho
  kSmallInputAngle = 1,   // over rho, for the sake of an edge that is as short as an angle of the
                          // input makes it; within rho of its shortest other edge
  kOverRho = 2,           // over rho without excuse
  kTerminationGuard = 3,  // over rho, because mending it would split a subsegment that is too
                          // short for its surroundings already: that might never end
};

// Is a simplex over rho excused?
inline bool IsExempt(SimplexVerdict v) {
  return v == SimplexVerdict::kSmallInputAngle || v == SimplexVerdict::kTerminationGuard;
}

// Of each simplex of `mesh` (of dimension 2), in its order. A function of the mesh and of
// options.quality. O(size). The guard leaves single triangles: of a mesh with more than 1,000
// that no angle excuses, the others are kOverRho.
std::vector<SimplexVerdict> JudgeSimplices(const Mesh& mesh, const MeshOptions& options);

struct QualityReport {
  double worst_radius_edge = 0;
  double min_angle_deg = 0;
  double max_angle_deg = 0;
  std::uint64_t over_rho = 0;         // simplices over rho, exempt ones included
  std::uint64_t exempt = 0;           // of these, how many are allowed to be
  std::uint64_t exempt_by_guard = 0;  // of these, how many by kTerminationGuard
  // Angles of all simplices, in steps of 10 degrees: [0, 10), [10, 20), ... [170, 180].
  std::array<std::uint64_t, 18> angle_histogram = {};
};

// All simplices of `mesh` (of dimension 2), the domain's border included. rho is
// options.quality. O(size). A simplex that names an unknown vertex counts as flat.
QualityReport MeasureQuality(const Mesh& mesh, const MeshOptions& options);

}  // namespace dynmesh

#endif  // DYNMESH_QUALITY_H_
