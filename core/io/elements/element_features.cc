// Elements as features and seeds.
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "absl/container/flat_hash_map.h"
#include "core/base/union_find.h"
#include "core/coplanar/facet_rings.h"
#include "core/io/elements/element_mesh.h"
#include "core/mesh_data/point_location.h"

namespace dynmesh::io {
namespace {

using geometry::Point;

template <int D>
using Side = std::array<std::uint32_t, D>;

template <int D>
class FeatureMaker {
 public:
  FeatureMaker(const ElementMesh& mesh, ElementVertices vertices)
      : mesh_(mesh), vertices_(vertices) {}

  FileFeatures Make() {
    FindConstraints();
    NumberPoints();
    AddLines();
    AddFaces();
    NamePoints();
    if (AreInDomain()) {
      AddRegions();
      AddHoles();
    }
    return std::move(input_);
  }

 private:
  struct Constraint {
    std::int64_t marker;
    int line;
  };

  const auto& simplices() const {
    if constexpr (D == 2) {
      return mesh_.triangles;
    } else {
      return mesh_.tetrahedra;
    }
  }
  const auto& given_sides() const {
    if constexpr (D == 2) {
      return mesh_.segments;
    } else {
      return mesh_.triangles;
    }
  }

  // Opposite to corner k.
  static Side<D> SideOf(const Element<D + 1>& element, std::size_t k) {
    Side<D> side;
    std::size_t count = 0;
    for (std::size_t j = 0; j <= D; ++j) {
      if (j != k) side[count++] = element.corners[j];
    }
    std::sort(side.begin(), side.end());
    return side;
  }

  void FindConstraints() {
    for (const auto& element : given_sides()) {
      Side<D> side = element.corners;
      std::sort(side.begin(), side.end());
      AddConstraint(side, {element.marker, element.line});
    }
    given_ = order_.size();
    // The simplices of each side, in the order of sides.
    std::vector<std::pair<Side<D>, std::size_t>> sides;
    for (std::size_t i = 0; i < simplices().size(); ++i) {
      for (std::size_t k = 0; k <= D; ++k) sides.emplace_back(SideOf(simplices()[i], k), i);
    }
    std::sort(sides.begin(), sides.end());
    parts_.emplace(simplices().size());
    for (std::size_t i = 0; i < sides.size();) {
      std::size_t end = i;
      while (end < sides.size() && sides[end].first == sides[i].first) ++end;
      const auto& first = simplices()[sides[i].second];
      const bool is_border = end - i == 1;
      const bool divides = is_border || simplices()[sides[end - 1].second].marker != first.marker;
      if (is_border) border_.emplace_back(sides[i].first, sides[i].second);
      if (divides) AddConstraint(sides[i].first, {0, first.line});
      if (!constraint_of_.contains(sides[i].first)) {
        parts_->Unite(sides[i].second, sides[end - 1].second);
      }
      i = end;
    }
  }

  void AddConstraint(const Side<D>& side, const Constraint& constraint) {
    if (!constraint_of_.emplace(side, constraint).second) return;
    order_.push_back(side);
  }

  void NumberPoints() {
    std::vector<bool> used(mesh_.positions.size(), vertices_ == ElementVertices::kAll);
    const bool has_elements = !order_.empty() || !mesh_.segments.empty();
    for (const Side<D>& side : order_) {
      for (const std::uint32_t v : side) used[v] = true;
    }
    if (D == 3) {
      for (const auto& line : mesh_.segments) used[line.corners[0]] = used[line.corners[1]] = true;
    }
    for (const auto& point : mesh_.points) {
      if (point.marker != 0 || !has_elements) used[point.corners[0]] = true;
    }
    id_of_.assign(mesh_.positions.size(), kNoFeature);
    input_.point_file = input_.segment_file = mesh_.file;
    for (std::size_t v = 0; v < used.size(); ++v) {
      if (!used[v]) continue;
      id_of_[v] = ++last_id_;
      const auto& [x, y, z] = mesh_.positions[v];
      input_.features.push_back(Feature::Point(last_id_, x + 0.0, y + 0.0, D == 3 ? z + 0.0 : 0.0));
      input_.lines.push_back(mesh_.lines[v]);
    }
    input_.point_count = input_.features.size();
    input_.labels.attributes = mesh_.attributes;
    for (std::size_t v = 0; v < used.size() && mesh_.attributes != 0; ++v) {
      const auto first = mesh_.values.begin() + static_cast<std::ptrdiff_t>(v * mesh_.attributes);
      if (used[v]) {
        input_.labels.values.insert(input_.labels.values.end(), first,
                                    first + static_cast<std::ptrdiff_t>(mesh_.attributes));
      }
    }
  }

  // The next feature and those after it are in `other`, if it has a name.
  void Continue(const std::string& other) {
    input_.files_from[last_id_ + 1] = ElementMesh::Or(other, mesh_.file);
  }

  void Label(int dimension, std::int64_t marker) { LabelOf(last_id_, dimension, marker); }

  void LabelOf(FeatureId id, int dimension, std::int64_t marker) {
    if (marker == 0) return;
    input_.labels.markers[id] = marker;
    const auto name = mesh_.names.find({dimension, marker});
    if (name != mesh_.names.end()) input_.labels.names[id] = name->second;
  }

  void AddSegment(std::uint32_t a, std::uint32_t b, const Constraint& constraint) {
    input_.features.push_back(Feature::Segment(++last_id_, id_of_[a], id_of_[b]));
    input_.lines.push_back(constraint.line);
    ++input_.segment_count;
    Label(1, constraint.marker);
  }

  void AddLines() {
    Continue(mesh_.segment_file);
    if constexpr (D == 2) {
      for (std::size_t i = 0; i < order_.size(); ++i) {
        if (i == given_) Continue(mesh_.triangle_file);
        AddSegment(order_[i][0], order_[i][1], constraint_of_.at(order_[i]));
      }
    } else {
      // Lines that are edges of faces need no segment but for their marker.
      std::set<std::array<std::uint32_t, 2>> of_faces, added;
      for (const Side<3>& side : order_) {
        for (std::size_t k = 0; k < 3; ++k) {
          const auto [a, b] = std::minmax(side[k], side[(k + 1) % 3]);
          of_faces.insert({a, b});
        }
      }
      for (const auto& line : mesh_.segments) {
        const auto [a, b] = std::minmax(line.corners[0], line.corners[1]);
        if (line.marker == 0 && of_faces.contains({a, b})) continue;
        if (added.insert({a, b}).second) AddSegment(a, b, {line.marker, line.line});
      }
    }
  }

  void AddFaces() {
    if constexpr (D == 3) {
      Continue(mesh_.triangle_file);
      for (std::size_t i = 0; i < order_.size(); ++i) {
        if (i == given_) Continue(mesh_.tetrahedron_file);
        const Side<3>& side = order_[i];
        const Constraint& constraint = constraint_of_.at(side);
        input_.features.push_back(
            Feature::Polygon(++last_id_, {{id_of_[side[0]], id_of_[side[1]], id_of_[side[2]]}}));
        input_.lines.push_back(constraint.line);
        Label(2, constraint.marker);
      }
    }
  }

  void NamePoints() {
    for (const auto& point : mesh_.points) {
      const FeatureId id = id_of_[point.corners[0]];
      if (id != kNoFeature) LabelOf(id, 0, point.marker);
    }
  }

  bool AreInDomain() const {
    return std::ranges::all_of(mesh_.positions,
                               [](const auto& p) { return coplanar::IsInDomain(p); });
  }

  Point<D> PointOf(std::uint32_t v) const {
    Point<D> p;
    for (std::size_t k = 0; k < D; ++k) p.c[k] = mesh_.positions[v][k];
    return p;
  }

  // Positively oriented.
  std::array<Point<D>, D + 1> CornersOf(std::size_t simplex) const {
    std::array<Point<D>, D + 1> corners;
    for (std::size_t k = 0; k <= D; ++k) corners[k] = PointOf(simplices()[simplex].corners[k]);
    int sign = 0;
    if constexpr (D == 2) {
      sign = geometry::Orientation(corners[0], corners[1], corners[2]);
    } else {
      sign = geometry::Orientation(corners[0], corners[1], corners[2], corners[3]);
    }
    if (sign < 0) std::swap(corners[0], corners[1]);
    return corners;
  }

  static double SizeOf(const std::array<Point<D>, D + 1>& c) {
    double least = HUGE_VAL;  // a measure of size that is 0 for the flat, not a volume
    for (std::size_t i = 0; i <= D; ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        least = std::min(least, geometry::SquaredDistance(c[i], c[j]));
      }
    }
    return least;
  }

  static SeedRow SeedAt(const Point<D>& p) {
    SeedRow row;
    for (std::size_t k = 0; k < D; ++k) row.position[k] = p.c[k];
    return row;
  }

  void AddRegions() {
    std::map<std::size_t, std::pair<double, std::size_t>> best;  // by part: size and simplex
    for (std::size_t i = 0; i < simplices().size(); ++i) {
      if (simplices()[i].marker == 0) continue;
      const double size = SizeOf(CornersOf(i));
      auto& entry = best[parts_->Find(i)];
      if (size > entry.first) entry = {size, i};
    }
    for (const auto& [part, entry] : best) {
      if (entry.first == 0) continue;
      const auto corners = CornersOf(entry.second);
      Point<D> centre{};
      for (std::size_t k = 0; k < D; ++k) {
        for (const Point<D>& corner : corners) centre.c[k] += corner.c[k] / (D + 1);
      }
      SeedRow row = SeedAt(centre);
      const std::int64_t marker = simplices()[entry.second].marker;
      const auto fraction = mesh_.fractions.find(marker);
      row.more = {fraction == mesh_.fractions.end() ? static_cast<double>(marker)
                                                    : fraction->second};
      const auto name = mesh_.names.find({D, marker});
      if (name != mesh_.names.end()) row.name = name->second;
      input_.regions.push_back(std::move(row));
    }
  }

  // Just beyond a side of each part of the border, where no simplex is.
  void AddHoles() {
    UnionFind joined(border_.size());
    absl::flat_hash_map<std::uint32_t, std::size_t> first_at;
    for (std::size_t i = 0; i < border_.size(); ++i) {
      for (const std::uint32_t v : border_[i].first) {
        joined.Unite(i, first_at.emplace(v, i).first->second);
      }
    }
    std::vector<std::size_t> open;
    for (std::size_t i = 0; i < border_.size(); ++i) {
      if (joined.Find(i) == i) open.push_back(i);
    }
    std::map<std::size_t, Point<D>> seeds;  // by side of the border
    constexpr int kRounds = 40;
    double step = 0x1p-6;
    for (int round = 0; round < kRounds && !open.empty(); ++round, step /= 2) {
      std::vector<Point<D>> tried;
      for (const std::size_t i : open) tried.push_back(Beyond(border_[i], step));
      std::vector<bool> covered(open.size(), false);
      mesh_data::ForEachContaining<D>(
          simplices().size(), [&](std::size_t row) { return CornersOf(row); },
          std::span<const Point<D>>(tried), [&](std::size_t, std::size_t i) { covered[i] = true; });
      std::vector<std::size_t> rest;
      for (std::size_t i = 0; i < open.size(); ++i) {
        if (covered[i]) {
          rest.push_back(open[i]);
        } else {
          seeds.emplace(open[i], tried[i]);
        }
      }
      open = std::move(rest);
    }
    for (const auto& [side, p] : seeds) input_.holes.push_back(SeedAt(p));
  }

  // From the opposite corner through the middle of the side, and on by a part of the way.
  Point<D> Beyond(const std::pair<Side<D>, std::size_t>& side, double step) const {
    Point<D> middle{};
    for (const std::uint32_t v : side.first) {
      const Point<D> p = PointOf(v);
      for (std::size_t k = 0; k < D; ++k) middle.c[k] += p.c[k] / D;
    }
    const auto& corners = simplices()[side.second].corners;
    const auto opposite = std::ranges::find_if(
        corners, [&](std::uint32_t v) { return std::ranges::count(side.first, v) == 0; });
    const Point<D> from = PointOf(*opposite);
    for (std::size_t k = 0; k < D; ++k) middle.c[k] += step * (middle.c[k] - from.c[k]);
    for (double& c : middle.c) c = std::abs(c) < 0x1p-200 ? 0 : c;  // predicates' domain
    return middle;
  }

  const ElementMesh& mesh_;
  const ElementVertices vertices_;
  FileFeatures input_;
  FeatureId last_id_ = 0;
  std::vector<FeatureId> id_of_;  // of vertices
  absl::flat_hash_map<Side<D>, Constraint> constraint_of_;
  std::vector<Side<D>> order_;                           // of constraints: the given ones first
  std::size_t given_ = 0;                                // so many
  std::vector<std::pair<Side<D>, std::size_t>> border_;  // sides of one simplex
  std::optional<UnionFind> parts_;                       // of simplices, not across constraints
};

}  // namespace

FileFeatures FeaturesOf(const ElementMesh& mesh, ElementVertices vertices) {
  return mesh.dimension == 2 ? FeatureMaker<2>(mesh, vertices).Make()
                             : FeatureMaker<3>(mesh, vertices).Make();
}

}  // namespace dynmesh::io
