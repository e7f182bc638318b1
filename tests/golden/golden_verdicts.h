// The texts of verdicts: what validation, limits and cancelling say about fixed batches and
// options.
//
// A line of verdicts.txt is
//   NAME: CODE REASON features A, B edit N: MESSAGE
// without the parts that the error does not have, or `NAME: OK`: input just inside of a rule.
// Coordinates are exact, and angles rounded to six digits, so the texts are the same on every
// machine.
#ifndef DYNMESH_TESTS_GOLDEN_GOLDEN_VERDICTS_H_
#define DYNMESH_TESTS_GOLDEN_GOLDEN_VERDICTS_H_

#include <string>
#include <vector>

namespace dynmesh::test {

// The lines of verdicts.txt without its comments, in order.
std::vector<std::string> VerdictLines();

}  // namespace dynmesh::test

#endif  // DYNMESH_TESTS_GOLDEN_GOLDEN_VERDICTS_H_
