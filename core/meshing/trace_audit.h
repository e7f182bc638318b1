// The trace of refinement, checked, hashed and described: for tests and for people.
#ifndef DYNMESH_CORE_MESHING_TRACE_AUDIT_H_
#define DYNMESH_CORE_MESHING_TRACE_AUDIT_H_

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/meshing/refinement.h"

namespace dynmesh::meshing {

// An operation, to compare traces: hashes of its kind, item and time; and of these and all that it
// made, requested and read.
struct OperationHash {
  std::uint64_t identity = 0, whole = 0;
  sac::OpId op = sac::kNoOp;
};

// Checks the invariants of engine and program; returns the hash of the whole trace. `operations`,
// if given, gets all operations in the order of time. Untraced: 0.
template <int D, template <class> class E>
std::uint64_t Audit(const Refinement<D, E>& refinement, std::vector<std::string>* problems,
                    std::vector<OperationHash>* operations = nullptr);

// True if the operation, executed again as of its time, makes, requests and reads what its record
// says; else *why, if given, says what differs (engine_audit.h). So no change since it ran last has
// been missed. Of reads that are not determined (which witness, which reason against a candidate)
// each must still be there. What the new run makes beyond its record is released.
// REQUIRES: the last propagation is complete; no triangulation is attached.
template <int D>
bool Reproduces(Refinement<D, sac::Engine>& refinement, sac::OpId op, std::string* why = nullptr);

// The first operation, in the order of time, that does not: what differs, and its record. Empty if
// all do. As a run from scratch without a triangulation, O(trace).
template <int D>
std::string FirstUnreproduced(Refinement<D, sac::Engine>& refinement);

// The name of a procedure.
std::string_view NameOf(Procedure procedure);
// The vertices that the operation names as read, and ghosts (Star<D>::IsGhost).
template <int D>
std::vector<VertexIndex> VerticesReadBy(const Refinement<D, sac::Engine>& refinement, sac::OpId op);

// For people: kind, item and time of an operation, what it made and what it read.
template <int D, template <class> class E>
std::string Describe(const Refinement<D, E>& refinement, sac::OpId op);

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_TRACE_AUDIT_H_
