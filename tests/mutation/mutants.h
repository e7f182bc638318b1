// Mutants: the program with one of its terms switched off (core/base/mutation.h). A program of
// mutants links existing tests, built with the terms. For each mutant it starts itself once more,
// with that term off and the tests that are to notice only. A mutant with which these tests pass
// has survived: then the tests are too weak.
#ifndef DYNMESH_TESTS_MUTATION_MUTANTS_H_
#define DYNMESH_TESTS_MUTATION_MUTANTS_H_

#include <gtest/gtest.h>

#include <span>
#include <string>
#include <vector>

#include "core/base/mutation.h"

namespace dynmesh::test {

struct Mutant {
  const char* name;
  const char* tests;  // as --gtest_filter: one of these fails
  void (*apply)();
};

// Of the term called NAME in the enum TERM.
#define DYNMESH_MUTANT(TERM, NAME, TESTS)                 \
  Mutant {                                                \
#NAME, TESTS, [] { switched_off<TERM> = TERM::NAME; } \
  }

// The program's mutants. Each program defines this.
std::span<const Mutant> Mutants();

class MutantTest : public testing::TestWithParam<Mutant> {};
std::string NameOf(const testing::TestParamInfo<Mutant>& given);
std::ostream& operator<<(std::ostream& out, const Mutant& mutant);

}  // namespace dynmesh::test

#endif  // DYNMESH_TESTS_MUTATION_MUTANTS_H_
