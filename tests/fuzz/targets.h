// What is fuzzed. A target takes any bytes, uses the product as a stranger would, and
// returns what is wrong: nothing, but for a bug. (A crash, a hang or a sanitizer's report
// is one as well.) Deterministic, thread-compatible.
#ifndef DYNMESH_TESTS_FUZZ_TARGETS_H_
#define DYNMESH_TESTS_FUZZ_TARGETS_H_

#include <string>
#include <string_view>

namespace dynmesh::fuzz {

// An edit script. What parses must come back from its printed form, and must mesh or be
// refused.
std::string FuzzEditScript(std::string_view bytes);

// A `.poly` file, and after a line `---` the `.node` file beside it; the whole is tried as a
// `.node` file too. What parses must mesh or be refused.
std::string FuzzPlanarInput(std::string_view bytes);

// A file of space, tried as every format that there is; for a `.poly` or `.smesh` there may be a
// line `---` and the `.node` file beside it. What parses must have its features in order, and
// joining its faces must not depend on theirs.
std::string FuzzSpaceInput(std::string_view bytes);

// A mesh as `.node`, `.ele`, `.edge` and `.face` files with lines `---` between them. What parses
// must survive conversion, measuring and the judge.
std::string FuzzMeshFiles(std::string_view bytes);

// Batches of edits, packed (batches.h), in the plane and in space. A refused one must change
// nothing; after the others mesh and trace must be those of a run from scratch.
std::string FuzzBatches(std::string_view bytes);
std::string FuzzSpaceBatches(std::string_view bytes);

// Messages of clients, one after the other. None may crash the server's meshes; a refused one must
// change nothing, watchers must follow the others, and in the end all meshes must be those of a
// run from scratch.
std::string FuzzRequests(std::string_view bytes);

// Messages of a server that lies. A replica must refuse what does not fit and stay what it was, and
// hold the mesh of the hash that it took; after all of it a watch begins anew.
std::string FuzzAnswers(std::string_view bytes);

// A record of a journal. What is read must be what would be written.
std::string FuzzJournal(std::string_view bytes);

}  // namespace dynmesh::fuzz

#endif  // DYNMESH_TESTS_FUZZ_TARGETS_H_
