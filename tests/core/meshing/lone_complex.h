// A complex without refinement: a test adds the vertices and subsegments, each with its time, and
// calls the part under test with a context of any time (recording_engine.h).
#ifndef DYNMESH_TESTS_CORE_MESHING_LONE_COMPLEX_H_
#define DYNMESH_TESTS_CORE_MESHING_LONE_COMPLEX_H_

#include <cstdint>
#include <vector>

#include "core/meshing/border.h"
#include "core/meshing/complex.h"
#include "core/meshing/input_editor.h"
#include "core/meshing/notifier.h"
#include "core/meshing/publisher.h"
#include "dynmesh/options.h"
#include "tests/support/recording_engine.h"
#include "tests/support/workload.h"

namespace dynmesh::meshing {

template <int D>
struct LoneComplex {
  using Engine = EngineOf<D, test::RecordingEngine>;
  using Context = ContextOf<D, test::RecordingEngine>;
  using Point = geometry::Point<D>;

  // With the domain's border.
  explicit LoneComplex(const MeshOptions& options = Options())
      : complex(options, engine, nullptr),
        notifier(complex, engine),
        publisher(complex, engine, notifier),
        input(complex, engine, notifier, publisher) {
    AddBorder(complex, input);
    engine.requests.clear();
  }
  static MeshOptions Options() {
    MeshOptions options;
    options.dimension = D;
    options.quality = DefaultQuality(D);
    return options;
  }

  // A vertex from time `birth` on; 0: a point of the input, of feature 1 + its index.
  VertexIndex Add(const Point& p, sac::Stamp birth = 0) {
    if (birth == 0) return input.AddPoint(p, 1 + complex.elements.vertex_end());
    const VertexIndex v = complex.elements.NewVertex();
    Vertex<D>& vertex = complex.vertex(v);
    vertex.p = p;
    vertex.birth = birth;
    vertex.epoch = NearestEpoch();
    publisher.Publish(MakeOutput(Made::kVertex, v), birth);
    return v;
  }
  void Remove(VertexIndex v) { publisher.WithdrawVertex(v, complex.vertex(v).birth); }
  // A whole segment, visible from `exposed` to `death`. It is no feature: segments of a test may
  // overlap.
  SubsegmentIndex AddSubsegment(VertexIndex a, VertexIndex b, sac::Stamp exposed = 0,
                                sac::Stamp death = sac::kNoStamp) {
    const SubsegmentIndex s = complex.elements.NewSubsegment();
    Subsegment<D>& sub = complex.subsegment(s);
    const bool forward = complex.vertex(a).p < complex.vertex(b).p;
    sub.a = sub.whole_a = forward ? a : b;
    sub.b = sub.whole_b = forward ? b : a;
    sub.feature = 1;
    complex.border_only = false;
    publisher.Publish(MakeOutput(Made::kExposure, s), exposed);
    if (death != sac::kNoStamp) publisher.Publish(MakeOutput(Made::kDeath, s), death);
    return s;
  }
  // Of that Complete.
  Context At(sac::Stamp now, sac::Item item = 0, sac::Epoch epoch = NearestEpoch()) const {
    return Context(kComplete, item, epoch, now);
  }
  std::vector<VertexIndex> SeenAt(sac::Stamp now) const {
    std::vector<VertexIndex> seen;
    complex.elements.ForEachVertex([&](VertexIndex v, const Vertex<D>& vertex) {
      if (vertex.birth < now) seen.push_back(v);
    });
    return seen;
  }
  // The triangulation of those.
  TriangulationOf<D> TriangulationAt(sac::Stamp now) const {
    TriangulationOf<D> triangulation;
    complex.ResetToDomain(&triangulation);
    for (const VertexIndex v : SeenAt(now)) {
      if (!triangulation.Contains(v)) triangulation.Insert(v, complex.vertex(v).p, 0);
    }
    return triangulation;
  }

  Engine engine;
  Complex<D, test::RecordingEngine> complex;
  Notifier<D, test::RecordingEngine> notifier;
  Publisher<D, test::RecordingEngine> publisher;
  InputEditor<D, test::RecordingEngine> input;
};

// Point sets in the unit square or cube: in general position, or with ties everywhere.
enum class Layout { kRandom, kGrid, kRound, kClustered };
inline constexpr Layout kLayouts[] = {Layout::kRandom, Layout::kGrid, Layout::kRound,
                                      Layout::kClustered};

template <int D>
geometry::Point<D> RandomPlace(Layout layout, test::Random& random) {
  geometry::Point<D> p = {};
  switch (layout) {
    case Layout::kRandom:
      for (int k = 0; k < D; ++k) p[k] = random.Unit();
      break;
    case Layout::kGrid:
      for (int k = 0; k < D; ++k) p[k] = random.Below(D == 2 ? 6 : 4) * 0.125;
      break;
    case Layout::kRound: {  // on a circle or sphere of squared radius 25 or 9, exactly; or the
                            // middle
      static constexpr int kPlane[][3] = {{5, 0, 0}, {0, 5, 0}, {3, 4, 0}, {4, 3, 0}};
      static constexpr int kSpace[][3] = {{3, 0, 0}, {0, 3, 0}, {0, 0, 3},
                                          {1, 2, 2}, {2, 1, 2}, {2, 2, 1}};
      const auto& place = D == 2 ? kPlane[random.Below(4)] : kSpace[random.Below(6)];
      for (int k = 0; k < D; ++k) p[k] = 0.5 + (random.OneIn(2) ? 1 : -1) * place[k] / 16.0;
      if (random.OneIn(4)) p = RandomPlace<D>(Layout::kGrid, random);
      break;
    }
    case Layout::kClustered: {
      double scale = 1;
      for (int i = random.Below(30); i > 0; --i) scale /= 2;
      for (int k = 0; k < D; ++k) p[k] = 0.25 + scale * 0.5 * random.Unit();
      break;
    }
  }
  return p;
}

// About `count` places, no two equal, in random order.
template <int D>
std::vector<geometry::Point<D>> DistinctPlaces(Layout layout, int count, test::Random& random) {
  std::vector<geometry::Point<D>> places;
  for (int i = 0; i < count; ++i) {
    const auto p = RandomPlace<D>(layout, random);
    if (std::ranges::find(places, p) == places.end()) places.push_back(p);
  }
  return places;
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_TESTS_CORE_MESHING_LONE_COMPLEX_H_
