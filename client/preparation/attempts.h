// The mesh of a surface file, which is mended with larger tolerances where its mesh is too fine.
//
// A mesh accepts some surfaces and takes very many vertices all the same, as where parts overlap by
// next to nothing, or a cut of two faces made a needle. Then a larger tolerance is tried, within D,
// and so on. With the limit of all meshes it would take long to find that out: so a surface that
// was mended has a lower one at first, a function of its features. If no larger tolerance helps,
// those that reached it are tried again with the limit of all meshes, the one of the least
// tolerance first. So no surface loses its mesh.
//
// Which surface it is depends on the file, the options and that limit.
#ifndef DYNMESH_CLIENT_PREPARATION_ATTEMPTS_H_
#define DYNMESH_CLIENT_PREPARATION_ATTEMPTS_H_

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/preparation/prepare.h"

namespace dynmesh::preparation {

// How many vertices the mesh of a mended surface may have while larger tolerances have not been
// tried. O(n).
std::uint64_t FirstMostVertices(const std::vector<Feature>& features);

// Did a mesh end with `refusal` as it reached its limit of vertices; or that of halvings?
bool IsOfVertexLimit(const absl::Status& refusal);
bool IsTooFine(const absl::Status& refusal);

// What is told before the next attempt, which is with `tolerance`: the last one, of no more than
// `most` vertices, ended with `refusal`.
std::string TextOfNext(const absl::Status& refusal, std::optional<std::uint64_t> most,
                       std::optional<double> tolerance);
// The same where no attempt has helped, and the next is with the limit of all meshes.
std::string TextOfLast(std::optional<double> tolerance);

// Makes a mesh of `surface`, or of what else its file may become: OK as soon as there is one, else
// what the last attempt ended with. `surface` is then the one of that attempt.
//
// A Surface is movable, and has `features` and `preparation`, a std::optional<Report>; without a
// report there is one attempt. What is called:
//   absl::Status make(Surface&, std::optional<std::uint64_t> most): makes the mesh, with no more
//     vertices than `most`, and without it than all meshes may have; eight times at most;
//   absl::StatusOr<Surface> prepare(double): the file with no lesser tolerance than that
//     (PrepareOptions::least_tolerance);
//   void tell(std::string): before each attempt but the first, why there is one, and which.
template <class Surface, class Make, class Prepare, class Tell>
absl::Status MakeOfSurface(Surface& surface, const Make& make, const Prepare& prepare,
                           const Tell& tell) {
  std::vector<Surface> others;     // the one at hand is the next
  std::vector<std::size_t> again;  // those that reached the first limit
  absl::Status refusal;
  while (true) {
    if (!surface.preparation) return make(surface, std::nullopt);
    std::optional<std::uint64_t> most;
    if (surface.preparation->is_mended) most = FirstMostVertices(surface.features);
    refusal = make(surface, most);
    if (refusal.ok()) return refusal;
    if (most && IsOfVertexLimit(refusal)) again.push_back(others.size());
    std::optional<Surface> next;
    std::optional<double> larger = ToleranceIfTooFine(*surface.preparation, refusal);
    while (larger && !next) {
      absl::StatusOr<Surface> other = prepare(*larger);
      if (!other.ok() || !other->preparation || !other->preparation->is_mended) break;
      if (other->features != surface.features) {
        next = *std::move(other);
      } else {
        larger = ToleranceIfTooFine(*other->preparation, refusal);
      }
    }
    if (!next) break;
    tell(TextOfNext(refusal, most, larger));
    others.push_back(std::exchange(surface, *std::move(next)));
  }
  std::size_t at = others.size();
  others.push_back(std::move(surface));
  for (const std::size_t i : again) {
    tell(TextOfLast(others[i].preparation->least_tolerance));
    at = i;
    refusal = make(others[at], std::nullopt);
    if (!IsTooFine(refusal)) break;
  }
  surface = std::move(others[at]);
  return refusal;
}

}  // namespace dynmesh::preparation

#endif  // DYNMESH_CLIENT_PREPARATION_ATTEMPTS_H_
