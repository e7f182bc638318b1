// Compares the record of what was acknowledged (heads_file.h) with the journal: finds each mesh's
// losses, how an operator accepts them, and their description. Pure functions, thread-safe.
//
// A mesh with a loss is read only until the loss is accepted: continuing from an earlier revision
// would hide the loss. An operator accepts exactly the reported state, as MESH@REVISION (the
// revision found, or "none"), or all losses by their common code. So a setting that remains in a
// file accepts no later loss.
#ifndef DYNMESH_SERVER_JOURNAL_LOSSES_H_
#define DYNMESH_SERVER_JOURNAL_LOSSES_H_

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "absl/strings/string_view.h"
#include "server/journal/heads_file.h"

namespace dynmesh::server {

// A mesh by its rows.
struct FoundMesh {
  HeadsFile::Head head;  // state unset; the name as in the row
  bool named = true;     // its row's checksum is valid
  // Checksum of the entry with the recorded revision; none: there is no such entry any more.
  std::optional<std::int64_t> sum_on_record;
};

struct Loss {
  enum class Kind {
    kMissing,      // the journal has no such mesh
    kBehind,       // later revisions were acknowledged
    kAnswers,      // later requests were acknowledged
    kOther,        // another revision was acknowledged under that number
    kUnconfirmed,  // unknown what was acknowledged
  };
  Kind kind = Kind::kMissing;
  HeadsFile::Head recorded;  // key 0: not on record
  HeadsFile::Head found;     // key 0: not in the journal
  std::string name;          // for messages

  HeadsFile::Key key() const { return found.key != 0 ? found.key : recorded.key; }
  // The text with which an operator accepts it.
  std::string Acceptance() const;
  // For messages: what is lost, and how to accept it.
  std::string Text() const;
};

// The name of a mesh in messages: its id, or "@" and the key of its row if the id is unreadable or
// another mesh has it too.
std::string SayableName(HeadsFile::Key key, absl::string_view id);
// For a mesh among all: `others` counts the meshes with each id.
std::string SayableName(const FoundMesh& mesh, const HeadsFile::Head* recorded,
                        const std::map<std::string, int>& others);

// Sorted by key. `confirmed` as HeadsFile's.
std::vector<Loss> FindLosses(const std::vector<HeadsFile::Head>& recorded, HeadsFile::Key confirmed,
                             const std::vector<FoundMesh>& found);

// A code of all these losses together: eight hex digits.
std::string CodeOf(const std::vector<Loss>& losses);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_JOURNAL_LOSSES_H_
