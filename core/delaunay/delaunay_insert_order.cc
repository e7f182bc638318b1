// Biased randomized insertion order.
#include "core/delaunay/delaunay_insert_order.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/mix.h"
#include "core/geometry/hilbert_curve.h"

namespace dynmesh::delaunay {
namespace {

using geometry::Point;

// A point is in an earlier round than the last one with probability 2^-kRoundBits.
constexpr int kRoundBits = 4;
constexpr int kMaxRounds = 15;
constexpr int kKeyBits = 28;
constexpr std::size_t kSmallRun = 8;

struct Keyed {
  std::uint32_t key;
  std::uint32_t index;
  friend bool operator<(const Keyed& a, const Keyed& b) { return a.key < b.key; }
};

// Sorts by key, least significant digit first: O(n) per digit.
void RadixSort(std::vector<Keyed>* keyed, int key_bits) {
  constexpr int kDigitBits = 11;
  constexpr std::uint32_t kMask = (1u << kDigitBits) - 1;
  std::vector<Keyed> other(keyed->size());
  for (int shift = 0; shift < key_bits; shift += kDigitBits) {
    std::array<std::uint32_t, kMask + 1> start{};
    for (const Keyed& k : *keyed) ++start[k.key >> shift & kMask];
    std::uint32_t sum = 0;
    for (std::uint32_t& s : start) sum += std::exchange(s, sum);
    for (const Keyed& k : *keyed) other[start[k.key >> shift & kMask]++] = k;
    keyed->swap(other);
  }
}

// The round of the point with that rank along the curve. Round 0 is inserted first.
std::size_t RoundOf(std::uint32_t rank) {
  const int zeros = std::countr_zero(Mix(rank));
  return static_cast<std::size_t>(kMaxRounds - std::min(kMaxRounds, zeros / kRoundBits));
}

// The square (cube) around some points, with at least as many cells as points.
template <int D>
struct Frame {
  Point<D> low;
  double scale;  // 0 if the points have no extent
  int levels;

  Frame(std::span<const Point<D>> points, std::span<const Keyed> run) {
    constexpr double kHuge = std::numeric_limits<double>::infinity();
    Point<D> high;
    low.c.fill(kHuge);
    high.c.fill(-kHuge);
    for (const Keyed& k : run) {
      const Point<D>& p = points[k.index];
      for (int i = 0; i < D; ++i) {
        low[i] = std::min(low[i], p[i]);
        high[i] = std::max(high[i], p[i]);
      }
    }
    levels = std::min(kKeyBits / D, static_cast<int>(std::bit_width(run.size())) / D + 2);
    double side = 0;
    for (int i = 0; i < D; ++i) side = std::max(side, high[i] - low[i]);
    scale = side > 0 ? std::ldexp(1, levels) * (1 - 0x1p-40) / side : 0;
  }

  std::uint32_t Key(const Point<D>& p) const {
    std::array<std::uint32_t, D> cell;
    for (int i = 0; i < D; ++i) cell[i] = static_cast<std::uint32_t>((p[i] - low[i]) * scale);
    return geometry::HilbertCurve<D>::Key(cell, levels);
  }
};

// Sorts every long run of equal keys along a curve of its own frame, recursively. The two extreme
// points of a run fall into different cells, so runs get shorter. Each frame is a fraction of the
// one before, so the depth is bounded by the exponents of doubles.
template <int D>
void RefineRuns(std::span<const Point<D>> points, std::span<Keyed> sorted, Steps& steps) {
  std::vector<std::span<Keyed>> pending = {sorted};
  while (!pending.empty()) {
    const std::span<Keyed> part = pending.back();
    pending.pop_back();
    for (std::size_t i = 0, j = 0; i < part.size(); i = j) {
      while (j < part.size() && part[j].key == part[i].key) ++j;
      const std::span<Keyed> run = part.subspan(i, j - i);
      if (steps.Stop(run.size())) return;
      if (run.size() <= kSmallRun) continue;
      const Frame<D> frame(points, run);
      if (frame.scale == 0) continue;
      for (Keyed& k : run) k.key = frame.Key(points[k.index]);
      std::sort(run.begin(), run.end());
      pending.push_back(run);
    }
  }
}

template <int D>
std::vector<std::uint32_t> OrderOf(std::span<const Point<D>> points, Steps& steps) {
  std::vector<Keyed> keyed(points.size());
  for (std::uint32_t i = 0; i < points.size(); ++i) keyed[i].index = i;
  const Frame<D> frame(points, keyed);
  for (Keyed& k : keyed) {
    if (steps.Stop()) return {};
    k.key = frame.Key(points[k.index]);
  }
  RadixSort(&keyed, D * frame.levels);
  RefineRuns(points, std::span(keyed), steps);
  if (steps.stopped()) return {};
  // Sorts by rounds; stable.
  std::array<std::uint32_t, kMaxRounds + 1> start{};
  for (std::uint32_t rank = 0; rank < keyed.size(); ++rank) {
    keyed[rank].key = static_cast<std::uint32_t>(RoundOf(rank));
    ++start[keyed[rank].key];
  }
  std::uint32_t sum = 0;
  for (std::uint32_t& s : start) sum += std::exchange(s, sum);
  std::vector<std::uint32_t> order(keyed.size());
  for (const Keyed& k : keyed) order[start[k.key]++] = k.index;
  return order;
}

}  // namespace

std::vector<std::uint32_t> InsertOrder(std::span<const geometry::Point2> points, Steps& steps) {
  return OrderOf(points, steps);
}
std::vector<std::uint32_t> InsertOrder(std::span<const geometry::Point3> points, Steps& steps) {
  return OrderOf(points, steps);
}
std::vector<std::uint32_t> InsertOrder(std::span<const geometry::Point2> points) {
  AllSteps all;
  return OrderOf(points, all);
}
std::vector<std::uint32_t> InsertOrder(std::span<const geometry::Point3> points) {
  AllSteps all;
  return OrderOf(points, all);
}

}  // namespace dynmesh::delaunay
