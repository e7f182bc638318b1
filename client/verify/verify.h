// Checks of a mesh file, independent of the mesher: only core/io is shared with it. Predicates are
// exact (CGAL's kernel). All else is implemented again, so that an error of the mesher is not
// repeated here.
//
// Checks, by name:
//   vertices     finite (else no further checks), distinct positions, each a corner of a
//                triangle
//   orientation  every triangle is counter-clockwise, exactly
//   manifold     every edge has one or two triangles, one per side; the triangles around every
//                vertex form one fan; all are connected; V - E + T = 1
//   box          the border is a rectangle, traversed once. With the two checks above: the
//                triangles cover it once, without gap or overlap
//   delaunay     no vertex inside the circle of a triangle beyond one of its edges, exactly; by
//                Delaunay's lemma then none inside any circle. Of a triangulation without Steiner
//                points subsegments block the view: the other edges are tested
//   edges        the .edge file has every edge once and no other; -1 marks exactly the border's
//                edges and vertices
//   quality      no triangle over rho, except exempt ones
//   hash         the recorded hash is that of the file's content
//   input        (if given) every input point is a vertex with its id as marker, bit for bit;
//                every segment is a straight chain of edges with its id from one end to the other;
//                so is every edge of a polygon, with the id of the segment with the same ends, else
//                of the first polygon that has it; no other ids occur. Straight: each step goes
//                forward along the segment, exactly, and no vertex is more than 16 ulps of the
//                largest coordinate from its line. Vertices of other segments may be nearer than
//                that: markers, not distances, tell the chains apart
//   unsplit      (if the input is given and something in it is unsplit) every such segment, and
//                edge of a polygon, is one edge; no vertex is in the circle over it, exactly
//   sizes        (if the input is given and has sizing features) no edge of a triangle that meets
//                a region by more than rounding is longer than sqrt 2 times the target, but for
//                triangles that unsplit segments excuse
//   regions      (if the input is given) every triangle has the polygons around it, tested
//                exactly at a point inside it
// In 3D the same for tetrahedra, except
//   manifold     every face has one or two tetrahedra, one per side
//   box          the border is on the sides of a box, and the volumes sum up to the box's. With
//                the two checks above every point is in equally many tetrahedra, as their number
//                does not change across a face; by the volume this number is 1
//   delaunay     no vertex inside the sphere of a tetrahedron beyond one of its faces
//   edges        -1 only on the border's edges
//   faces        the .face file has every subfacet and every other border face once, and no
//                other; -1 marks exactly the border's; all are faces of tetrahedra
//   facets       (if the input is given) the subfacets of every polygon cover it exactly once,
//                flat except for rounding; no other face has its marker. They are one sheet: of
//                a nearly flat tetrahedron with all corners on a polygon, one side counts
//   regions      (if the input is given) every tetrahedron has the closed surfaces around it, by
//                flood fill across all faces that are not subfacets
//   dihedral     (if a bound is given) no smaller dihedral angle, exactly if close to the bound;
//                without exemptions for small input angles
// A part of a mesh (MeshScope::kPart) has no box and need not be a disc: instead of box and the
// sum of manifold there is
//   overlap      no vertex lies in a simplex that does not have it, and no two sides of the border
//                cross: so no place is covered twice
// and of the input what lies in the part: positions of points; segments and edges of polygons as
// chains, which end where they leave the part; sizes and, in 2D, regions. Of a file with the
// input's markers no regions are known. A mesh of another mesher (kForeign) has vertices,
// orientation, manifold, overlap and, if a rho is given, quality. What is not Delaunay is counted
// only.
#ifndef DYNMESH_CLIENT_VERIFY_VERIFY_H_
#define DYNMESH_CLIENT_VERIFY_VERIFY_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/io/meshes/mesh_files.h"
#include "dynmesh/feature.h"
#include "dynmesh/mesh.h"

namespace dynmesh::cli {

enum class MeshScope : std::uint8_t { kWhole, kPart, kForeign };

struct VerifyCheck {
  std::string name;
  std::uint64_t failures = 0;
  std::vector<std::string> examples;  // the first few failures
};

struct VerifyReport {
  std::vector<VerifyCheck> checks;  // the checks made, in the order above
  int dimension = 2;
  std::uint64_t vertices = 0;
  std::uint64_t simplices = 0;
  std::uint64_t subsegments = 0;
  std::uint64_t subfacets = 0;  // in 3D
  double worst_radius_edge = 0;
  double min_angle_deg = 0;  // in 3D dihedral, as max_angle_deg
  double max_angle_deg = 0;
  std::uint64_t over_rho = 0;
  std::uint64_t exempt = 0;           // of the triangles over rho
  std::uint64_t exempt_by_guard = 0;  // of the exempt: repairing them would split a subsegment
  std::uint64_t exempt_by_unsplit =
      0;                              // ... would put a vertex in the circle of an unsplit segment
  std::uint64_t below_dihedral = 0;   // in 3D, tetrahedra below the given bound
  std::uint64_t exempt_dihedral = 0;  // below it at excused angles alone; not among those
  std::uint64_t not_delaunay = 0;     // sides, of a foreign mesh
  MeshHash hash;

  bool Passed() const;
};

// `rho` is measured against; of a foreign mesh and of kind triangulation it is judged only if
// `judges_rho`. `features`: the
// mesh's input; null: unknown. `min_dihedral`: in 3D, the least dihedral angle in degrees, 0 to 20;
// none: no such check. O(n lg n).
VerifyReport VerifyMesh(const io::MeshFiles& files, double rho,
                        const std::vector<Feature>* features,
                        std::optional<double> min_dihedral = std::nullopt,
                        MeshScope scope = MeshScope::kWhole, bool judges_rho = true);

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_VERIFY_VERIFY_H_
