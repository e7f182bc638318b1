// Whether the files of a journal that are open are still those at its path. If the folder was
// renamed or removed, or another one was mounted over it, writing goes on into files that a restart
// will not find. So they are looked for once a second, and by the writer before each commit. A file
// is recognised by its device and inode, as it was found when the journal was opened: a copy of the
// folder is another one.
//
// A look takes a `stat` for each file, some microseconds in all. Each change is logged once.
// Thread-safe.
#ifndef DYNMESH_SERVER_JOURNAL_JOURNAL_PRESENCE_H_
#define DYNMESH_SERVER_JOURNAL_JOURNAL_PRESENCE_H_

#include <sys/types.h>

#include <atomic>
#include <string>
#include <thread>
#include <vector>

#include "absl/status/status.h"
#include "core/base/mutex.h"

namespace dynmesh::server {

class JournalPresence {
 public:
  // The files as they are now; those that are missing are not looked for. `journal`: for the log.
  JournalPresence(std::string journal, const std::vector<std::string>& files);
  JournalPresence(const JournalPresence&) = delete;
  JournalPresence& operator=(const JournalPresence&) = delete;
  ~JournalPresence();

  // UNAVAILABLE: one of them is missing or is another one now. OK as soon as all are back.
  absl::Status Look();
  // As of the last look, which was a second ago at most, unless the disk hangs.
  bool gone() const { return gone_; }

 private:
  struct File {
    std::string path;
    dev_t device;
    ino_t inode;
  };

  absl::Status Find() const;
  void Tell(const absl::Status& found) const;
  void Run();

  const std::string journal_;
  std::vector<File> files_;
  std::atomic<bool> gone_{false};
  Mutex looking_;

  Mutex mutex_;
  CondVar wake_;
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::thread thread_;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_JOURNAL_JOURNAL_PRESENCE_H_
