// A sum with a rounding error that does not grow with the number of terms (Neumaier 1974).
#ifndef DYNMESH_CORE_TRANSFER_COMPENSATED_SUM_H_
#define DYNMESH_CORE_TRANSFER_COMPENSATED_SUM_H_

#include <cmath>

namespace dynmesh::transfer {

class Sum {
 public:
  void Add(double term) {
    const double sum = sum_ + term;
    rest_ += std::abs(sum_) >= std::abs(term) ? (sum_ - sum) + term : (term - sum) + sum_;
    sum_ = sum;
  }
  double value() const { return sum_ + rest_; }

 private:
  double sum_ = 0, rest_ = 0;
};

}  // namespace dynmesh::transfer

#endif  // DYNMESH_CORE_TRANSFER_COMPENSATED_SUM_H_
