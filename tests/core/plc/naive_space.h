// Oracle for Plc<3> in the unit cube: the faults of a set of features, every pair, by exact
// rationals and from the definitions: common points, distances, angles. Shares no code with
// core/plc. Does not determine the blamed feature. Features must be complete: ends and corners
// present, rings combinatorially valid, coordinates finite and in the cube.
#ifndef DYNMESH_TESTS_CORE_PLC_NAIVE_SPACE_H_
#define DYNMESH_TESTS_CORE_PLC_NAIVE_SPACE_H_

#include <set>
#include <string>
#include <vector>

#include "dynmesh/feature.h"
#include "tests/core/plc/naive_plc.h"

namespace dynmesh::plc {

struct Offence {
  std::string what;  // for messages
  // The possible ids of both sides: an edge has those of all its polygons. One side only: a polygon
  // by itself.
  std::set<FeatureId> one, other;
};

// `limit` is the close limit.
std::vector<Offence> FindOffences(const FeatureMap& features, double limit);

}  // namespace dynmesh::plc

#endif  // DYNMESH_TESTS_CORE_PLC_NAIVE_SPACE_H_
