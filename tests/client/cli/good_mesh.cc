#include "tests/client/cli/good_mesh.h"

#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include <random>
#include <set>
#include <utility>

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
      pieces_.push_back({handles[i], handles[(i + 1) % 8], kBoxFeature});
    }
  }

  void AddSegment(FeatureId p, FeatureId q, Handle a, Handle b) {
    const FeatureId id = features_.size() + 1;
    features_.push_back(Feature::Segment(id, p, q));
    pieces_.push_back({a, b, id});
  }

  // Splits pieces in the middle until all are edges.
  GoodMesh Finish() {
    for (std::size_t i = 0; i < pieces_.size();) {
      const Piece piece = pieces_[i];
      if (triangulation_.is_edge(piece.a, piece.b)) {
        ++i;
        continue;
      }
      const Handle middle = Add((piece.a->point().x() + piece.b->point().x()) / 2,
                                (piece.a->point().y() + piece.b->point().y()) / 2, 1, piece.owner);
      pieces_[i] = {piece.a, middle, piece.owner};
      pieces_.push_back({middle, piece.b, piece.owner});
      i = 0;  // the new vertex may have broken others
    }
    for (const Piece& piece : pieces_) {
      const auto [lesser, greater] = std::minmax(piece.a->info(), piece.b->info());
      mesh_.subsegments.ends.insert(mesh_.subsegments.ends.end(), {lesser, greater});
      mesh_.subsegments.owners.push_back(piece.owner);
    }
    for (auto f = triangulation_.finite_faces_begin(); f != triangulation_.finite_faces_end();
         ++f) {
      for (int k = 0; k < 3; ++k) mesh_.simplices.push_back(f->vertex(k)->info());
    }
    GoodMesh good;
    good.files.mesh = io::IndexMesh(mesh_).value();
    good.files.recorded_hash = io::ToMesh(good.files.mesh).hash;
    good.features = std::move(features_);
    return good;
  }

 private:
  struct Piece {
    Handle a;
    Handle b;
    FeatureId owner;
  };
  Triangulation triangulation_;
  Mesh mesh_;
  std::vector<Piece> pieces_;
  std::vector<Feature> features_;
};

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
  return builder.Finish();
}

GoodMesh MakeGridMesh(int n) {
  Builder builder;
  builder.AddBox(n + 1);
  for (int x = 1; x <= n; ++x) {
    for (int y = 1; y <= n; ++y) builder.AddInput(x, y);
  }
  return builder.Finish();
}

}  // namespace dynmesh::testing
