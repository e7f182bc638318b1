#include "tests/client/verify/good_mesh.h"

#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <set>
#include <utility>
#include <vector>

namespace dynmesh::testing {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Base = CGAL::Triangulation_vertex_base_with_info_2<VertexId, Kernel>;
using Triangulation =
    CGAL::Delaunay_triangulation_2<Kernel, CGAL::Triangulation_data_structure_2<Base>>;
using Handle = Triangulation::Vertex_handle;

class Builder {
 public:
  Handle Add(double x, double y, int dimension, FeatureId owner) {
    const double c[2] = {x, y};
    const Handle handle = triangulation_.insert(Kernel::Point_2(x, y));
    handle->info() = VertexIdAt(c, 2);
    mesh_.vertices.ids.push_back(handle->info());
    mesh_.vertices.coordinates.insert(mesh_.vertices.coordinates.end(), {x, y});
    mesh_.vertices.containing_dimensions.push_back(static_cast<std::uint8_t>(dimension));
    mesh_.vertices.owners.push_back(owner);
    return handle;
  }

  Handle AddInput(double x, double y) {
    const FeatureId id = features_.size() + 1;
    features_.push_back(Feature::Point(id, x, y));
    return Add(x, y, 0, id);
  }

  // [0, side]^2 with corners and one vertex more on each side.
  void AddBox(double side) {
    const double h = side / 2;
    const double ring[8][2] = {{0, 0},       {h, 0},    {side, 0}, {side, h},
                               {side, side}, {h, side}, {0, side}, {0, h}};
    std::vector<Handle> handles;
    for (int i = 0; i < 8; ++i) handles.push_back(Add(ring[i][0], ring[i][1], i % 2, kBoxFeature));
    for (std::size_t i = 0; i < 8; ++i) {
      subsegments_.push_back({handles[i], handles[(i + 1) % 8], kBoxFeature});
    }
  }

  // A point feature of any id.
  Handle AddPoint(FeatureId id, double x, double y) {
    features_.push_back(Feature::Point(id, x, y));
    points_[id] = Add(x, y, 0, id);
    return points_[id];
  }

  // Edges that an earlier feature has belong to that one.
  void AddPolygon(FeatureId id, const Rings& rings) {
    features_.push_back(Feature::Polygon(id, rings));
    for (const auto& ring : rings) {
      for (std::size_t i = 0; i < ring.size(); ++i) Join(id, ring[i], ring[(i + 1) % ring.size()]);
    }
  }

  void AddSegment(FeatureId id, FeatureId p, FeatureId q) {
    features_.push_back(Feature::Segment(id, p, q));
    Join(id, p, q);
  }

  void AddSegment(FeatureId p, FeatureId q, Handle a, Handle b) {
    const FeatureId id = features_.size() + 1;
    features_.push_back(Feature::Segment(id, p, q));
    subsegments_.push_back({a, b, id});
  }

  // Splits subsegments in the middle until all are edges.
  // `polygons_at` returns the polygons around a point, ascending.
  template <class PolygonsAt>
  GoodMesh Finish(PolygonsAt polygons_at) {
    for (std::size_t i = 0; i < subsegments_.size();) {
      const Subsegment subsegment = subsegments_[i];
      if (triangulation_.is_edge(subsegment.a, subsegment.b)) {
        ++i;
        continue;
      }
      const Handle middle =
          Add((subsegment.a->point().x() + subsegment.b->point().x()) / 2,
              (subsegment.a->point().y() + subsegment.b->point().y()) / 2, 1, subsegment.owner);
      subsegments_[i] = {subsegment.a, middle, subsegment.owner};
      subsegments_.push_back({middle, subsegment.b, subsegment.owner});
      i = 0;  // the new vertex may have broken others
    }
    for (const Subsegment& subsegment : subsegments_) {
      const auto [lesser, greater] = std::minmax(subsegment.a->info(), subsegment.b->info());
      mesh_.subsegments.ends.insert(mesh_.subsegments.ends.end(), {lesser, greater});
      mesh_.subsegments.owners.push_back(subsegment.owner);
    }
    for (auto f = triangulation_.finite_faces_begin(); f != triangulation_.finite_faces_end();
         ++f) {
      double x = 0, y = 0;
      for (int k = 0; k < 3; ++k) {
        mesh_.simplices.push_back(f->vertex(k)->info());
        x += f->vertex(k)->point().x() / 3, y += f->vertex(k)->point().y() / 3;
      }
      const std::vector<FeatureId> polygons = polygons_at(x, y);
      mesh_.regions.push_back(polygons.empty()       ? kNoRegion
                              : polygons.size() == 1 ? polygons[0]
                                                     : RegionIdOf(polygons));
      if (polygons.size() > 1) mesh_.region_sets.push_back({mesh_.regions.back(), polygons});
    }
    Canonicalize(mesh_);
    GoodMesh good;
    good.files.mesh = io::IndexMesh(mesh_).value();
    good.files.recorded_hash = io::ToMesh(good.files.mesh).hash;
    good.features = std::move(features_);
    return good;
  }

 private:
  struct Subsegment {
    Handle a;
    Handle b;
    FeatureId owner;
  };
  void Join(FeatureId owner, FeatureId p, FeatureId q) {
    if (joined_.insert(std::minmax(p, q)).second) {
      subsegments_.push_back({points_.at(p), points_.at(q), owner});
    }
  }

  Triangulation triangulation_;
  Mesh mesh_;
  std::map<FeatureId, Handle> points_;
  std::set<std::pair<FeatureId, FeatureId>> joined_;
  std::vector<Subsegment> subsegments_;
  std::vector<Feature> features_;
};

std::vector<FeatureId> NoPolygons(double, double) { return {}; }

}  // namespace

GoodMesh MakeGoodMesh(std::uint64_t seed, int count) {
  std::mt19937_64 random(seed);
  // On a grid of 2^-10; where x is odd there, no point is on one of the segments.
  const auto coordinate = [&](std::uint64_t parity) {
    return 1 + static_cast<double>(random() % 2048 * 2 + parity) / 1024;
  };
  Builder builder;
  builder.AddBox(6);
  const Handle a = builder.AddInput(1, 1.5);
  const Handle b = builder.AddInput(5, 3.25);
  const Handle c = builder.AddInput(2, 5);
  std::set<std::pair<double, double>> taken;
  const auto fresh_place = [&](std::uint64_t parity_y) {
    std::pair<double, double> place;
    do {
      place = {coordinate(1), coordinate(parity_y)};
    } while (!taken.insert(place).second);
    return place;
  };
  for (int i = 0; i < count; ++i) {
    const auto [x, y] = fresh_place(0);
    builder.AddInput(x, y);
  }
  for (int i = 0; i < count / 2; ++i) {
    const auto [x, y] = fresh_place(1);
    builder.Add(x, y, 2, kNoFeature);
  }
  builder.AddSegment(1, 2, a, b);
  builder.AddSegment(3, 2, c, b);
  return builder.Finish(NoPolygons);
}

GoodMesh MakePolygonMesh(std::uint64_t seed, int count) {
  std::mt19937_64 random(seed);
  Builder builder;
  builder.AddBox(6);
  const auto square = [&](FeatureId first, double lo, double hi) {
    builder.AddPoint(first, lo, lo);
    builder.AddPoint(first + 1, hi, lo);
    builder.AddPoint(first + 2, hi, hi);
    builder.AddPoint(first + 3, lo, hi);
    return std::vector<FeatureId>{first, first + 1, first + 2, first + 3};
  };
  const auto outer = square(100, 1, 5), hole = square(200, 2, 4), inner = square(300, 2.5, 3.5);
  builder.AddPoint(400, 5.75, 3);
  for (int part = 0; part < 2; ++part) {
    const FeatureId first = 500 + 10 * static_cast<FeatureId>(part);
    const double y = part == 0 ? 1.25 : 4.25;
    builder.AddPoint(first, 2, y);
    builder.AddPoint(first + 1, 4, y);
    builder.AddPoint(first + 2, 4, y + 0.5);
    builder.AddPoint(first + 3, 2, y + 0.5);
  }
  // Off all edges: no coordinate is a multiple of 2^-9, none is near the roof's slopes, and
  // no x is a y, as on the diagonal of the tip.
  std::set<std::pair<double, double>> taken;
  for (int i = 0; i < count; ++i) {
    const double x = static_cast<double>(random() % 5000 * 2 + 1) / 1024 + 0.1;
    const double y = static_cast<double>(random() % 5000 * 2 + 1) / 1024 + 0.2;
    if (x < 4.9 && y < 5.9 && taken.emplace(x, y).second) builder.Add(x, y, 2, kNoFeature);
  }
  // By precedence: the segment, then polygons by id.
  builder.AddSegment(kHoleSegment, hole[1], hole[0]);
  builder.AddPolygon(kRoof, {{outer[1], 400, outer[2]}});
  builder.AddPolygon(kFilling, {hole});
  builder.AddPolygon(kNested, {{inner[3], inner[2], inner[1], inner[0]}});
  builder.AddPolygon(kRing, {outer, hole});
  builder.AddPolygon(kParts, {{500, 501, 502, 503}, {510, 511, 512, 513}});
  builder.AddPolygon(kTip, {{inner[0], inner[1], inner[2]}});
  return builder.Finish([](double x, double y) {
    const auto in = [&](double x0, double y0, double x1, double y1) {
      return x > x0 && x < x1 && y > y0 && y < y1;
    };
    std::vector<FeatureId> polygons;
    if (x > 5 && x - 5 < 0.75 * (1 - std::abs(y - 3) / 2)) polygons.push_back(kRoof);
    if (in(2, 2, 4, 4)) polygons.push_back(kFilling);
    if (in(2.5, 2.5, 3.5, 3.5)) polygons.push_back(kNested);
    if (in(1, 1, 5, 5) && !in(2, 2, 4, 4)) polygons.push_back(kRing);
    if (in(2, 1.25, 4, 1.75) || in(2, 4.25, 4, 4.75)) polygons.push_back(kParts);
    if (in(2.5, 2.5, 3.5, 3.5) && x > y) polygons.push_back(kTip);
    return polygons;
  });
}

GoodMesh MakeGridMesh(int n) {
  Builder builder;
  builder.AddBox(n + 1);
  for (int x = 1; x <= n; ++x) {
    for (int y = 1; y <= n; ++y) builder.AddInput(x, y);
  }
  return builder.Finish(NoPolygons);
}

}  // namespace dynmesh::testing
