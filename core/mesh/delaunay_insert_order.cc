// Biased randomized insertion order.
#include "core/mesh/delaunay_insert_order.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

namespace dynmesh::mesh {
namespace {

using geometry::Point2;

// A point belongs to one of the earlier rounds with probability 2^-kRoundBits.
constexpr int kRoundBits = 4;
constexpr int kMaxRounds = 15;
constexpr int kMaxLevels = 14;  // 28 bits of key, and 4 for the round
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

// How far along the Hilbert curve through a square of 2^levels cells a side (x, y) is.
std::uint32_t HilbertKey(std::uint32_t x, std::uint32_t y, int levels) {
  std::uint32_t key = 0;
  for (int s = levels - 1; s >= 0; --s) {
    const std::uint32_t in_x = (x >> s) & 1;
    const std::uint32_t in_y = (y >> s) & 1;
    key = key << 2 | ((3 * in_x) ^ in_y);
    // In the lower quadrants the curve is the whole curve with x and y exchanged, on the
    // right also turned round; change the coordinates instead of the curve.
    const std::uint32_t exchange = in_y == 0 ? x ^ y : 0;
    const std::uint32_t turn = in_y == 0 ? 0 - in_x : 0;
    x ^= exchange ^ turn;
    y ^= exchange ^ turn;
  }
  return key;
}

// Round 0 is inserted first.
std::uint32_t RoundOf(const Point2& p) {
  const int zeros = std::countr_zero(geometry::HashOf(p));
  return static_cast<std::uint32_t>(kMaxRounds - std::min(kMaxRounds, zeros / kRoundBits));
}

// The square around some points, with about as many cells as there are points.
struct Frame {
  Point2 low;
  double scale;  // 0 if they have no extent
  int levels;

  Frame(std::span<const Point2> points, std::span<const Keyed> run) {
    constexpr double kHuge = std::numeric_limits<double>::infinity();
    low = {{kHuge, kHuge}};
    Point2 high{{-kHuge, -kHuge}};
    for (const Keyed& k : run) {
      const Point2& p = points[k.index];
      for (int i = 0; i < 2; ++i) {
        low[i] = std::min(low[i], p[i]);
        high[i] = std::max(high[i], p[i]);
      }
    }
    levels = std::min(kMaxLevels, static_cast<int>(std::bit_width(run.size())) / 2 + 2);
    const double side = std::max(high[0] - low[0], high[1] - low[1]);
    scale = side > 0 ? std::ldexp(1, levels) * (1 - 0x1p-40) / side : 0;
  }

  std::uint32_t Key(const Point2& p) const {
    return HilbertKey(static_cast<std::uint32_t>((p[0] - low[0]) * scale),
                      static_cast<std::uint32_t>((p[1] - low[1]) * scale), levels);
  }
};

// Orders every long run of equal keys along a curve of its own frame, and so on. The two
// extreme points of a run fall into different cells, so runs get shorter; as each frame
// is a fraction of the one before, the depth is bounded by the exponents of doubles.
void RefineRuns(std::span<const Point2> points, std::span<Keyed> sorted) {
  std::vector<std::span<Keyed>> pending = {sorted};
  while (!pending.empty()) {
    const std::span<Keyed> part = pending.back();
    pending.pop_back();
    for (std::size_t i = 0, j = 0; i < part.size(); i = j) {
      while (j < part.size() && part[j].key == part[i].key) ++j;
      const std::span<Keyed> run = part.subspan(i, j - i);
      if (run.size() <= kSmallRun) continue;
      const Frame frame(points, run);
      if (frame.scale == 0) continue;
      for (Keyed& k : run) k.key = frame.Key(points[k.index]);
      std::sort(run.begin(), run.end());
      pending.push_back(run);
    }
  }
}

}  // namespace

std::vector<std::uint32_t> InsertOrder(std::span<const Point2> points) {
  std::vector<Keyed> keyed(points.size());
  for (std::uint32_t i = 0; i < points.size(); ++i) keyed[i].index = i;
  const Frame frame(points, keyed);
  for (Keyed& k : keyed) {
    const Point2& p = points[k.index];
    k.key = RoundOf(p) << (2 * frame.levels) | frame.Key(p);
  }
  RadixSort(&keyed, 2 * frame.levels + 4);
  RefineRuns(points, keyed);
  std::vector<std::uint32_t> order;
  order.reserve(keyed.size());
  for (const Keyed& k : keyed) order.push_back(k.index);
  return order;
}

}  // namespace dynmesh::mesh
