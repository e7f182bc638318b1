// Vertices come as in a Delaunay triangulation, with segments as walls of the cavity; they go by
// ears and flips. Segments come and go by flips. Any way leads to the same triangles: a
// triangulation in which all edges but segments are locally Delaunay is the constrained Delaunay
// triangulation, and that is unique (Lee and Lin 1986).
#include "core/delaunay/constrained_triangulation.h"

#include <algorithm>
#include <cassert>
#include <utility>

#include "core/geometry/predicates.h"

namespace dynmesh::delaunay {

using geometry::Point2;

// --- Segments ---------------------------------------------------------------------------

void ConstrainedTriangulation::SetSegment(Corner c, bool is) {
  for (const Corner side : {c, Opposite(c)}) {
    std::uint8_t& marks = marks_[side.simplex];
    marks =
        static_cast<std::uint8_t>(is ? marks | MarkOf(side.index) : marks & ~MarkOf(side.index));
  }
}

ConstrainedTriangulation::Corner ConstrainedTriangulation::FindEdge(VertexIndex a,
                                                                    VertexIndex b) const {
  // Around both ends at once: one of them may have very many edges.
  const Corner first_at_a = Around(a), first_at_b = Around(b);
  Corner at_a = first_at_a, at_b = first_at_b;
  do {
    if (NextVertex(at_a) == b) return {at_a.simplex, PreviousIndex(at_a.index)};
    if (NextVertex(at_b) == a) return Opposite({at_b.simplex, PreviousIndex(at_b.index)});
    at_a = NextAround(at_a);
    at_b = NextAround(at_b);
  } while (at_a != first_at_a && at_b != first_at_b);
  return {kNone, 0};
}

bool ConstrainedTriangulation::HasSegment(VertexIndex a, VertexIndex b) const {
  if (segment_count_ == 0) return false;
  const Corner c = FindEdge(a, b);
  return c.simplex != kNone && IsSegment(c);
}

bool ConstrainedTriangulation::AddSegment(VertexIndex a, VertexIndex b) {
  assert(Contains(a) && Contains(b) && a != b);
  BeginFlips();
  if (const Corner c = FindEdge(a, b); c.simplex != kNone) {
    if (IsSegment(c)) return false;
    SetSegment(c, true);
    ++segment_count_;
    return true;
  }
  if (!FindCrossed(a, b)) return false;
  FlipCrossed(a, b);
  SetSegment(FindEdge(a, b), true);
  ++segment_count_;
  for (const Edge& edge : fresh_edges_) {
    const Corner c = FindEdge(edge.first, edge.second);
    suspects_.push_back(ToCode(c.simplex, c.index));
  }
  Legalize();
  EndFlips();
  return true;
}

void ConstrainedTriangulation::RemoveSegment(VertexIndex a, VertexIndex b) {
  BeginFlips();
  const Corner c = FindEdge(a, b);
  assert(c.simplex != kNone && IsSegment(c));
  SetSegment(c, false);
  --segment_count_;
  suspects_.push_back(ToCode(c.simplex, c.index));
  Legalize();
  EndFlips();
}

// The end that the search begins at is the one where it ends sooner, as in FindEdge.
bool ConstrainedTriangulation::FindCrossed(VertexIndex a, VertexIndex b) {
  crossed_.clear();
  const auto leaves_through = [&](Corner c, VertexIndex to) {
    if (IsInfinite(c.simplex)) return false;
    const Point2& from = points_[triangles_[c.simplex].v[c.index]];
    return Orientation(from, points_[to], points_[NextVertex(c)]) < 0 &&
           Orientation(from, points_[to], points_[PreviousVertex(c)]) > 0;
  };
  const Corner first_at_a = Around(a), first_at_b = Around(b);
  Corner c = first_at_a, at_b = first_at_b;
  while (!leaves_through(c, b)) {
    if (leaves_through(at_b, a)) {
      std::swap(a, b);
      c = at_b;
      break;
    }
    c = NextAround(c);
    at_b = NextAround(at_b);
    if (c == first_at_a || at_b == first_at_b) return false;  // a vertex is on the segment
  }
  const Point2 &from = points_[a], &to = points_[b];
  while (true) {
    if (IsSegment(c)) return false;
    crossed_.emplace_back(NextVertex(c), PreviousVertex(c));
    const Corner across = Opposite(c);
    const VertexIndex apex = triangles_[across.simplex].v[across.index];
    if (apex == b) return true;
    const int side = Orientation(from, to, points_[apex]);
    if (side == 0) return false;
    // The side of the triangle that the segment leaves by: the one with the apex and the vertex on
    // the other side of the segment.
    c = {across.simplex, side > 0 ? NextIndex(across.index) : PreviousIndex(across.index)};
  }
}

bool ConstrainedTriangulation::Crosses(VertexIndex a, VertexIndex b, const Edge& edge) const {
  const auto [r, s] = edge;
  if (r == a || r == b || s == a || s == b) return false;
  return Orientation(points_[a], points_[b], points_[r]) !=
         Orientation(points_[a], points_[b], points_[s]);
}

// An edge whose quadrilateral is not convex waits until others were flipped (Sloan 1993).
void ConstrainedTriangulation::FlipCrossed(VertexIndex a, VertexIndex b) {
  fresh_edges_.clear();
  while (!crossed_.empty()) {
    const Edge edge = crossed_.front();
    crossed_.pop_front();
    const Corner c = FindEdge(edge.first, edge.second), across = Opposite(c);
    const VertexIndex r = triangles_[c.simplex].v[c.index],
                      s = triangles_[across.simplex].v[across.index];
    if (Orientation(points_[r], points_[edge.first], points_[s]) <= 0 ||
        Orientation(points_[s], points_[edge.second], points_[r]) <= 0) {
      crossed_.push_back(edge);
      continue;
    }
    Flip(c);
    const Edge fresh{r, s};
    if (Crosses(a, b, fresh)) {
      crossed_.push_back(fresh);
    } else if (std::minmax(r, s) != std::minmax(a, b)) {
      fresh_edges_.push_back(fresh);
    }
  }
}

// --- Vertices ---------------------------------------------------------------------------

void ConstrainedTriangulation::Insert(VertexIndex v, const Point2& p, VertexIndex near) {
  if (segment_count_ == 0) {
    DelaunayTriangulation::Insert(v, p, near);
    if (!marks_.empty()) marks_.resize(triangles_.size());
    return;
  }
  assert(!Contains(v));
  const SimplexIndex start = LocateAmongSegments(p, near);
  AddVertex(v, p);
  FindVisibleCavity(p, start);
  for (const SimplexIndex t : cavity_) marks_[t] = 0;
  FillCavityFrom(v, p);
  marks_.resize(triangles_.size());
  CopyMarksTo(created_);
}

// A walk that crosses edges with p beyond may go in circles here, unless it chooses among them by
// chance (Devillers, Pion, Teillaud 2002). No result depends on the choices.
ConstrainedTriangulation::SimplexIndex ConstrainedTriangulation::LocateAmongSegments(
    const Point2& p, VertexIndex near) const {
  SimplexIndex t = (Contains(near) ? incident_[near] : infinite_incident_) >> 2;
  if (IsInfinite(t)) {
    const auto& v = vertices(t);
    const int i = v[0] == kInfinite ? 0 : v[1] == kInfinite ? 1 : 2;
    t = Opposite({t, i}).simplex;
  }
  std::uint32_t chance = 0x9e3779b9;
  int entry = -1;
  while (true) {
    chance = chance * 1664525 + 1013904223;
    int i = static_cast<int>((chance >> 16) % 3), k = 0;
    const auto& v = vertices(t);
    for (; k < 3; ++k, i = NextIndex(i)) {
      if (i != entry && Orientation(points_[v[NextIndex(i)]], points_[v[PreviousIndex(i)]], p) < 0)
        break;
    }
    if (k == 3) return t;
    const Corner across = Opposite({t, i});
    t = across.simplex;
    entry = across.index;
    if (IsInfinite(t)) return t;
  }
}

// As DelaunayTriangulation::FindCavity, within the walls. What p sees and conflicts with is a disc
// that is star-shaped around p, so it needs no mark, either.
void ConstrainedTriangulation::FindVisibleCavity(const Point2& p, SimplexIndex start) {
  cavity_.assign(1, start);
  rim_.clear();
  suspects_.clear();
  for (const int i : {2, 1, 0}) suspects_.push_back(ToCode(start, i));
  while (!suspects_.empty()) {
    const Corner inside = ToCorner(suspects_.back());
    suspects_.pop_back();
    const Corner outside = Opposite(inside);
    if (!IsSegment(inside) && Conflicts(outside.simplex, p)) {
      cavity_.push_back(outside.simplex);
      suspects_.push_back(ToCode(outside.simplex, PreviousIndex(outside.index)));
      suspects_.push_back(ToCode(outside.simplex, NextIndex(outside.index)));
    } else {
      rim_.push_back(
          {NextVertex(inside), PreviousVertex(inside), ToCode(outside.simplex, outside.index)});
    }
  }
}

// Marks of new triangles from their neighbours.
void ConstrainedTriangulation::CopyMarksTo(std::span<const SimplexIndex> fresh) {
  for (const SimplexIndex t : fresh) {
    for (int i = 0; i < 3; ++i) {
      if (IsSegment(triangles_[t].opposite[i])) {
        marks_[t] = static_cast<std::uint8_t>(marks_[t] | MarkOf(i));
      }
    }
  }
}

void ConstrainedTriangulation::Remove(VertexIndex v) {
  if (segment_count_ == 0) {
    DelaunayTriangulation::Remove(v);
    return;
  }
  assert(Contains(v));
  OpenHole(v);
  assert(std::ranges::none_of(cavity_, [&](SimplexIndex t) { return IsInfinite(t); }));
  for (const SimplexIndex t : cavity_) marks_[t] = 0;
  incident_[v] = kNone;
  --vertex_count_;
  created_.clear();
  FillHoleByEars(points_[v]);
  for (const SimplexIndex t : cavity_) FreeTriangle(t);
  CopyMarksTo(created_);
  suspects_.clear();
  for (const SimplexIndex t : created_) {
    marks_[t] |= kTouched;  // new anyway: nothing to record
    for (int i = 0; i < 3; ++i) suspects_.push_back(ToCode(t, i));
  }
  Legalize();
  EndFlips();
}

// Cuts off corners w of the rim between u and x if it is convex there and the removed point sees
// both of them: then the triangle is in the hole, and what remains is star-shaped, too. While there
// are more than three corners, there is such a one: the angles of a star-shaped polygon at the
// removed point and at its corners have the same sum as in a triangulated one.
void ConstrainedTriangulation::FillHoleByEars(const Point2& removed) {
  const std::size_t count = rim_.size();
  std::vector<std::size_t> next(count), previous(count);
  for (std::size_t i = 0; i < count; ++i) {
    next[i] = i + 1 == count ? 0 : i + 1;
    previous[i] = i == 0 ? count - 1 : i - 1;
  }
  const auto at = [&](std::size_t i) -> const Point2& { return points_[rim_[i].a]; };
  std::size_t w = 0;
  for (std::size_t left = count; left > 3;) {
    const std::size_t u = previous[w], x = next[w];
    if (Orientation(at(u), at(w), at(x)) <= 0 || Orientation(at(u), at(x), removed) < 0) {
      w = x;
      continue;
    }
    const SimplexIndex t = TakeSlot();
    MakeTriangle(t, rim_[u].a, rim_[w].a, rim_[x].a);
    Link(ToCode(t, 0), rim_[w].outside);
    Link(ToCode(t, 2), rim_[u].outside);
    rim_[u].outside = ToCode(t, 1);
    next[u] = x;
    previous[x] = u;
    w = u;
    --left;
  }
  const std::size_t u = previous[w], x = next[w];
  const SimplexIndex t = TakeSlot();
  MakeTriangle(t, rim_[u].a, rim_[w].a, rim_[x].a);
  Link(ToCode(t, 0), rim_[w].outside);
  Link(ToCode(t, 1), rim_[x].outside);
  Link(ToCode(t, 2), rim_[u].outside);
}

// --- Flips ------------------------------------------------------------------------------

void ConstrainedTriangulation::BeginFlips() {
  created_.clear();
  deleted_.clear();
  deleted_tags_.clear();
  suspects_.clear();
  marks_.resize(triangles_.size());
}

void ConstrainedTriangulation::Touch(SimplexIndex t) {
  if ((marks_[t] & kTouched) != 0) return;
  marks_[t] |= kTouched;
  created_.push_back(t);
  deleted_.push_back(triangles_[t].v);
  deleted_tags_.push_back(triangles_[t].tag);
}

void ConstrainedTriangulation::EndFlips() {
  for (const SimplexIndex t : created_) marks_[t] &= static_cast<std::uint8_t>(~kTouched);
}

void ConstrainedTriangulation::Legalize() {
  while (!suspects_.empty()) {
    const Corner c = ToCorner(suspects_.back());
    suspects_.pop_back();
    const Corner across = Opposite(c);
    if (IsSegment(c) || IsInfinite(c.simplex) || IsInfinite(across.simplex)) continue;
    if (!Conflicts(c.simplex, points_[triangles_[across.simplex].v[across.index]])) continue;
    Flip(c);
    for (const SimplexIndex t : {c.simplex, across.simplex}) {
      suspects_.push_back(ToCode(t, 0));
      suspects_.push_back(ToCode(t, 2));
    }
  }
}

// Replaces the edge opposite to c by the other diagonal of its quadrilateral, which is the edge
// opposite to corner 1 of both triangles.
void ConstrainedTriangulation::Flip(Corner c) {
  const Corner d = Opposite(c);
  Touch(c.simplex);
  Touch(d.simplex);
  const Triangle t = triangles_[c.simplex], u = triangles_[d.simplex];
  const int next = NextIndex(c.index), previous = PreviousIndex(c.index);
  const int after = NextIndex(d.index), before = PreviousIndex(d.index);
  const VertexIndex r = t.v[c.index], x = t.v[next], y = t.v[previous], s = u.v[d.index];
  MakeTriangle(c.simplex, r, x, s);
  MakeTriangle(d.simplex, s, y, r);
  Link(ToCode(c.simplex, 1), ToCode(d.simplex, 1));
  Link(ToCode(c.simplex, 0), u.opposite[after]);
  Link(ToCode(c.simplex, 2), t.opposite[previous]);
  Link(ToCode(d.simplex, 0), t.opposite[next]);
  Link(ToCode(d.simplex, 2), u.opposite[before]);
  const std::array both = {c.simplex, d.simplex};
  for (const SimplexIndex i : both) marks_[i] = kTouched;
  CopyMarksTo(both);
}

}  // namespace dynmesh::delaunay
