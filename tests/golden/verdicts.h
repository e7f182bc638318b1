// What validation says of batches that are to be refused: the batches of refused-2d.dynmesh and
// refused-3d.dynmesh, and options and edits that no script can hold. verdicts.txt records it.
#ifndef DYNMESH_TESTS_GOLDEN_VERDICTS_H_
#define DYNMESH_TESTS_GOLDEN_VERDICTS_H_

#include <string>
#include <vector>

namespace dynmesh::test {

// A line for each batch: where it stands, the status code, the reason, the edit, the features and
// the message. "accepted" for one that is not
// refused.
std::vector<std::string> Verdicts();

}  // namespace dynmesh::test

#endif  // DYNMESH_TESTS_GOLDEN_VERDICTS_H_
