// The kinds of features, told apart so that the compiler finds what has not heard of a new one.
//
//   Visit(
//       f, [&](const ASegment& s) { Add(s.ends[0], s.ends[1]); },
//       [&](const APolygon& p) { ForEachEdgeOf(p.rings, Add); }, Ignore<APoint, ASize>);
//   if (!Is<APolygon>(f, Not<APoint, ASegment, ASize>)) continue;
//   if (IsPoint(f)) position.emplace(f.id, f.position);
//
// Visit and Is name all kinds, or do not compile. Only IsPoint names one: points are what other
// features refer to, whatever kinds there are. Nothing else in core, server and client compares
// Feature::kind but a switch without `default` (a test, Source.kinds, looks for that).
//
// To add a kind: an enumerator of FeatureKind and its members in Feature, a view of it here, and
// its case in Visit. The compiler lists the rest: each Visit, each Is and each switch that has to
// say what it does with the new kind.
//
// A Feature stays one struct with the members of all kinds: its users fill it in by name, and a
// move or a removal has no kind. A view is what one kind uses of it; it refers to the Feature.
#ifndef DYNMESH_CORE_BASE_FEATURE_KINDS_H_
#define DYNMESH_CORE_BASE_FEATURE_KINDS_H_

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <type_traits>

#include "dynmesh/feature.h"

namespace dynmesh {

struct APoint {
  static constexpr FeatureKind kKind = FeatureKind::kPoint;
  FeatureId id;
  const std::array<double, 3>& position;
};
struct ASegment {
  static constexpr FeatureKind kKind = FeatureKind::kSegment;
  FeatureId id;
  const std::array<FeatureId, 2>& ends;
  bool unsplit;
};
struct APolygon {
  static constexpr FeatureKind kKind = FeatureKind::kPolygon;
  FeatureId id;
  const Rings& rings;
  bool unsplit;
};
struct ASize {
  static constexpr FeatureKind kKind = FeatureKind::kSize;
  FeatureId id;
  const std::array<double, 3>& position;
  const Sizing& sizing;
  const Rings& rings;
};

// A list of views, as a value.
template <class... Views>
struct Kinds {
  static constexpr std::size_t kCount = sizeof...(Views);
  template <class View>
  static constexpr bool kHas = (std::is_same_v<View, Views> || ...);
};
using AllKinds = Kinds<APoint, ASegment, APolygon, ASize>;

namespace kinds_internal {

template <class... Views>
inline constexpr bool kAreDifferent = true;
template <class View, class... Views>
inline constexpr bool kAreDifferent<View, Views...> =
    !Kinds<Views...>::template kHas<View> && kAreDifferent<Views...>;

template <class View>
struct Nothing {
  void operator()(const View&) const {}
};

template <class... Cases>
struct Overload : Cases... {
  using Cases::operator()...;
};
template <class... Cases>
Overload(Cases...) -> Overload<Cases...>;

// Each kind once?
template <class... Views>
inline constexpr bool kAreAll = kAreDifferent<Views...> && sizeof...(Views) == AllKinds::kCount;

}  // namespace kinds_internal

// For code with a list, a table or a function of each kind, which nothing else would lead to:
//   static_assert(kAreAllKinds<APoint, ASegment, APolygon, ASize>);
template <class... Views>
inline constexpr bool kAreAllKinds = kinds_internal::kAreAll<Views...>;

// Of Visit: the case that does nothing, for these kinds.
template <class... Views>
inline constexpr kinds_internal::Overload<kinds_internal::Nothing<Views>...> Ignore = {};

// Of Is: the kinds that are not meant.
template <class... Views>
inline constexpr Kinds<Views...> Not = {};

// What the case for the kind of `f` returns. There is one for each kind; all return the same type.
// A feature of no kind, which validation refuses, is not visited: R().
template <class... Cases>
auto Visit(const Feature& f, const Cases&... cases) {
  const kinds_internal::Overload on{cases...};
  static_assert(!std::is_invocable_v<decltype(on), AllKinds>,
                "a case for any kind would hide a new one");
  using R = std::invoke_result_t<decltype(on), APoint>;
  switch (f.kind) {
    case FeatureKind::kPoint:
      return on(APoint{f.id, f.position});
    case FeatureKind::kSegment:
      return on(ASegment{f.id, f.ends, f.unsplit});
    case FeatureKind::kPolygon:
      return on(APolygon{f.id, f.rings, f.unsplit});
    case FeatureKind::kSize:
      return on(ASize{f.id, f.position, f.sizing, f.rings});
  }
  return R();
}

// True if `f` is of one of the `Chosen` kinds. All others are named, too.
template <class... Chosen, class... Others>
constexpr bool Is(const Feature& f, Kinds<Others...>) {
  static_assert(kAreAllKinds<Chosen..., Others...>,
                "say of each kind of feature, once, whether it is meant here or not");
  return ((f.kind == Chosen::kKind) || ...);
}

// The number of them, as Is.
template <class... Chosen, class... Others>
std::size_t CountOf(std::span<const Feature> features, Kinds<Others...> others) {
  return static_cast<std::size_t>(
      std::ranges::count_if(features, [&](const Feature& f) { return Is<Chosen...>(f, others); }));
}

constexpr bool IsPoint(const Feature& f) { return f.kind == FeatureKind::kPoint; }

// Calls `use` with the id of each point that the feature names, in its order.
template <class Use>
void ForEachPointOf(const Feature& f, const Use& use) {
  const auto of_rings = [&](const auto& view) {
    for (const auto& ring : view.rings) {
      for (const FeatureId id : ring) use(id);
    }
  };
  Visit(
      f,
      [&](const ASegment& s) {
        for (const FeatureId id : s.ends) use(id);
      },
      [&](const APolygon& p) { of_rings(p); }, [&](const ASize& s) { of_rings(s); },
      Ignore<APoint>);
}

}  // namespace dynmesh

#endif  // DYNMESH_CORE_BASE_FEATURE_KINDS_H_
