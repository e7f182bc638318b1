// The fuzz targets. A target takes any bytes, uses the product like a user, and returns a fault, or
// nothing. (A crash, a hang or a sanitizer's report is a fault as well.) Deterministic,
// thread-compatible.
#ifndef DYNMESH_TESTS_FUZZ_TARGETS_H_
#define DYNMESH_TESTS_FUZZ_TARGETS_H_

#include <string>
#include <string_view>

namespace dynmesh::fuzz {

// An edit script. If it parses, its printed form must parse to the same, and it must mesh or be
// refused.
std::string FuzzEditScript(std::string_view bytes);

// A `.poly` file, and after a line `---` the `.node` file beside it; the whole is also tried as a
// `.node` file. If it parses, it must mesh or be refused.
std::string FuzzPlanarInput(std::string_view bytes);

// A 3D file, tried in every format; for a `.poly` or `.smesh` there may be a line `---` and the
// `.node` file beside it. If it parses, its features must be in order, and merging its faces must
// not depend on their order.
std::string FuzzSpaceInput(std::string_view bytes);

// A mesh of another program, tried as `.msh`, `.mesh` and `.vtu`. If it parses, it must become
// features in order, and a mesh to be measured.
std::string FuzzElements(std::string_view bytes);

// Faces on a lattice, or slightly beside it, packed, as a surface that is cleaned. An exact oracle
// must find no fault, cleaning again and another order change nothing.
std::string FuzzSurfaces(std::string_view bytes);

// Target lengths, tried as `.asc`, `.npy`, `.pos` and `.mtr`. If they parse, they must become
// sizing features in order.
std::string FuzzSizes(std::string_view bytes);

// A mesh as `.node`, `.ele`, `.edge` and `.face` files with lines `---` between them. If it parses,
// conversion, measuring and the verifier must succeed.
std::string FuzzMeshFiles(std::string_view bytes);

// A mesh to be refined: the same four files, then the .area (3D: .vol) and the .poly; an empty one
// is not there. If it parses, it must become features with places, and mesh or be refused at one.
std::string FuzzMeshInput(std::string_view bytes);

// Batches of edits, packed (batches.h), in 2D and in 3D. A refused one must change nothing; after
// the others mesh and trace must equal those of a run from scratch.
std::string FuzzBatches(std::string_view bytes);
std::string FuzzSpaceBatches(std::string_view bytes);

// Messages of clients, one after the other. None may crash the server's meshes; a refused one must
// change nothing, watchers must follow the others, and in the end all meshes must equal those of a
// run from scratch.
std::string FuzzRequests(std::string_view bytes);

// Messages of a faulty server. A replica must refuse invalid ones and stay unchanged, and its mesh
// must have the accepted hash; after all of it a watch restarts.
std::string FuzzAnswers(std::string_view bytes);

// A record of a journal. Decoding and encoding it must give the same bytes.
std::string FuzzJournal(std::string_view bytes);

}  // namespace dynmesh::fuzz

#endif  // DYNMESH_TESTS_FUZZ_TARGETS_H_
