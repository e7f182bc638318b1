#include "client/cleaning/feature_edges.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "client/cleaning/box3.h"
#include "client/cleaning/collapses.h"
#include "client/cleaning/contact_index.h"
#include "client/cleaning/patch_mesh.h"
#include "client/cleaning/patch_rules.h"
#include "client/cleaning/surface.h"
#include "client/cleaning/surface_polygons.h"
#include "core/base/feature_kinds.h"
#include "core/base/text.h"

namespace dynmesh::cleaning {
namespace {

using text::Concat;

// The default distance, of the diagonal.
constexpr double kDefaultWithin = 0.001;

class Simplifier {
 public:
  Simplifier(const std::vector<Feature>& features, const FeatureEdgeOptions& options)
      : features_(features), options_(options), field_(options.tolerance), surface_(field_) {}

  FeatureEdgeResult Run() {
    std::vector<Point3> points = EnterNodes();
    const std::size_t count = points.size();
    std::vector<PatchFace> faces = Triangulate();
    FeatureEdgeResult result;
    result.triangles_before = faces.size();
    std::vector<NodePair> segments;
    for (const Feature& f : features_) {
      if (!Is<ASegment>(f, Not<APoint, APolygon, ASize>)) continue;
      segments.push_back(Ordered(node_of_.at(f.ends[0]), node_of_.at(f.ends[1])));
    }
    std::sort(segments.begin(), segments.end());
    std::vector<bool> is_face_corner(count, false), is_used(count, false);
    for (const PatchFace& face : faces) {
      for (const Node v : face.v) is_face_corner[v] = is_used[v] = true;
    }
    std::vector<ContactElement> obstacles;
    for (const NodePair& e : segments) {
      obstacles.push_back({{e.first, e.second, 0}, 2});
      is_used[e.first] = is_used[e.second] = true;
    }
    for (Node v = 0; v < count; ++v) {
      if (!is_used[v]) obstacles.push_back({{v, 0, 0}, 1});
    }
    PatchMesh mesh(std::move(points), std::move(faces), segments, DeviationLimit(options_.angle));
    PatchRules rules(mesh, obstacles, {options_.angle, options_.within, options_.tolerance});
    is_dropped_.assign(count, false);
    for (const Node v : Collapses(mesh, rules).Run()) {
      is_dropped_[v] = true;
      result.changes.push_back(
          {SurfaceChangeKind::kPointDropped, {surface_.point_ids[v]}, mesh.at(v), mesh.at(v)});
    }
    result.sharp_edges = mesh.sharp_count();
    for (Node v = 0; v < count; ++v) {
      if (is_face_corner[v] && mesh.IsCorner(v)) ++result.corners;
    }
    Write(mesh, result);
    return result;
  }

 private:
  // In the order of coordinates, which are all different.
  std::vector<Point3> EnterNodes() {
    std::vector<const Feature*> order;
    for (const Feature& f : features_) {
      if (IsPoint(f)) order.push_back(&f);
      next_id_ = std::max(next_id_, f.id + 1);
    }
    std::sort(order.begin(), order.end(),
              [](const Feature* a, const Feature* b) { return a->position < b->position; });
    std::vector<Point3> points;
    for (const Feature* f : order) {
      points.push_back(f->position);
      node_of_[f->id] = surface_.AddNode(f->position, f->id);
    }
    return points;
  }

  std::vector<PatchFace> Triangulate() {
    std::vector<PatchFace> faces;
    for (const Feature& f : features_) {
      if (!Is<APolygon>(f, Not<APoint, ASegment, ASize>)) continue;
      std::vector<NodeRing> rings;
      for (const auto& ring : f.rings) {
        NodeRing& nodes = rings.emplace_back();
        for (const FeatureId corner : ring) nodes.push_back(node_of_.at(corner));
      }
      const std::size_t group = options_.group ? options_.group(f.id) : 0;
      const PolygonPieces pieces = PiecesOf(surface_, rings, options_.tolerance);
      pieces_of_[f.id] = pieces.triangles.size();
      for (const auto& t : pieces.triangles) {
        PatchFace face;
        face.Orient(t[0], t[1], t[2]);
        face.group = static_cast<std::uint32_t>(group);
        face.source = f.id;
        faces.push_back(face);
      }
    }
    std::sort(faces.begin(), faces.end(),
              [](const PatchFace& a, const PatchFace& b) { return a.v < b.v; });
    return faces;
  }

  std::vector<FeatureId> CornersOf(const PatchFace& face) const {
    const std::size_t second = face.is_flipped ? 2 : 1;
    return {surface_.point_ids[face.v[0]], surface_.point_ids[face.v[second]],
            surface_.point_ids[face.v[3 - second]]};
  }

  void Write(const PatchMesh& mesh, FeatureEdgeResult& result) {
    absl::flat_hash_map<FeatureId, std::vector<const PatchFace*>> parts;
    for (const PatchFace& face : mesh.faces()) {
      if (face.is_alive) parts[face.source].push_back(&face);
    }
    for (const Feature& f : features_) {
      if (!Is<APolygon>(f, Not<APoint, ASegment, ASize>)) {
        if (!IsPoint(f) || !is_dropped_[node_of_.at(f.id)]) result.features.push_back(f);
        continue;
      }
      const auto it = parts.find(f.id);
      if (it == parts.end()) continue;
      const std::vector<const PatchFace*>& left = it->second;
      result.triangles += left.size();
      if (left.size() == pieces_of_.at(f.id) && (options_.holes || f.rings.size() == 1) &&
          std::none_of(left.begin(), left.end(),
                       [](const PatchFace* p) { return p->is_changed; })) {
        result.features.push_back(f);
        continue;
      }
      for (const PatchFace* face : left) {
        const FeatureId id = face == left.front() ? f.id : next_id_++;
        if (id != f.id) result.parts.emplace_back(id, f.id);
        result.features.push_back(Feature::Polygon(id, {CornersOf(*face)}));
      }
    }
  }

  const std::vector<Feature>& features_;
  const FeatureEdgeOptions& options_;
  ToleranceField field_;
  Surface surface_;
  std::vector<bool> is_dropped_;
  absl::flat_hash_map<FeatureId, Node> node_of_;
  absl::flat_hash_map<FeatureId, std::size_t> pieces_of_;
  FeatureId next_id_ = 1;
};

}  // namespace

double DefaultWithin(const std::vector<Feature>& features) {
  absl::flat_hash_map<FeatureId, const Point3*> at;
  for (const Feature& f : features) {
    if (IsPoint(f)) at[f.id] = &f.position;
  }
  std::optional<Box3> box;
  for (const Feature& f : features) {
    if (!Is<APolygon>(f, Not<APoint, ASegment, ASize>)) continue;
    for (const auto& ring : f.rings) {
      for (const FeatureId corner : ring) {
        const Box3 here = {*at.at(corner), *at.at(corner)};
        if (!box) box = here;
        box->Add(here);
      }
    }
  }
  return box ? kDefaultWithin * std::sqrt(SquaredDistance<3>(box->lo, box->hi)) : 0;
}

absl::StatusOr<FeatureEdgeResult> KeepFeatureEdges(const std::vector<Feature>& features,
                                                   const FeatureEdgeOptions& options) {
  if (!(options.angle >= kLeastFeatureAngle && options.angle <= kMostFeatureAngle)) {
    return absl::InvalidArgumentError(Concat("the angle of feature edges must be from ",
                                             kLeastFeatureAngle, " to ", kMostFeatureAngle,
                                             " degrees, found ", options.angle));
  }
  if (!(options.within > 0) || !std::isfinite(options.within)) {
    return absl::InvalidArgumentError(
        Concat("the distance from the surface must be above 0, found ", options.within));
  }
  return Simplifier(features, options).Run();
}

}  // namespace dynmesh::cleaning
