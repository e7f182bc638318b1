// Angles told apart without computing them. A *key* of an angle is a number that decreases as the
// angle grows from 0 to 180 degrees, and is cheap: a cotangent, or a cosine times its magnitude.
// Pure.
#ifndef DYNMESH_CORE_QUALITY_ANGLE_STEPS_H_
#define DYNMESH_CORE_QUALITY_ANGLE_STEPS_H_

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>

namespace dynmesh::quality {

inline double Radians(double degrees) { return degrees * (std::numbers::pi / 180); }

// Infinite for 0 and 180 degrees, of which nothing is greater or less.
inline double CotangentOf(double degrees) {
  if (degrees <= 0) return std::numeric_limits<double>::infinity();
  if (degrees >= 180) return -std::numeric_limits<double>::infinity();
  return std::cos(Radians(degrees)) / std::sin(Radians(degrees));
}

// cos |cos|.
inline double SignedSquaredCosineOf(double degrees) {
  const double cosine = std::cos(Radians(degrees));
  return cosine * std::fabs(cosine);
}

// The range from 0 to 180 degrees in kSteps equal steps.
template <std::size_t kSteps>
class AngleSteps {
 public:
  explicit AngleSteps(double (*key_of)(double degrees)) {
    key_.fill(-std::numeric_limits<double>::infinity());
    key_[0] = std::numeric_limits<double>::infinity();
    for (std::size_t k = 1; k < kSteps; ++k) {
      key_[k] = key_of(180.0 * static_cast<double>(k) / kSteps);
    }
  }

  // The step with a key.
  std::size_t StepOf(double key) const {
    std::size_t step = 0;
    for (std::size_t width = kWidth / 2; width > 0; width /= 2) {
      step += key <= key_[step + width] ? width : 0;
    }
    return step;
  }
  // Is the key by more than `slack` within that step?
  bool IsInside(std::size_t step, double key, double slack) const {
    return key + slack < key_[step] && key - slack > key_[step + 1];
  }

 private:
  static constexpr std::size_t kWidth = 64;
  static_assert(kSteps < kWidth);
  std::array<double, kWidth + 1> key_;  // at the least angle of each step, then beyond all
};

}  // namespace dynmesh::quality

#endif  // DYNMESH_CORE_QUALITY_ANGLE_STEPS_H_
