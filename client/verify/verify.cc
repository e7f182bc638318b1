#include "client/verify/verify.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <tuple>
#include <utility>

#include "client/verify/verify_internal.h"
#include "core/base/feature_kinds.h"
#include "core/base/text.h"

namespace dynmesh::cli {
namespace {

using text::Concat;

VerifyCheck CheckHash(const io::MeshFiles& files, const MeshHash& hash) {
  Findings findings("hash");
  if (*files.recorded_hash != hash) {
    findings.Add(Concat("the file records ", files.recorded_hash->ToHex(), ", its content has ",
                        hash.ToHex()));
  }
  return findings.Take();
}

bool IsFinite(const io::IndexedMesh::Vertex& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

bool AllFinite(const io::IndexedMesh& mesh) {
  return std::all_of(mesh.vertices.begin(), mesh.vertices.end(),
                     [](const auto& v) { return IsFinite(v); });
}

}  // namespace

std::string VertexName(std::uint32_t vertex) { return Concat("vertex ", vertex + 1); }

std::string EdgeName(std::uint32_t a, std::uint32_t b) {
  return Concat("edge ", a + 1, "-", b + 1);
}

std::string FaceName(const std::array<std::uint32_t, 3>& v) {
  return Concat("face ", v[0] + 1, "-", v[1] + 1, "-", v[2] + 1);
}

std::string TetrahedronName(std::uint32_t tetrahedron) {
  return Concat("tetrahedron ", tetrahedron + 1);
}

std::string TriangleName(std::uint32_t triangle) { return Concat("triangle ", triangle + 1); }

double LargestUlp(const io::IndexedMesh& mesh) {
  double largest = 0;
  for (const auto& v : mesh.vertices) {
    largest = std::max({largest, std::abs(v.x), std::abs(v.y), std::abs(v.z)});
  }
  return std::nextafter(largest, HUGE_VAL) - largest;
}

std::vector<Side> CollectSides(const io::IndexedMesh& mesh) {
  std::vector<Side> sides;
  sides.reserve(3 * mesh.triangles.size());
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::uint8_t k = 0; k < 3; ++k) {
      const std::uint32_t from = mesh.triangles[t][k];
      const std::uint32_t to = mesh.triangles[t][(k + 1U) % 3];
      sides.push_back({std::min(from, to), std::max(from, to), t, k, from < to});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const Side& s, const Side& t) {
    return std::tie(s.a, s.b, s.triangle, s.k) < std::tie(t.a, t.b, t.triangle, t.k);
  });
  return sides;
}

VerifyCheck CheckVertices(const io::IndexedMesh& mesh) {
  Findings findings("vertices");
  const auto n = static_cast<std::uint32_t>(mesh.vertices.size());
  if (n == 0) findings.Add("there is none");
  for (std::uint32_t i = 0; i < n; ++i) {
    if (!IsFinite(mesh.vertices[i])) {
      findings.Add(VertexName(i) + " is not finite");
    }
  }
  std::vector<std::uint32_t> order(n);
  std::iota(order.begin(), order.end(), 0U);
  const auto position = [&](std::uint32_t i) { return mesh.vertices[i].position(); };
  std::sort(order.begin(), order.end(), [&](std::uint32_t i, std::uint32_t j) {
    return std::tuple(position(i), i) < std::tuple(position(j), j);
  });
  for (std::uint32_t i = 1; i < n; ++i) {
    if (position(order[i - 1]) == position(order[i])) {
      findings.Add(VertexName(order[i]) + " is in the place of " + VertexName(order[i - 1]));
    }
  }
  std::vector<bool> used(n, false);
  ForEachSimplex(mesh, [&](const auto& corners) {
    for (const std::uint32_t v : corners) used[v] = true;
  });
  for (std::uint32_t i = 0; i < n; ++i) {
    if (!used[i])
      findings.Add(VertexName(i) +
                   (mesh.dimension == 3 ? " is in no tetrahedron" : " is in no triangle"));
  }
  return findings.Take();
}

bool VerifyReport::Passed() const {
  return std::all_of(checks.begin(), checks.end(),
                     [](const VerifyCheck& check) { return check.failures == 0; });
}

namespace {

void CheckPlane(const io::MeshFiles& files, double rho, const std::vector<Feature>* features,
                MeshScope scope, bool judges_rho, VerifyReport& report) {
  const io::IndexedMesh& mesh = files.mesh;
  const std::vector<Side> sides = CollectSides(mesh);
  const bool is_whole = scope == MeshScope::kWhole;
  report.checks.push_back(CheckManifold(mesh, sides, is_whole));
  report.checks.push_back(is_whole ? CheckBox(mesh, sides) : CheckOverlap(mesh, sides));
  report.checks.push_back(CheckDelaunay(mesh, sides, files.is_triangulation));
  if (scope != MeshScope::kForeign) {
    report.checks.push_back(CheckEdges(files, EdgesOf(sides), is_whole));
  }
  VerifyCheck quality = CheckQuality(mesh, rho, report, features);
  if (!files.is_triangulation || judges_rho) report.checks.push_back(std::move(quality));
}

void CheckSpace(const io::MeshFiles& files, const std::vector<Face>& faces, double rho,
                MeshScope scope, VerifyReport& report) {
  const io::IndexedMesh& mesh = files.mesh;
  const bool is_whole = scope == MeshScope::kWhole;
  report.checks.push_back(CheckManifold(mesh, faces));
  report.checks.push_back(is_whole ? CheckBox(mesh, faces) : CheckOverlap(mesh, faces));
  report.checks.push_back(CheckDelaunay(mesh, faces));
  if (scope != MeshScope::kForeign) {
    report.checks.push_back(CheckEdges(files, EdgesOf(mesh, faces), is_whole));
    report.checks.push_back(CheckFaces(files, faces));
  }
  report.checks.push_back(CheckSpaceQuality(mesh, rho, report));
}

// Of another mesher nothing is promised but a mesh: what it is else is told.
void ForgiveForeign(bool judges_rho, VerifyReport& report) {
  std::erase_if(report.checks, [&](const VerifyCheck& check) {
    if (check.name == "delaunay") report.not_delaunay = check.failures;
    return check.name == "delaunay" || (check.name == "quality" && !judges_rho);
  });
}

void CheckFeatures(const io::MeshFiles& files, const std::vector<Face>& faces,
                   const std::vector<Feature>& features, MeshScope scope, VerifyReport& report) {
  const io::IndexedMesh& mesh = files.mesh;
  const bool is_whole = scope == MeshScope::kWhole;
  const bool in_space = mesh.dimension == 3;
  Chains chains;
  report.checks.push_back(is_whole ? CheckInput(mesh, features, &chains)
                                   : CheckPartInput(mesh, features, files.has_edges));
  const auto is_size = [](const Feature& f) {
    return Is<ASize>(f, Not<APoint, ASegment, APolygon>);
  };
  if (!in_space && std::ranges::any_of(features, &Feature::unsplit)) {
    report.checks.push_back(CheckUnsplit(mesh, CollectSides(mesh), features));
  }
  if (std::ranges::any_of(features, is_size)) {
    report.checks.push_back(CheckSizes(mesh, features));
  }
  if (files.has_input_markers) return;  // regions are attributes of the input's seeds
  if (!in_space) {
    report.checks.push_back(CheckRegions(mesh, features));
  } else if (is_whole) {
    report.checks.push_back(CheckFacets(mesh, features, chains));
    report.checks.push_back(CheckRegions(mesh, faces, features));
  }
}

}  // namespace

VerifyReport VerifyMesh(const io::MeshFiles& files, double rho,
                        const std::vector<Feature>* features, std::optional<double> min_dihedral,
                        MeshScope scope, bool judges_rho) {
  const io::IndexedMesh& mesh = files.mesh;
  const bool in_space = mesh.dimension == 3;
  VerifyReport report;
  report.dimension = mesh.dimension;
  report.vertices = mesh.vertices.size();
  report.simplices = mesh.simplex_count();
  report.subsegments = mesh.subsegment_count();
  report.subfacets = mesh.subfacet_count();
  report.hash = io::ToMesh(mesh).hash;
  report.checks.push_back(CheckVertices(mesh));
  // Exact predicates do not support NaN. Files cannot contain one, but callers might pass one.
  if (!AllFinite(mesh)) return report;
  report.checks.push_back(CheckOrientation(mesh));
  const std::vector<Face> faces = in_space ? CollectFaces(mesh) : std::vector<Face>();
  if (in_space) {
    CheckSpace(files, faces, rho, scope, report);
    if (min_dihedral) report.checks.push_back(CheckDihedral(mesh, *min_dihedral, report));
  } else {
    CheckPlane(files, rho, features, scope, judges_rho, report);
  }
  if (scope == MeshScope::kForeign) {
    ForgiveForeign(judges_rho, report);
    return report;
  }
  if (files.recorded_hash) report.checks.push_back(CheckHash(files, report.hash));
  if (features != nullptr) CheckFeatures(files, faces, *features, scope, report);
  return report;
}

}  // namespace dynmesh::cli
