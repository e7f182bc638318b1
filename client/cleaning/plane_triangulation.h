// A small triangulation in the plane that is changed by splits and flips: the pieces of a face.
//
// All decisions are exact. The triangles always cover the same area modulo 2: also where points lie
// slightly outside and triangles are folded, which is possible beside edges whose points are only
// nearly on them. Folded triangles are split, but not flipped.
//
// Thread-compatible. O(n) for each operation on n triangles; a flip is O(1).
#ifndef DYNMESH_CLIENT_CLEANING_PLANE_TRIANGULATION_H_
#define DYNMESH_CLIENT_CLEANING_PLANE_TRIANGULATION_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/container/flat_hash_set.h"
#include "client/cleaning/node_table.h"

namespace dynmesh::cleaning {

class PlaneTriangulation {
 public:
  using Vertex = std::uint32_t;
  using Triangle = std::array<Vertex, 3>;  // counter-clockwise, unless folded

  static constexpr double kLeastSine = 1.6e-6;

  // Flips for Delaunay's sake make no triangle of a height below `least_height`, or with angles of
  // a sine below `least_sine`: it would be split again. All are made if the height is 0.
  explicit PlaneTriangulation(double least_height = 0, double least_sine = kLeastSine)
      : least_height_(least_height), least_sine_(least_sine) {}

  // The order of ranks breaks ties between diagonals; several vertices may have one rank.
  Vertex AddVertex(const Point& at, std::uint32_t rank);
  std::uint32_t RankOf(Vertex v) const { return ranks_[v]; }

  void AddTriangle(Vertex a, Vertex b, Vertex c);

  // Splits the edge xy, which may be on the border, at v. If v's rank is that of the vertex
  // opposite to it, that triangle goes instead, and the border runs through the vertex, which is
  // returned. Else returns v. If no triangle is left there, xvy becomes one, which may be folded.
  Vertex SplitBorder(Vertex x, Vertex y, Vertex v);
  // Puts v into the triangle or on the inner edge where it lies. False outside of all, or if a
  // vertex is there.
  bool Insert(Vertex v);
  // Inserts v and keeps the triangulation Delaunay. REQUIRES: it is, and v lies in it.
  bool InsertDelaunay(Vertex v);
  // Makes ab an edge that is not flipped; if it runs through vertices: its parts, unless `whole`.
  // False if that is impossible, mostly because it crosses another such edge.
  bool Fix(Vertex a, Vertex b, bool whole = false);
  void FixEdge(Vertex a, Vertex b) { fixed_.insert(Undirected(a, b)); }
  bool IsFixed(Vertex a, Vertex b) const { return fixed_.contains(Undirected(a, b)); }

  // Flips edges until all are Delaunay that are neither fixed nor at a folded triangle. Of equally
  // good diagonals the one with the vertex of the least rank is taken: so the result depends on
  // the points and the fixed edges only.
  void MakeDelaunay();

  // Without removed ones, in no particular but a reproducible order.
  std::vector<Triangle> Triangles() const;
  // The vertex opposite to the directed edge xy, if a triangle is to its left.
  std::optional<Vertex> Opposite(Vertex x, Vertex y) const;

 private:
  static std::uint64_t Key(Vertex x, Vertex y) { return std::uint64_t{x} << 32 | y; }
  static std::uint64_t Undirected(Vertex x, Vertex y) { return x < y ? Key(x, y) : Key(y, x); }

  int Orientation(Vertex a, Vertex b, Vertex c) const;
  bool IsDead(std::size_t t) const { return triangles_[t][0] == triangles_[t][1]; }
  void Put(std::size_t t, Vertex a, Vertex b, Vertex c);
  void Take(Vertex x, Vertex y) { of_edge_.erase(Key(x, y)); }
  std::optional<std::size_t> Left(Vertex x, Vertex y) const;
  void SplitFace(std::size_t t, Vertex v);
  void SplitEdge(Vertex x, Vertex y, Vertex v);
  // The quadrilateral on both sides of xy is strictly convex.
  bool IsConvex(Vertex x, Vertex y) const;
  void Flip(Vertex x, Vertex y);
  bool IsThin(Vertex a, Vertex b, Vertex c) const;
  bool WantsFlip(Vertex x, Vertex y) const;
  void Legalise(std::vector<std::pair<Vertex, Vertex>> edges);
  bool PutIntoTriangle(std::size_t t, Vertex v);
  std::optional<std::size_t> Walk(Vertex v) const;
  std::vector<std::pair<Vertex, Vertex>> LinkOf(Vertex v) const;
  // The edges that ab crosses, or a vertex on it.
  struct Way {
    std::vector<std::pair<Vertex, Vertex>> edges;
    std::optional<Vertex> through;
    bool is_edge = false;
    bool is_blocked = false;
  };
  Way FindWay(Vertex a, Vertex b) const;

  double least_height_, least_sine_;
  std::vector<Point> points_;
  std::vector<std::uint32_t> ranks_;
  std::vector<Triangle> triangles_;
  std::vector<std::size_t> at_;  // by vertex: a triangle there, or one that was there
  absl::flat_hash_map<std::uint64_t, std::size_t> of_edge_;  // directed: the triangle to its left
  absl::flat_hash_set<std::uint64_t> fixed_;                 // undirected
  std::size_t last_ = 0;
};

}  // namespace dynmesh::cleaning

#endif  // DYNMESH_CLIENT_CLEANING_PLANE_TRIANGULATION_H_
