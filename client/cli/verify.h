// Checks of a mesh file, made without the mesher: only core/io is shared with it.
// Predicates are exact (CGAL's kernel), everything else is written anew here, so that
// an error of the mesher is not repeated by its judge.
//
// Checks, by name:
//   vertices     finite (else nothing more is checked), no two in one place, each a
//                corner of a triangle
//   orientation  every triangle is counter-clockwise, exactly
//   manifold     every edge has one or two triangles, one on each side; around every
//                vertex they form one fan; all hang together; V - E + T = 1
//   box          the border is a rectangle, run round once. With the two above: the
//                triangles cover it once, without gap or overlap
//   delaunay     no vertex inside the circle of a triangle beyond one of its edges,
//                exactly; by Delaunay's lemma then none inside any circle
//   edges        the .edge file has every edge once and no other; -1 marks the
//                border's edges and vertices and none else
//   quality      no triangle over rho, but exempt ones
//   hash         the one recorded in the file is that of its content
//   input        (if given) every input point is a vertex with its id as marker, every
//                segment a straight chain of edges with its id; every edge of a polygon
//                too, with the id of the segment that has the same ends, else of the first
//                polygon that has it; and no id more
//   regions      (if the input is given) every triangle is in the polygons that it says, by
//                a place inside it, exactly
// In space the same by tetrahedra, but
//   manifold     every face has one or two tetrahedra, one on each side
//   box          the border is on the sides of a box, and the volumes sum up to that of the box.
//                With the two above every place is in equally many tetrahedra, as their number
//                does not change across a face; the volume says that it is one
//   delaunay     no vertex inside the sphere of a tetrahedron beyond one of its faces
//   edges        -1 only on the border's edges
//   faces        the .face file has every subfacet and every other face of the border once, and
//                no other; -1 marks those of the border and none else; all are faces of tetrahedra
//   facets       (if the input is given) the subfacets of every polygon cover it exactly once,
//                flat but for rounding; and none has another marker. They are one sheet: of a
//                nearly flat tetrahedron whose corners are all on a polygon, one side counts
//   regions      (if the input is given) every tetrahedron says which closed surfaces it is inside
//                of, told by going from one to the next through all that is no subfacet
//   dihedral     (if a bound is given) no dihedral angle is less, exactly where the bound is near
// and what is bad for the sake of a small angle is not excused.
#ifndef DYNMESH_CLIENT_CLI_VERIFY_H_
#define DYNMESH_CLIENT_CLI_VERIFY_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/io/mesh_files.h"
#include "dynmesh/feature.h"
#include "dynmesh/mesh.h"

namespace dynmesh::cli {

struct VerifyCheck {
  std::string name;
  std::uint64_t failures = 0;
  std::vector<std::string> examples;  // of the failures, the first few
};

struct VerifyReport {
  std::vector<VerifyCheck> checks;  // those made, in the order above
  int dimension = 2;
  std::uint64_t vertices = 0;
  std::uint64_t simplices = 0;
  std::uint64_t subsegments = 0;
  std::uint64_t subfacets = 0;  // in space
  double worst_radius_edge = 0;
  double min_angle_deg = 0;  // in space dihedral, as the next
  double max_angle_deg = 0;
  std::uint64_t over_rho = 0;
  std::uint64_t exempt = 0;           // of those over rho
  std::uint64_t exempt_by_guard = 0;  // of the exempt: mending would split a subsegment
  std::uint64_t below_dihedral = 0;   // in space, tetrahedra below the bound that was given
  MeshHash hash;

  bool Passed() const;
};

// `features`: what the mesh was made of; null: unknown. `min_dihedral`: in space, what no dihedral
// angle may be less than, in degrees, 0 to 20; none: there is no such check. O(n lg n).
VerifyReport VerifyMesh(const io::MeshFiles& files, double rho,
                        const std::vector<Feature>* features,
                        std::optional<double> min_dihedral = std::nullopt);

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_CLI_VERIFY_H_
