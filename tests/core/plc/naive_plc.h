// Oracle for Plc2 in the unit square: every rule, every pair, integers of 128 bits.
// Shares no code with core/plc. Finite coordinates must be multiples of 2^-52 of
// magnitude at most 2. O(n^2) per batch.
#ifndef DYNMESH_TESTS_CORE_PLC_NAIVE_PLC_H_
#define DYNMESH_TESTS_CORE_PLC_NAIVE_PLC_H_

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "dynmesh/feature.h"

namespace dynmesh::plc {

using FeatureMap = std::map<FeatureId, Feature>;

struct NaiveProblem {
  long edit = 0;
  std::string reason;
  std::vector<FeatureId> features;
  friend bool operator==(const NaiveProblem&, const NaiveProblem&) = default;
};

struct NaiveResult {
  // The features after the batch, if it is legal.
  FeatureMap features;
  // The problem that is to be reported, if it is not.
  std::optional<NaiveProblem> problem;
  // A distance or an angle is so near its bound that rounding decides: no verdict.
  bool ambiguous = false;
};

NaiveResult NaiveCheck(const FeatureMap& present, const std::vector<Edit>& batch);

}  // namespace dynmesh::plc

#endif  // DYNMESH_TESTS_CORE_PLC_NAIVE_PLC_H_
