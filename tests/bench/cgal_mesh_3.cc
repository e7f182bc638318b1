// A solid meshed by CGAL's Mesh_3 (GPL, hence a benchmark): for dihedral_table.py.
//
//     dynmesh_cgal_mesh_3 INPUT.off EDGE STEM
//
// The largest closed surface bounds the solid; the others are internal facets. Edges sharper than
// 10 degrees are kept. Edges, facets and tetrahedra have the size EDGE; then the mesh is perturbed
// and exuded. Writes STEM.node and STEM.ele.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Mesh_complex_3_in_triangulation_3.h>
#include <CGAL/Mesh_criteria_3.h>
#include <CGAL/Mesh_triangulation_3.h>
#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/orientation.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/triangulate_faces.h>
#include <CGAL/Polyhedral_complex_mesh_domain_3.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/boost/graph/copy_face_graph.h>
#include <CGAL/exude_mesh_3.h>
#include <CGAL/make_mesh_3.h>
#include <CGAL/perturb_mesh_3.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace {

namespace pmp = CGAL::Polygon_mesh_processing;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Polyhedron = CGAL::Mesh_polyhedron_3<Kernel>::type;
using Domain = CGAL::Polyhedral_complex_mesh_domain_3<Kernel>;
using Triangulation = CGAL::Mesh_triangulation_3<Domain>::type;
using Complex = CGAL::Mesh_complex_3_in_triangulation_3<Triangulation, Domain::Corner_index,
                                                        Domain::Curve_index>;
using Criteria = CGAL::Mesh_criteria_3<Triangulation>;
using Surface = CGAL::Surface_mesh<Point>;

constexpr double kSharp = 10;              // degrees
constexpr double kRadius = 0.75;           // of balls, with which edges are 1 long in the mean
constexpr double kSecondsToImprove = 120;  // each of perturbing and exuding

// The closed surfaces, the largest first, each with its inside on the negative side.
std::vector<Surface> ReadSurfaces(const char* path) {
  std::ifstream file(path);
  std::vector<Point> points;
  std::vector<std::vector<std::size_t>> polygons;
  Surface all;
  if (!CGAL::IO::read_OFF(file, points, polygons) || !pmp::orient_polygon_soup(points, polygons)) {
    return {};
  }
  pmp::polygon_soup_to_polygon_mesh(points, polygons, all);
  if (!CGAL::is_closed(all) || !pmp::triangulate_faces(all)) return {};
  std::vector<Surface> parts;
  pmp::split_connected_components(all, parts);
  for (Surface& part : parts) {
    if (!pmp::is_outward_oriented(part)) pmp::reverse_face_orientations(part);
  }
  std::stable_sort(parts.begin(), parts.end(), [](const Surface& a, const Surface& b) {
    return pmp::volume(a) > pmp::volume(b);
  });
  return parts;
}

bool Write(const Complex& complex, const std::string& stem) {
  std::map<Triangulation::Vertex_handle, int> numbers;
  std::FILE* nodes = std::fopen((stem + ".node").c_str(), "w");
  std::FILE* cells = std::fopen((stem + ".ele").c_str(), "w");
  if (nodes == nullptr || cells == nullptr) return false;
  const Triangulation& triangulation = complex.triangulation();
  std::fprintf(nodes, "%zu 3 0 0\n", static_cast<std::size_t>(triangulation.number_of_vertices()));
  for (const auto v : triangulation.finite_vertex_handles()) {
    const int number = static_cast<int>(numbers.size());
    numbers[v] = number;
    const auto& p = v->point();
    std::fprintf(nodes, "%d %.17g %.17g %.17g\n", number, p.x(), p.y(), p.z());
  }
  std::fprintf(cells, "%zu 4 0\n", static_cast<std::size_t>(complex.number_of_cells_in_complex()));
  int number = 0;
  for (auto t = complex.cells_in_complex_begin(); t != complex.cells_in_complex_end(); ++t) {
    std::fprintf(cells, "%d %d %d %d %d\n", number++, numbers[t->vertex(0)], numbers[t->vertex(1)],
                 numbers[t->vertex(2)], numbers[t->vertex(3)]);
  }
  return (std::fclose(nodes) == 0) & (std::fclose(cells) == 0);
}

}  // namespace

int main(int argc, char** argv) {
  namespace parameters = CGAL::parameters;
  const double edge = argc == 4 ? std::atof(argv[2]) : 0;
  if (!(edge > 0)) {
    std::cerr << "usage: dynmesh_cgal_mesh_3 INPUT.off EDGE STEM\n";
    return 2;
  }
  const std::vector<Surface> surfaces = ReadSurfaces(argv[1]);
  if (surfaces.empty()) {
    std::cerr << argv[1] << ": no closed surfaces\n";
    return 1;
  }
  std::vector<Polyhedron> polyhedra(surfaces.size());
  std::vector<std::pair<int, int>> sides;  // inside, outside
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    CGAL::copy_face_graph(surfaces[i], polyhedra[i]);
    sides.emplace_back(static_cast<int>(i) + 1, i == 0 ? 0 : 1);
  }
  Domain domain(polyhedra.begin(), polyhedra.end(), sides.begin(), sides.end());
  domain.detect_features(kSharp);
  const double size = kRadius * edge;
  const Criteria criteria(parameters::edge_size = size, parameters::facet_angle = 25,
                          parameters::facet_size = size, parameters::facet_distance = 0.05 * size,
                          parameters::cell_radius_edge_ratio = 2, parameters::cell_size = size);
  Complex complex = CGAL::make_mesh_3<Complex>(domain, criteria, parameters::no_perturb(),
                                               parameters::no_exude());
  CGAL::perturb_mesh_3(complex, domain, parameters::time_limit = kSecondsToImprove);
  CGAL::exude_mesh_3(complex, parameters::time_limit = kSecondsToImprove);
  return Write(complex, argv[3]) ? 0 : 1;
}
