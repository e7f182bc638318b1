// Mutation tests. A *term* is a rule or a reason that the code follows. A test build
// (DYNMESH_MUTATE) can switch off any one of them; then a test must fail (tests/mutation). In other
// builds they cost nothing. Each layer lists its terms in an enum of its own, the last of which is
// kCount.
#ifndef DYNMESH_CORE_BASE_MUTATION_H_
#define DYNMESH_CORE_BASE_MUTATION_H_

namespace dynmesh {

#ifdef DYNMESH_MUTATE
template <class Term>
inline Term switched_off = Term::kCount;  // kCount: none
template <class Term>
inline bool IsOn(Term term) {
  return term != switched_off<Term>;
}
#else
template <class Term>
constexpr bool IsOn(Term) {
  return true;
}
#endif

}  // namespace dynmesh

#endif  // DYNMESH_CORE_BASE_MUTATION_H_
