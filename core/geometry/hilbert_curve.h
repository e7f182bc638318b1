// The Hilbert curve through a square or a cube of 2^levels cells a side. Pure, thread-safe. One
// table look-up per level.
//
// A curve through 2^D parts visits them in the order of the Gray code. Each part contains the same
// curve again, rotated: it begins at corner `entry` of the part and ends at the neighbouring corner
// in direction `axis`. So each part ends next to the beginning of the following one. (entry, axis)
// is the state of the descent.
#ifndef DYNMESH_CORE_GEOMETRY_HILBERT_CURVE_H_
#define DYNMESH_CORE_GEOMETRY_HILBERT_CURVE_H_

#include <array>
#include <bit>
#include <cstdint>

namespace dynmesh::geometry {

template <int D>
class HilbertCurve {
 public:
  // The number of cells before `cell`. levels * D <= 32; coordinates below 2^levels.
  static std::uint32_t Key(const std::array<std::uint32_t, D>& cell, int levels) {
    std::uint32_t key = 0;
    unsigned state = 0;
    for (int level = levels - 1; level >= 0; --level) {
      unsigned part = 0;
      for (int i = 0; i < D; ++i) part |= (cell[i] >> level & 1) << i;
      const Step step = kSteps[state][part];
      key = key << D | step.place;
      state = step.state;
    }
    return key;
  }

 private:
  static constexpr unsigned kParts = 1u << D;

  struct Step {
    std::uint8_t place, state;  // rank of the part; state within the part
  };

  static constexpr unsigned Gray(unsigned i) { return i ^ i >> 1; }
  static constexpr unsigned Turn(unsigned bits, unsigned by) {
    return (bits << by | bits >> (D - by)) & (kParts - 1);
  }
  // The corner at which the curve within the i-th part begins (AxisOf: the axis along which it
  // ends), if the whole curve begins at 0 and ends along the last axis.
  static constexpr unsigned EntryOf(unsigned i) { return i == 0 ? 0 : Gray((i - 1) & ~1u); }
  static constexpr unsigned AxisOf(unsigned i) {
    if (i == 0) return 0;
    return static_cast<unsigned>(std::countr_one(i % 2 == 0 ? i - 1 : i)) % D;
  }

  static constexpr auto MakeSteps() {
    std::array<std::array<Step, kParts>, kParts * D> steps{};
    for (unsigned entry = 0; entry < kParts; ++entry) {
      for (unsigned axis = 0; axis < D; ++axis) {
        for (unsigned i = 0; i < kParts; ++i) {
          const unsigned turn = (axis + 1) % D;
          const unsigned part = Turn(Gray(i), turn) ^ entry;
          const unsigned next_entry = entry ^ Turn(EntryOf(i), turn);
          const unsigned next_axis = (axis + AxisOf(i) + 1) % D;
          steps[entry * D + axis][part] = {static_cast<std::uint8_t>(i),
                                           static_cast<std::uint8_t>(next_entry * D + next_axis)};
        }
      }
    }
    return steps;
  }
  static const std::array<std::array<Step, kParts>, kParts * D> kSteps;
};

template <int D>
constexpr std::array<std::array<typename HilbertCurve<D>::Step, HilbertCurve<D>::kParts>,
                     HilbertCurve<D>::kParts * D>
    HilbertCurve<D>::kSteps = HilbertCurve<D>::MakeSteps();

}  // namespace dynmesh::geometry

#endif  // DYNMESH_CORE_GEOMETRY_HILBERT_CURVE_H_
