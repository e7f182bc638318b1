#include "tests/core/io/meshes/good_space_mesh.h"

#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>
#include <set>
#include <utility>

#include "core/mesh_data/canonical_order.h"

namespace dynmesh::testing {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Base = CGAL::Triangulation_vertex_base_with_info_3<VertexId, Kernel>;
using Triangulation =
    CGAL::Delaunay_triangulation_3<Kernel, CGAL::Triangulation_data_structure_3<Base>>;
using Place = std::array<double, 3>;

constexpr double kSide = 8, kStep = 0.5;
constexpr int kHalf = 3;  // the plate reaches so many steps from its centre, its hole one

// The plate's frame: orthonormal but for rounding.
struct Frame {
  Place u, v, normal;
  Place At(double s, double t) const {
    Place p;
    for (std::size_t k = 0; k < 3; ++k) p[k] = kSide / 2 + s * u[k] + t * v[k];
    return p;
  }
  Place Coordinates(const Place& p) const {
    Place c = {0, 0, 0};
    for (std::size_t k = 0; k < 3; ++k) {
      const double d = p[k] - kSide / 2;
      c[0] += d * u[k], c[1] += d * v[k], c[2] += d * normal[k];
    }
    return c;
  }
};
constexpr Frame kAcross = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
constexpr Frame kTilted = {{0.8, 0, 0.6}, {0, 1, 0}, {-0.6, 0, 0.8}};

class SpaceBuilder {
 public:
  explicit SpaceBuilder(const Frame& frame) : frame_(frame) { good_.mesh.dimension = 3; }

  VertexId Add(const Place& p, int dimension, FeatureId owner) {
    const auto handle = triangulation_.insert(Kernel::Point_3(p[0], p[1], p[2]));
    const VertexId id = VertexIdAt(p.data(), 3);
    handle->info() = id;
    VertexColumns& columns = good_.mesh.vertices;
    columns.ids.push_back(id);
    columns.coordinates.insert(columns.coordinates.end(), p.begin(), p.end());
    columns.containing_dimensions.push_back(static_cast<std::uint8_t>(dimension));
    columns.owners.push_back(owner);
    return id;
  }

  VertexId AddInput(FeatureId id, const Place& p) {
    good_.features.push_back(Feature::Point(id, p[0], p[1], p[2]));
    return Add(p, 0, id);
  }

  // Corners, and the middles of the box's edges and sides.
  void AddBox() {
    for (int i = 0; i < 27; ++i) {
      const Place p = {kSide / 2 * (i % 3), kSide / 2 * (i / 3 % 3), kSide / 2 * (i / 9)};
      if (i != 13) Add(p, 0, kBoxFeature);
    }
  }

  void AddSubsegment(VertexId a, VertexId b, FeatureId owner) {
    SubsegmentColumns& subsegments = good_.mesh.subsegments;
    subsegments.ends.insert(subsegments.ends.end(), {std::min(a, b), std::max(a, b)});
    subsegments.owners.push_back(owner);
  }

  void AddPole() {
    const auto at = [](int i) { return Place{1, 1, 1.25 + kStep * i}; };
    constexpr int kSubsegments = 11;
    VertexId before = AddInput(4001, at(0));
    for (int i = 1; i <= kSubsegments; ++i) {
      const VertexId v = i == kSubsegments ? AddInput(4002, at(i)) : Add(at(i), 1, kPole);
      AddSubsegment(before, v, kPole);
      before = v;
    }
    good_.features.push_back(Feature::Segment(kPole, 4001, 4002));
  }

  void AddPlate(std::mt19937_64& random) {
    std::map<std::pair<int, int>, VertexId> at;
    const auto is_corner = [](int i, int j, int half) {
      return std::abs(i) == half && std::abs(j) == half;
    };
    const auto jitter = [&] { return static_cast<double>(random() % 1024) / 8192 - 1.0 / 16; };
    for (int i = -kHalf; i <= kHalf; ++i) {
      for (int j = -kHalf; j <= kHalf; ++j) {
        const int ring = std::max(std::abs(i), std::abs(j));
        double s = kStep * i, t = kStep * j;
        if (ring == 0) continue;  // in the hole
        if (is_corner(i, j, kHalf) || is_corner(i, j, 1)) {
          const FeatureId id = CornerId(i, j);
          at[{i, j}] = AddInput(id, frame_.At(s, t));
        } else if (ring == kHalf || ring == 1) {
          const bool on_rim = j == -kHalf;
          at[{i, j}] = Add(frame_.At(s, t), 1, on_rim ? kRim : kPlate);
        } else {
          s += jitter(), t += jitter();
          at[{i, j}] = Add(frame_.At(s, t), 2, kPlate);
        }
      }
    }
    for (const auto& [place, id] : at) on_plate_.insert(id);
    for (const int half : {kHalf, 1}) {
      for (int i = -half; i < half; ++i) {
        AddSubsegment(at[{i, -half}], at[{i + 1, -half}], half == kHalf ? kRim : kPlate);
        AddSubsegment(at[{i, half}], at[{i + 1, half}], kPlate);
        AddSubsegment(at[{-half, i}], at[{-half, i + 1}], kPlate);
        AddSubsegment(at[{half, i}], at[{half, i + 1}], kPlate);
      }
    }
    const auto ring = [&](int h) {
      return std::vector<FeatureId>{CornerId(-h, -h), CornerId(h, -h), CornerId(h, h),
                                    CornerId(-h, h)};
    };
    good_.features.push_back(Feature::Polygon(kPlate, {ring(kHalf), ring(1)}));
    good_.features.push_back(
        Feature::Segment(kRim, CornerId(-kHalf, -kHalf), CornerId(kHalf, -kHalf)));
  }

  // Far enough from pole and plate, so that their subsegments stay Delaunay.
  void AddRandom(std::mt19937_64& random, int count) {
    std::set<Place> taken;
    for (int i = 0; i < count;) {
      Place p;
      for (double& c : p) c = 0.75 + static_cast<double>(random() % 6656) / 1024;
      const Place c = frame_.Coordinates(p);
      const bool near_plate = std::abs(c[2]) < 0.6 && std::abs(c[0]) < 2.2 && std::abs(c[1]) < 2.2;
      if (near_plate || std::hypot(p[0] - 1, p[1] - 1) < 0.4 || !taken.insert(p).second) continue;
      if (++i % 3 == 0) {
        Add(p, 3, kNoFeature);
      } else {
        AddInput(static_cast<FeatureId>(i), p);
      }
    }
  }

  GoodSpaceMesh Finish() {
    for (auto c = triangulation_.finite_cells_begin(); c != triangulation_.finite_cells_end();
         ++c) {
      std::array<VertexId, 4> t;
      for (int k = 0; k < 4; ++k) t[static_cast<std::size_t>(k)] = c->vertex(k)->info();
      t = mesh_data::InCanonicalOrder(t);
      good_.mesh.simplices.insert(good_.mesh.simplices.end(), t.begin(), t.end());
      for (int k = 0; k < 4; ++k) AddSubfacet(c, k);
    }
    Canonicalize(good_.mesh);
    good_.mesh.hash = ComputeHash(good_.mesh);
    return std::move(good_);
  }

 private:
  static FeatureId CornerId(int i, int j) {
    return 3000 + 10 * static_cast<FeatureId>(std::abs(i)) + (i > 0 ? 2 : 0) + (j > 0 ? 1 : 0);
  }

  // Points flat on the plate count as above it, so that subfacets are on one side.
  bool IsAbove(Triangulation::Cell_handle c) const {
    double height = 0;
    bool flat = true;
    for (int k = 0; k < 4; ++k) {
      const auto& p = c->vertex(k)->point();
      height += frame_.Coordinates({p.x(), p.y(), p.z()})[2];
      flat = flat && on_plate_.contains(c->vertex(k)->info());
    }
    return flat || height > 0;
  }

  void AddSubfacet(Triangulation::Cell_handle c, int k) {
    const auto across = c->neighbor(k);
    if (triangulation_.is_infinite(across) || !IsAbove(c) || IsAbove(across)) return;
    std::array<VertexId, 3> corners;
    Place middle = {0, 0, 0};
    for (int i = 0; i < 3; ++i) {
      const auto vertex = c->vertex((k + 1 + i) % 4);
      if (!on_plate_.contains(vertex->info())) return;
      corners[static_cast<std::size_t>(i)] = vertex->info();
      const auto& p = vertex->point();
      const Place at = frame_.Coordinates({p.x(), p.y(), p.z()});
      for (std::size_t j = 0; j < 3; ++j) middle[j] += at[j] / 3;
    }
    if (std::max(std::abs(middle[0]), std::abs(middle[1])) < kStep) return;  // in the hole
    std::sort(corners.begin(), corners.end());
    SubfacetColumns& subfacets = good_.mesh.subfacets;
    subfacets.corners.insert(subfacets.corners.end(), corners.begin(), corners.end());
    subfacets.owners.push_back(kPlate);
  }

  const Frame frame_;
  Triangulation triangulation_;
  std::set<VertexId> on_plate_;
  GoodSpaceMesh good_;
};

}  // namespace

GoodSpaceMesh MakeGoodSpaceMesh(std::uint64_t seed, int count, bool tilted) {
  std::mt19937_64 random(seed);
  SpaceBuilder builder(tilted ? kTilted : kAcross);
  builder.AddBox();
  builder.AddPole();
  builder.AddPlate(random);
  builder.AddRandom(random, count);
  return builder.Finish();
}

}  // namespace dynmesh::testing
