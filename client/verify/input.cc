// Checks that the input is in the mesh, and that the mesh's owners are all in the input.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "client/verify/vectors.h"
#include "client/verify/verify_internal.h"
#include "core/base/feature_kinds.h"
#include "core/base/text.h"

namespace dynmesh::cli {
namespace {

using text::Concat;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Ends = std::pair<std::uint32_t, std::uint32_t>;

class InputCheck {
 public:
  InputCheck(const io::IndexedMesh& mesh, const std::vector<Feature>& features, Chains* chains)
      : mesh_(mesh),
        features_(features),
        chains_(chains),
        tolerance_(kStraightnessUlps * LargestUlp(mesh)) {
    for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) {
      vertex_at_.emplace(PositionKeyOf(mesh.vertices[v].position(), mesh.dimension), v);
    }
    for (const auto& e : mesh.edges) {
      if (e.owner != kNoFeature && e.owner != kBoxFeature) edges_of_[e.owner].push_back(e);
    }
    for (const Feature& f : features) {
      if (IsPoint(f)) points_.emplace(f.id, &f);
    }
  }

  VerifyCheck Run() {
    for (const Feature& f : features_) {
      if (IsPoint(f)) CheckPoint(f);
    }
    for (const Joint& joint : JointsOf(features_)) wanted_[joint.feature->id].push_back(joint);
    for (const auto& [owner, wanted] : wanted_) CheckOwner(owner, wanted);
    CheckNoOther();
    return findings_.Take();
  }

 private:
  std::optional<std::uint32_t> VertexOf(const Feature& point) const {
    const auto it = vertex_at_.find(PositionKeyOf(point.position, mesh_.dimension));
    if (it == vertex_at_.end()) return std::nullopt;
    return it->second;
  }

  void CheckPoint(const Feature& f) {
    const std::optional<std::uint32_t> v = VertexOf(f);
    if (!v) {
      findings_.Add(Concat("input point ", f.id, " is no vertex"));
      return;
    }
    const auto& vertex = mesh_.vertices[*v];
    if (vertex.containing_dimension != 0 || vertex.owner != f.id) {
      findings_.Add(Concat("input point ", f.id, " is ", VertexName(*v),
                           ", which does not carry it as marker"));
    }
  }

  // Checks all joints of an owner, and that it owns nothing else.
  void CheckOwner(FeatureId owner, const std::vector<Joint>& wanted) {
    std::map<Ends, const Joint*> at;  // by vertices
    const std::size_t failures = findings_.count();
    for (const Joint& joint : wanted) {
      const auto p = points_.find(joint.from);
      const auto q = points_.find(joint.to);
      if (p == points_.end() || q == points_.end()) {
        findings_.Add(Concat(NameOf(joint), " has an end that is no input point"));
        continue;
      }
      const std::optional<std::uint32_t> from = VertexOf(*p->second);
      const std::optional<std::uint32_t> to = VertexOf(*q->second);
      if (from && to) at.emplace(std::minmax(*from, *to), &joint);  // otherwise reported already
    }
    std::set<std::uint32_t> stops;
    for (const auto& [ends, joint] : at) stops.insert({ends.first, ends.second});
    std::vector<std::vector<std::uint32_t>> others;
    for (auto& chain : ChainsOf(edges_of_[owner], stops)) {
      const auto it = at.find(std::minmax(chain.front(), chain.back()));
      if (it == at.end()) {
        others.push_back(std::move(chain));
        continue;
      }
      if (!IsStraight(chain)) {
        findings_.Add(Concat(NameOf(*it->second), " is a chain that is not straight"));
      } else if (chains_ != nullptr) {
        chains_->emplace(std::minmax(it->second->from, it->second->to), chain);
      }
      at.erase(it);
    }
    for (const auto& [ends, joint] : at) {
      findings_.Add(Concat(NameOf(*joint), " is no chain of edges with its marker, ", owner));
    }
    if (findings_.count() != failures) return;  // further failures would follow from that
    for (const auto& chain : others) {
      findings_.Add(Concat(EdgeName(chain[0], chain[1]), " has the marker ", owner,
                           ", but is on nothing that this feature joins"));
    }
  }

  static std::string NameOf(const Joint& joint) {
    if (Is<ASegment>(*joint.feature, Not<APoint, APolygon, ASize>)) {
      return Concat("input segment ", joint.feature->id);
    }
    return Concat("edge ", joint.from, " - ", joint.to, " of input polygon ", joint.feature->id);
  }

  // Cuts the graph of the edges into paths that end at `stops` and where edges end or branch. A
  // ring without any of these stays whole.
  static std::vector<std::vector<std::uint32_t>> ChainsOf(
      const std::vector<io::IndexedMesh::Edge>& edges, const std::set<std::uint32_t>& stops) {
    std::map<std::uint32_t, std::vector<std::pair<std::uint32_t, std::size_t>>> around;
    for (std::size_t i = 0; i < edges.size(); ++i) {
      around[edges[i].a].emplace_back(edges[i].b, i);
      around[edges[i].b].emplace_back(edges[i].a, i);
    }
    std::vector<bool> used(edges.size(), false);
    std::vector<std::vector<std::uint32_t>> chains;
    const auto is_stop = [&](std::uint32_t v) {
      return stops.contains(v) || around.at(v).size() != 2;
    };
    const auto follow = [&](std::uint32_t start) {
      for (const auto& [first, edge] : around.at(start)) {
        if (used[edge]) continue;
        used[edge] = true;
        std::vector<std::uint32_t> chain = {start, first};
        while (!is_stop(chain.back()) && chain.back() != start) {
          const auto& two = around.at(chain.back());
          const auto& [next, along] = used[two[0].second] ? two[1] : two[0];
          if (used[along]) break;  // a duplicate edge
          used[along] = true;
          chain.push_back(next);
        }
        chains.push_back(std::move(chain));
      }
    };
    for (const auto& [v, ends] : around) {
      if (is_stop(v)) follow(v);
    }
    for (const auto& [v, ends] : around) follow(v);
    return chains;
  }

  Kernel::Point_3 At(std::uint32_t v) const {
    return {mesh_.vertices[v].x, mesh_.vertices[v].y, mesh_.vertices[v].z};
  }

  // True if every step goes forward (exactly) and no vertex is off the line by more than rounding.
  bool IsStraight(const std::vector<std::uint32_t>& chain) const {
    const auto from = [&](std::uint32_t v) {
      const auto &p = mesh_.vertices[chain.front()], &q = mesh_.vertices[v];
      return std::array<Real, 3>{Real{q.x} - p.x, Real{q.y} - p.y, Real{q.z} - p.z};
    };
    const std::array<Real, 3> d = from(chain.back());
    const Real length = std::hypot(d[0], d[1], d[2]);
    for (std::size_t i = 1; i < chain.size(); ++i) {
      if (CGAL::angle(At(chain.front()), At(chain.back()), At(chain[i - 1]), At(chain[i])) !=
          CGAL::ACUTE) {
        return false;
      }
      const std::array<Real, 3> v = from(chain[i]);
      const Real off = std::hypot(d[1] * v[2] - d[2] * v[1], d[2] * v[0] - d[0] * v[2],
                                  d[0] * v[1] - d[1] * v[0]) /
                       length;
      if (!(off <= tolerance_)) return false;
    }
    return true;
  }

  void CheckNoOther() {
    for (std::uint32_t v = 0; v < mesh_.vertices.size(); ++v) {
      const auto& vertex = mesh_.vertices[v];
      if (vertex.containing_dimension != 0 || vertex.owner == kBoxFeature) continue;
      const auto it = points_.find(vertex.owner);
      if (it == points_.end()) {
        findings_.Add(
            Concat(VertexName(v), " has the marker ", vertex.owner, ", which is no input point"));
      } else if (VertexOf(*it->second) != v) {
        findings_.Add(Concat(VertexName(v), " has the marker ", vertex.owner,
                             ", but that point is elsewhere"));
      }
    }
    for (const auto& [id, edges] : edges_of_) {
      if (edges.empty() || wanted_.contains(id)) continue;
      findings_.Add(Concat(EdgeName(edges.front().a, edges.front().b), " has the marker ", id,
                           ", which is no input segment and no polygon's"));
    }
  }

  const io::IndexedMesh& mesh_;
  const std::vector<Feature>& features_;
  Chains* const chains_;
  const double tolerance_;
  absl::flat_hash_map<PositionKey, std::uint32_t> vertex_at_;
  std::map<FeatureId, std::vector<io::IndexedMesh::Edge>> edges_of_;
  std::map<FeatureId, std::vector<Joint>> wanted_;  // by owner
  absl::flat_hash_map<FeatureId, const Feature*> points_;
  Findings findings_{"input"};
};

}  // namespace

std::vector<Joint> JointsOf(const std::vector<Feature>& features) {
  std::vector<Joint> joints;
  std::set<std::pair<FeatureId, FeatureId>> joined;
  std::vector<const Feature*> polygons;
  for (const Feature& f : features) {
    if (Is<APolygon>(f, Not<APoint, ASegment, ASize>)) polygons.push_back(&f);
    if (!Is<ASegment>(f, Not<APoint, APolygon, ASize>)) continue;
    joined.insert(std::minmax(f.ends[0], f.ends[1]));
    joints.push_back({&f, f.ends[0], f.ends[1]});
  }
  std::sort(polygons.begin(), polygons.end(),
            [](const Feature* f, const Feature* g) { return f->id < g->id; });
  for (const Feature* f : polygons) {
    for (const auto& ring : f->rings) {
      for (std::size_t i = 0; i < ring.size(); ++i) {
        const FeatureId from = ring[i], to = ring[(i + 1) % ring.size()];
        if (joined.insert(std::minmax(from, to)).second) joints.push_back({f, from, to});
      }
    }
  }
  return joints;
}

PositionKey PositionKeyOf(const std::array<double, 3>& p, int dimension) {
  PositionKey key = {};
  for (std::size_t k = 0; k < static_cast<std::size_t>(dimension); ++k) {
    key[k] = std::bit_cast<std::uint64_t>(p[k] + 0.0);
  }
  return key;
}

VerifyCheck CheckInput(const io::IndexedMesh& mesh, const std::vector<Feature>& features,
                       Chains* chains) {
  return InputCheck(mesh, features, chains).Run();
}

}  // namespace dynmesh::cli
