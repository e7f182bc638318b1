// Steps from a cell to those of its size that touch it, itself among them: -1, 0 or 1 along each
// axis. An offset is their number to the base of 3, the first axis last. Constants.
#ifndef DYNMESH_CORE_QUADTREE_OFFSETS_H_
#define DYNMESH_CORE_QUADTREE_OFFSETS_H_

#include <array>
#include <cstddef>
#include <cstdint>

namespace dynmesh::quadtree {

template <int D>
class Offsets {
 private:
  static constexpr int Power(int base) {
    int power = 1;
    for (int k = 0; k < D; ++k) power *= base;
    return power;
  }

 public:
  static constexpr std::size_t kCount = Power(3), kChildren = Power(2);
  static constexpr std::size_t kNone = kCount / 2;  // no step along any axis

  // The step along axis k.
  static constexpr int Along(std::size_t offset, int k) {
    for (; k > 0; --k) offset /= 3;
    return static_cast<int>(offset % 3) - 1;
  }

  // From a child of a cell to a cell beside the child: the step from parent to parent, and which
  // child of the latter it is.
  struct Step {
    std::uint8_t between_parents, which;
  };
  using StepsOfChild = std::array<Step, kCount>;  // by offset
  static constexpr std::array<StepsOfChild, kChildren> kSteps = [] {
    std::array<StepsOfChild, kChildren> steps = {};
    for (std::size_t child = 0; child < kChildren; ++child) {
      for (std::size_t offset = 0; offset < kCount; ++offset) {
        std::size_t between_parents = 0, which = 0;
        for (int k = D - 1; k >= 0; --k) {
          const int at = static_cast<int>(child >> k & 1) + Along(offset, k);  // from -1 to 2
          between_parents = 3 * between_parents + static_cast<std::size_t>((at >> 1) + 1);
          which = 2 * which + static_cast<std::size_t>(at & 1);
        }
        steps[child][offset] = {static_cast<std::uint8_t>(between_parents),
                                static_cast<std::uint8_t>(which)};
      }
    }
    return steps;
  }();

  // From a cell to those of its size that touch its child: itself, and those on the child's sides.
  using Touching = std::array<std::uint8_t, kChildren>;
  static constexpr std::array<Touching, kChildren> kTouching = [] {
    std::array<Touching, kChildren> touching = {};
    for (std::size_t child = 0; child < kChildren; ++child) {
      for (std::size_t sides = 0; sides < kChildren; ++sides) {
        std::size_t offset = 0;
        for (int k = D - 1; k >= 0; --k) {
          const std::size_t towards = (child >> k & 1) != 0 ? 2 : 0;
          offset = 3 * offset + ((sides >> k & 1) != 0 ? towards : 1);
        }
        touching[child][sides] = static_cast<std::uint8_t>(offset);
      }
    }
    return touching;
  }();
};

}  // namespace dynmesh::quadtree

#endif  // DYNMESH_CORE_QUADTREE_OFFSETS_H_
