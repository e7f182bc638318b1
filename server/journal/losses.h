// What was acknowledged (heads_file.h) against what the journal has: which mesh lost what, how an
// operator accepts that, and what is said of it. Pure functions, thread-safe.
//
// A mesh with a loss is not written to until the loss is accepted: going on from an earlier
// revision would make it look whole. It is accepted for exactly what was told, as MESH@REVISION
// (the one that was found, or "none"), or by the code of all losses together. So a setting that is
// left in a file accepts no later loss.
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

// A mesh as its rows say.
struct FoundMesh {
  HeadsFile::Head head;  // state unset; the name as it is in the row
  bool named = true;     // its row's checksum fits
  // Of the entry of the revision that is on record; none: it has no such entry any more.
  std::optional<std::int64_t> sum_on_record;
};

struct Loss {
  enum class Kind {
    kMissing,      // nothing is there
    kBehind,       // later revisions were acknowledged
    kAnswers,      // later requests were
    kOther,        // another revision was acknowledged under that number
    kUnconfirmed,  // nothing tells what was acknowledged
  };
  Kind kind = Kind::kMissing;
  HeadsFile::Head recorded;  // key 0: it is not on record
  HeadsFile::Head found;     // key 0: it is not in the journal
  std::string name;          // to call it by

  HeadsFile::Key key() const { return found.key != 0 ? found.key : recorded.key; }
  // As an operator accepts it.
  std::string Acceptance() const;
  // For people: what is lost, and how it is accepted.
  std::string Text() const;
};

// What a mesh is called: its id; if that cannot be said, or another mesh has it, too, "@" and the
// key of its row.
std::string SayableName(HeadsFile::Key key, absl::string_view id);
// Of all meshes: `others` says how many have which id.
std::string SayableName(const FoundMesh& mesh, const HeadsFile::Head* recorded,
                        const std::map<std::string, int>& others);

// By key. `confirmed` as HeadsFile's.
std::vector<Loss> FindLosses(const std::vector<HeadsFile::Head>& recorded, HeadsFile::Key confirmed,
                             const std::vector<FoundMesh>& found);

// Of all of these together: eight hex digits.
std::string CodeOf(const std::vector<Loss>& losses);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_JOURNAL_LOSSES_H_
