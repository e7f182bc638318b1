// The elements of refinement (vertices and subsegments), and how its time is divided into epochs.
#ifndef DYNMESH_CORE_MESHING_ELEMENTS_H_
#define DYNMESH_CORE_MESHING_ELEMENTS_H_

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <type_traits>

#include "core/base/rounding.h"
#include "core/geometry/point.h"
#include "core/meshing/read_cover.h"
#include "core/meshing/rules.h"
#include "core/meshing/shells.h"
#include "core/sac/engine.h"

namespace dynmesh::meshing {

using VertexIndex = std::uint32_t;
using SubsegmentIndex = std::uint32_t;
using FeatureSlot = std::uint32_t;  // an input feature; the box's own are slot 0
inline constexpr std::uint32_t kNil = ~std::uint32_t{0};
inline constexpr int kMostOutputs = 255;  // vertices that one operation may make

// Procedures. kNearest and kComplete work on vertices, kCure on slivers, the others on subsegments.
enum Procedure : sac::Kind {
  kNearest,   // ComputeNN: when does the vertex's first Complete come?
  kComplete,  // insert Steiner points until no edge that it owns has a gap
  kCheck,     // a new subsegment: split it if it is encroached, else expose it
  kSplit,     // split it: a vertex encroaches on it
  kRecheck,   // split it if it is encroached as of now
  kPresplit,  // a subsegment: halve it if a disjoint feature is too near, else check it
  kCure,      // a sliver: insert a point that unmakes it and makes none
};

// Time. Epochs run through buckets, each bucket through rounds, each round through steps of segment
// work and then the quality work. Bucket 0 is the input's. In its round 0 segments are split
// because of features near them, in round 1 until none is encroached. Then every vertex finds its
// nearest neighbour.
inline constexpr int kSubBits = 24, kRoundBits = 24;  // the bucket has 16
inline constexpr std::uint64_t kQualityStep = (std::uint64_t{1} << kSubBits) - 1;

inline sac::Epoch MakeEpoch(std::uint64_t bucket, std::uint64_t round, std::uint64_t step) {
  return bucket << (kSubBits + kRoundBits) | round << kSubBits | step;
}
inline int BucketOfEpoch(sac::Epoch e) { return static_cast<int>(e >> (kSubBits + kRoundBits)); }
inline std::uint64_t RoundOfEpoch(sac::Epoch e) {
  return e >> kSubBits & ((std::uint64_t{1} << kRoundBits) - 1);
}
inline std::uint64_t StepOfEpoch(sac::Epoch e) { return e & kQualityStep; }
inline bool IsQualityEpoch(sac::Epoch e) { return StepOfEpoch(e) == kQualityStep; }

inline constexpr sac::Epoch kBirthOfInput = 0;
// The epoch of subsegments after `depth` splits. Step 0 is the beginning.
inline sac::Epoch PresplitEpoch(int depth = 0) {
  return MakeEpoch(0, 0, static_cast<std::uint64_t>(depth) + 1);
}
inline sac::Epoch FirstCheckEpoch() { return MakeEpoch(0, 1, 0); }
// Cures come after all buckets.
inline sac::Epoch CureEpoch(std::uint64_t round) {
  return MakeEpoch(kBuckets, round, kQualityStep);
}
inline sac::Epoch NearestEpoch() { return MakeEpoch(0, 1, kQualityStep); }

// A point of the lattice about an edge (sharp_facets.h), by the coarsest lattice that contains it.
struct LatticeIndex {
  int halvings = 0;           // of the edge's length, until there is one step
  std::int64_t i = 0, j = 0;  // the steps along its row, and the row
  friend bool operator==(const LatticeIndex&, const LatticeIndex&) = default;
};
// A common edge of two features, by its ends, or a common corner, twice.
using Axis = std::array<VertexIndex, 2>;
inline constexpr Axis kNoAxis = {kNil, kNil};
// What put a vertex where it is on a facet (sharp_facets.h). Of a counterpart: the vertex that it
// is one of, and the axis. Of a point of the lattice about an edge: the edge, and which point. Else
// there is no axis.
struct Origin {
  VertexIndex of = kNil;
  Axis axis = kNoAxis;
  LatticeIndex at = {};
  friend bool operator==(const Origin&, const Origin&) = default;
};

template <int D>
struct Vertex {
  geometry::Point<D> p = {};
  sac::Epoch epoch = kBirthOfInput;  // of its creator
  sac::Stamp birth = 0;              // its creator's time, or beginning()
  sac::OpId operations = sac::kNoOp;
  sac::OpId creator = sac::kNoOp;  // untraced: the creator's item
  FeatureSlot feature = kNil;      // the feature that it lies on
  std::uint8_t dimension = D;      // containing dimension, 0 to D
  std::uint8_t ordinal = 0;        // which of its creator's outputs
  bool present = false;            // published and not withdrawn
  bool in_mesh = false;            // part of the last reported mesh
  bool changed = false;            // stands in the list of changes
};

template <int D>
bool IsOfCure(const Vertex<D>& v) {
  return v.epoch >= CureEpoch(0);
}

template <int D>
struct Subsegment {
  VertexIndex a = kNil, b = kNil;              // the lesser end of the segment first
  VertexIndex whole_a = kNil, whole_b = kNil;  // ends of the segment
  FeatureSlot feature = kNil;
  SplitRule split_rule;
  // Quality work sees it from its exposure (a Check found it clean) until its death (a split).
  sac::Stamp exposed = sac::kNoStamp;
  sac::Stamp death = sac::kNoStamp;
  sac::OpId operations = sac::kNoOp;
  std::array<sac::Place, 1 << D> places = {};
  std::uint8_t place_count = 0;
  std::uint8_t depth = 0;  // halvings since the input segment
  bool in_mesh = false;
  bool changed = false;
};

// Must it stay whole? Then it is a whole segment of the input.
template <int D>
bool IsUnsplit(const Subsegment<D>& s) {
  return s.split_rule.kind == SplitRule::Kind::kUnsplit;
}

inline float RoundedUp(double x) {
  const float f = static_cast<float>(x);
  return f < x ? std::nextafter(f, INFINITY) : f;
}
// Rounds up to 7 bits behind the leading one. So a small error of x rarely changes the result.
inline float RoundedFarUp(double x) {
  constexpr std::uint32_t kRest = (1u << 16) - 1;
  return std::bit_cast<float>((std::bit_cast<std::uint32_t>(RoundedUp(x)) + kRest) & ~kRest);
}

// What an operation keeps beside its reads. Small, as every operation has one.
template <int D>
class Payload {
 public:
  using Point = geometry::Point<D>;

  // kComplete: no vertex beyond this squared distance can be in a ball that was read. kNearest: no
  // squared distance in the bucket of the nearest vertex is greater. Rounded up.
  float radius2 = 0;
  // kComplete, by edges: the radius of the largest ball that was judged by target lengths, rounded
  // up; INFINITY if it is not known. It is a cache: no result depends on it.
  float most_judged = INFINITY;
  // kComplete: a candidate yielded to encroached subsegments, or was kept out by them. kCure: a
  // candidate encroached on a subsegment. Checks: encroached (then the reads are the witnesses).
  // kPresplit: a feature is too near (then radius2 is its squared distance, and the reads name it
  // unless a facet is nearer).
  std::uint32_t flag : 1 = 0;

  // kComplete: may a ball have been judged that is larger than this radius? Every ball read is in
  // the cover.
  bool MayHaveJudged(double radius) const {
    return most_judged > radius && radius2 > 4 * radius * radius;
  }
  // No ball that was judged reaches farther from the vertex. All of them have it on their boundary.
  double MostReach() const {
    return std::min(2.0 * most_judged * kWider, std::sqrt(double{radius2}) * kWider);
  }
  // kComplete: stores the balls of `cover`, coarsely. `doubt`: an error bound of its measures.
  // False if such an error could change the stored bits.
  bool SetCover(const ReadCover<D>& cover, double doubt = 0) {
    const double r2 = cover.radius2(), doubt2 = doubt > 0 ? doubt * (2 * std::sqrt(r2) + doubt) : 0;
    radius2 = RoundedFarUp(r2 + doubt2);
    bool is_certain = RoundedFarUp(r2 - doubt2) == radius2;
    // If the radius overflows, nothing is known of the extents either.
    const double radius = radius2 < INFINITY ? std::sqrt(radius2) * kNarrower : 0;
    const auto fraction = [&](double distance, int units) {
      const auto rounded = [&](double d) {
        const double x = std::min<double>(units, d / radius * units);  // a NaN becomes `units`
        const auto down = static_cast<std::uint32_t>(std::max(x, 0.0));
        return down + (down < x ? 1 : 0);
      };
      const std::uint32_t most = rounded(distance + doubt);
      if (doubt > 0 && rounded(distance - doubt) != most) is_certain = false;
      return most;
    };
    const Point &p = cover.centre(), lo = {cover.box().lo}, hi = {cover.box().hi};
    std::uint32_t all = 0;
    for (int k = 0; k < D; ++k) {
      all |= fraction(p[k] - lo[k], kExtentUnits) << (2 * k * kExtentBits) |
             fraction(hi[k] - p[k], kExtentUnits) << ((2 * k + 1) * kExtentBits);
    }
    extents_ = all;
    if constexpr (kByOrthant) {
      outline_ = 0;
      for (int o = 0; o < ReadCover<D>::kOrthants; ++o) {
        outline_ |= fraction(cover.Reach(o), kReachUnits) << (o * kReachBits);
      }
    }
    return is_certain;
  }
  // May y be in one of the balls, p being their vertex? Conservative: may return true needlessly,
  // never false wrongly.
  bool CoverMayHold(const Point& p, const Point& y) const {
    constexpr double kPart2 = 1.0 / (kExtentUnits * kExtentUnits);
    double sum = 0;
    int orthant = 0;
    for (int k = 0; k < D; ++k) {
      const double d = y[k] - p[k], d2 = d * d;
      const int up = d < 0 ? 0 : 1;
      const double extent = Bits(extents_, 2 * k + up, kExtentBits);
      if (!(d2 <= extent * extent * (radius2 * kPart2))) return false;
      sum += d2;
      orthant |= up << k;
    }
    if constexpr (kByOrthant) {
      const double reach = Bits(outline_, orthant, kReachBits) * (1.0 / kReachUnits);
      return sum <= reach * reach * radius2;
    }
    return sum <= radius2;
  }
  // What SetCover stored beside the radius, as one number.
  std::uint64_t cover() const {
    if constexpr (kByOrthant) return std::uint64_t{outline_} << 32 | extents_;
    return extents_;
  }

 private:
  // Not in 2D: there the test that follows costs less than this one.
  static constexpr bool kByOrthant = D > 2;
  static constexpr int kExtentBits = D == 2 ? 6 : 5, kReachBits = 4;
  static constexpr int kExtentUnits = (1 << kExtentBits) - 1, kReachUnits = (1 << kReachBits) - 1;
  struct Nothing {};

  static int Bits(std::uint32_t word, int i, int bits) {
    return static_cast<int>(word >> (i * bits)) & ((1 << bits) - 1);
  }

  // In fractions of the radius, rounded up. extents_: how far the balls extend from the vertex
  // along each axis, downwards and upwards. outline_: how far in each orthant.
  std::uint32_t extents_ : 2 * D* kExtentBits = 0;
  [[no_unique_address]] std::conditional_t<kByOrthant, std::uint32_t, Nothing> outline_ = {};
};

// Outputs are tagged words.
enum class Made : std::uint32_t { kVertex, kSubsegment, kExposure, kDeath };
inline sac::Output MakeOutput(Made what, std::uint32_t index) {
  return index << 2 | static_cast<std::uint32_t>(what);
}
inline Made WhatOf(sac::Output o) { return static_cast<Made>(o & 3); }
inline std::uint32_t IndexOf(sac::Output o) { return o >> 2; }

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_ELEMENTS_H_
