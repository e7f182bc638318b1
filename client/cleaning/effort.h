// The work of cleaning in steps: pairs of simplices that are compared; lines in a face, and nodes
// and triangles, count a fraction. A step takes about a microsecond. Counts are functions of the
// input's coordinates, so a bound of them is, too.
#ifndef DYNMESH_CLIENT_CLEANING_EFFORT_H_
#define DYNMESH_CLIENT_CLEANING_EFFORT_H_

#include <cstdint>

namespace dynmesh::cleaning {

class Effort {
 public:
  explicit Effort(std::uint64_t most) : left_(most) {}

  // Counts steps. False, and from then on: there were more than allowed.
  bool Take(std::uint64_t steps) {
    is_spent_ = is_spent_ || steps > left_;
    left_ -= is_spent_ ? 0 : steps;
    return !is_spent_;
  }
  // As if there were none left.
  void Spend() { is_spent_ = true; }
  bool is_spent() const { return is_spent_; }
  std::uint64_t left() const { return left_; }

 private:
  std::uint64_t left_;
  bool is_spent_ = false;
};

}  // namespace dynmesh::cleaning

#endif  // DYNMESH_CLIENT_CLEANING_EFFORT_H_
