// The qualities and criteria that every kind of input is meshed with.
#ifndef DYNMESH_TESTS_SUPPORT_ASKED_H_
#define DYNMESH_TESTS_SUPPORT_ASKED_H_

#include <iterator>

#include "dynmesh/options.h"

namespace dynmesh::test {

struct Asked {
  const char* name;
  double quality;
  Criterion criterion;
  double min_dihedral = 0;
};

inline constexpr Asked kAsked[] = {{"Rho2", 2.0, Criterion::kEdge},
                                   {"RhoSqrt2", kDefaultQuality2D, Criterion::kEdge},
                                   {"Rho1p2", 1.2, Criterion::kEdge},
                                   {"Rho1", 1.0, Criterion::kEdge},
                                   {"ThesisRho2", 2.0, Criterion::kThesis},
                                   {"ThesisRhoSqrt2", kDefaultQuality2D, Criterion::kThesis},
                                   {"ThesisRho1p6", 1.6, Criterion::kThesis}};
inline constexpr Asked kAskedInSpace[] = {
    {"Rho2", kDefaultQuality3D, Criterion::kEdge},
    {"RhoSqrt2", kDefaultQuality2D, Criterion::kEdge},
    {"ThesisRho2", kMinThesisQuality3D, Criterion::kThesis},
    {"Cured10", kDefaultQuality3D, Criterion::kEdge, 10},
    {"Cured15RhoSqrt2", kDefaultQuality2D, Criterion::kEdge, 15}};
inline constexpr int kAskedCount = static_cast<int>(std::size(kAsked));
inline constexpr int kAskedInSpaceCount = static_cast<int>(std::size(kAskedInSpace));

}  // namespace dynmesh::test

#endif  // DYNMESH_TESTS_SUPPORT_ASKED_H_
