#include "server/copy_journal.h"

#include <memory>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "server/base/log.h"
#include "server/base/mesh_name.h"
#include "server/journal/journal_folder.h"
#include "server/journal/open_postgres.h"
#include "server/journal/postgres_target.h"
#include "server/journal/sqlite_journal.h"

namespace dynmesh::server {
namespace {

absl::StatusOr<std::unique_ptr<Journal>> OpenFolder(const std::string& folder, bool is_source,
                                                    const std::vector<std::string>& accepted) {
  if (is_source &&
      DatabaseFormatOf(absl::StrCat(folder, "/journal.sqlite")) == DatabaseFormat::kNone) {
    return absl::NotFoundError(absl::StrCat(folder, " has no journal.sqlite with meshes"));
  }
  SqliteJournal::Options options;
  if (is_source) options.accept_loss = accepted;
  return SqliteJournal::Open(folder, options);
}

absl::StatusOr<std::unique_ptr<Journal>> OpenPlace(const std::string& place, bool is_source,
                                                   const std::vector<std::string>& accepted) {
  if (!postgres::IsAddress(place)) return OpenFolder(place, is_source, accepted);
  PostgresOptions options;
  options.exclusive = true;
  options.make_tables = !is_source;
  return OpenPostgresJournal(place, options);
}

absl::Status CheckUsage(const Flags& flags, const std::vector<std::string>& meshes) {
  if (flags.copy_journal.size() != 2) {
    return absl::InvalidArgumentError("copy-meshes: give --copy-journal FROM TO, too");
  }
  if (!flags.data_dir.empty() || !flags.journal.empty() || !flags.config.node_address.empty()) {
    return absl::InvalidArgumentError(
        "copy-journal: it names both journals, and serves nothing: give it without --data-dir, "
        "--journal and --node-address");
  }
  for (const std::string& place : flags.copy_journal) {
    if (place.empty()) return absl::InvalidArgumentError("copy-journal: a journal has no name");
  }
  if (absl::StripSuffix(flags.copy_journal[0], "/") ==
      absl::StripSuffix(flags.copy_journal[1], "/")) {
    return absl::InvalidArgumentError("copy-journal: FROM and TO are the same");
  }
  for (const std::string& mesh : meshes) {
    if (!IsMeshId(mesh)) {
      return absl::InvalidArgumentError(absl::StrCat("copy-meshes: ", mesh, " is no mesh's name"));
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<CopyCounts> CopyJournal(const Flags& flags) {
  CopyOptions options;
  options.meshes = absl::StrSplit(flags.copy_meshes, ',', absl::SkipWhitespace());
  if (absl::Status s = CheckUsage(flags, options.meshes); !s.ok()) return s;
  const std::vector<std::string> accepted =
      absl::StrSplit(flags.accept_loss, ',', absl::SkipWhitespace());
  auto from = OpenPlace(flags.copy_journal[0], /*is_source=*/true, accepted);
  if (!from.ok()) return from.status();
  auto to = OpenPlace(flags.copy_journal[1], /*is_source=*/false, {});
  if (!to.ok()) return to.status();
  Log(LogLevel::kInfo, "copy_begun", {{"from", (*from)->name()}, {"to", (*to)->name()}});
  absl::StatusOr<CopyCounts> counts = CopyMeshes(**from, **to, options);
  if (!counts.ok()) return counts;
  Log(LogLevel::kInfo, "copy_done",
      {{"copied", counts->copied},
       {"there", counts->there},
       {"revisions", counts->revisions},
       {"bytes", counts->bytes}});
  return counts;
}

}  // namespace dynmesh::server
