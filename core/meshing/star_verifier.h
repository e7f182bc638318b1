// Completes a star by queries in the spatial tree.
#ifndef DYNMESH_CORE_MESHING_STAR_VERIFIER_H_
#define DYNMESH_CORE_MESHING_STAR_VERIFIER_H_

#include <cmath>
#include <vector>

#include "core/meshing/complex.h"
#include "core/meshing/star.h"
#include "core/meshing/star_view.h"

namespace dynmesh::meshing {

// Thread-compatible.
template <int D, template <class> class E>
class StarVerifier {
 public:
  using Context = ContextOf<D, E>;
  using Point = geometry::Point<D>;
  using Star = meshing::Star<D>;

  explicit StarVerifier(const Complex<D, E>& complex) : complex_(complex) {}

  // Makes any star of vertices that are there the star among all vertices as of now: searches the
  // balls about its unverified corners.
  void Run(const Context& context, Star& star);

 private:
  bool InsertAllInCorners(const Context& context, Star& star);
  bool VerifyCorner(const Context& context, Star& star, int i);

  const Complex<D, E>& complex_;
  std::vector<typename SpatialTree<D>::Ball> balls_;  // scratch
};

// --- Implementation -------------------------------------------------------------------------

// The largest balls first, one by one, as they may be huge and full. The rest together, once that
// is worth while.
template <int D, template <class> class E>
void StarVerifier<D, E>::Run(const Context& context, Star& star) {
  double worth_a_look = INFINITY;
  // Each vertex is inserted at most once, unless two have one position. That would be an error
  // elsewhere; it must not become an endless loop here.
  std::size_t insertions_left = complex_.elements.vertex_count();
  while (insertions_left > 0) {
    int largest = -1;
    for (int i = 0; i < star.corner_count(); ++i) {
      const auto& n = star.corner(i);
      if (!n.verified && (largest < 0 || n.r2 > star.corner(largest).r2)) largest = i;
    }
    if (largest < 0) return;
    const double r2 = star.corner(largest).r2;
    if (r2 <= worth_a_look) {
      if (InsertAllInCorners(context, star)) return;
      worth_a_look = r2 / 8;
      continue;  // Some may have been inserted: then another corner is the largest.
    }
    if (VerifyCorner(context, star, largest)) --insertions_left;
  }
}

// If the unverified corners are near their final state, few vertices lie about their balls, and one
// query finds them all. Insertion makes no ball that extends beyond those it replaces and their
// neighbours', so each vertex is tested only once. Returns false if there are too many vertices to
// test: balls may be huge and full.
template <int D, template <class> class E>
bool StarVerifier<D, E>::InsertAllInCorners(const Context& context, Star& star) {
  constexpr int kFew = D == 2 ? 96 : 400;
  Extent<D> box = Extent<D>::Nothing();
  balls_.clear();
  for (int i = 0; i < star.corner_count(); ++i) {
    const auto& n = star.corner(i);
    if (n.verified) continue;
    const double margin = MarginOf<D>(complex_.rules, star.reach(), n.error);
    if (!(margin < 1e-3 * star.reach())) return false;
    const double radius = std::sqrt(n.r2) + 2 * margin;
    balls_.push_back({CentreOf(star, i), radius * radius});
    box.AddBall(balls_.back().centre, radius);
  }
  if (balls_.empty()) return true;
  return complex_.tree.VisitBalls(balls_, box, kFew, [&](std::uint32_t id, const Point& q) {
    if (id == star.vertex() || star.Has(id)) return;
    star.InsertIf(id, q, [&] { return context.Sees(complex_.vertex(id).birth); });
  });
}

// Searches for a vertex in the ball of corner i. True if one was found and inserted.
template <int D, template <class> class E>
bool StarVerifier<D, E>::VerifyCorner(const Context& context, Star& star, int i) {
  const auto& n = star.corner(i);
  const Point& p = star.position();
  std::uint32_t found = kNil;
  Point found_p = {};
  auto search = [&](const Point& centre, double radius2) {
    complex_.tree.VisitBall(centre, radius2, [&](std::uint32_t id, const Point& q, double d2) {
      if (id == star.vertex() || star.Has(id) || !context.Sees(complex_.vertex(id).birth) ||
          !star.Conflicts(i, q)) {
        return;
      }
      found = id;
      found_p = q;
      radius2 = d2;
    });
    return found != kNil;
  };
  const double margin = MarginOf<D>(complex_.rules, star.reach(), n.error);
  if (margin < 1e-3 * star.reach()) {
    // A tentative ball may be huge and full. So first balls inside it that touch it at v, growing
    // from the scale of what is known.
    const double r = std::sqrt(n.r2);
    const double nearest = std::sqrt(star.LeastDistance2(i));
    for (double s = nearest; 0 < s && s < r / 2; s *= 2.5) {
      Point centre = p;
      for (int k = 0; k < D; ++k) centre[k] += n.w[k] * (s / r);
      if (search(centre, s * s)) break;
    }
    if (found == kNil) search(CentreOf(star, i), (r + 2 * margin) * (r + 2 * margin));
  } else {
    // The centre is not known.
    search(p, FarthestInView2<D>(star.reach()));
  }
  if (found == kNil) {
    star.MarkVerified(i);
    return false;
  }
  star.Insert(found, found_p);
  return true;
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_STAR_VERIFIER_H_
