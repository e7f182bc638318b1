// A proxy between a journal and a PostgreSQL server, both by Unix sockets, that cuts connections at
// chosen moments. Thread-safe.
#ifndef DYNMESH_TESTS_SERVER_JOURNAL_POSTGRES_PROXY_H_
#define DYNMESH_TESTS_SERVER_JOURNAL_POSTGRES_PROXY_H_

#include <atomic>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/temp_folder.h"

namespace dynmesh::server {

class PostgresProxy {
 public:
  // What happens to the next bytes that come; once.
  enum class Cut {
    kNone,
    kAnswer,    // the server's bytes are dropped, and the connection is closed
    kQuestion,  // the client's bytes are dropped, and the connection is closed
    kLate,      // the client's connection is closed; its bytes reach the server at Release
  };

  // `socket`: the server's.
  explicit PostgresProxy(const std::string& socket);
  ~PostgresProxy();

  // The folder with the proxy's socket.
  const std::string& folder() const { return folder_.path(); }
  // `then` runs before the client's connection is closed. `skipped`: so many answers, or questions,
  // pass before.
  void CutNext(Cut cut, std::function<void()> then = nullptr, int skipped = 0);
  // While true, connections are closed as soon as they are made.
  void Refuse(bool yes) { refuses_ = yes; }
  // While true, nothing is answered on new connections; they are closed when it is false again.
  void Ignore(bool yes) { ignores_ = yes; }
  // Sends what came too late, and waits until the server has answered it.
  void Release();
  int cuts() const { return cuts_; }

 private:
  void Accept();
  void Serve(int client);
  bool Take(Cut wanted);

  const std::string server_;
  test::TempFolder folder_;
  int listener_ = -1;
  std::atomic<bool> ends_{false}, refuses_{false}, ignores_{false}, released_{false};
  std::atomic<int> cuts_{0}, late_{0};
  std::mutex mutex_;
  Cut cut_ = Cut::kNone;
  int skipped_ = 0;
  std::function<void()> then_;
  std::vector<std::thread> connections_;
  std::thread acceptor_;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_TESTS_SERVER_JOURNAL_POSTGRES_PROXY_H_
