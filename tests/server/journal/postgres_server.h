// A PostgreSQL server for tests: in a temporary folder, reached by a Unix socket only, stopped at
// the end, also if the test program is killed.
#ifndef DYNMESH_TESTS_SERVER_JOURNAL_POSTGRES_SERVER_H_
#define DYNMESH_TESTS_SERVER_JOURNAL_POSTGRES_SERVER_H_

#include <sys/types.h>

#include <string>
#include <vector>

namespace dynmesh::server {

class PostgresServer {
 public:
  // The folder with Debian's server programs; empty if they are not installed.
  static std::string Programs();

  // Makes a database cluster and starts it with `settings`, each NAME=VALUE. As root, for the user
  // `postgres`, or one that owns no files: PostgreSQL refuses root. Throws std::runtime_error with
  // the server's log if it does not run after a minute.
  explicit PostgresServer(const std::vector<std::string>& settings = {});
  // A standby of `primary` with that name for synchronous_standby_names.
  PostgresServer(const PostgresServer& primary, const std::string& name);
  ~PostgresServer();
  PostgresServer(const PostgresServer&) = delete;
  PostgresServer& operator=(const PostgresServer&) = delete;

  // Returns when it accepts connections.
  void Start();
  // As a loss of power ends it, but for the disk.
  void Kill();
  // SIGSTOP and SIGCONT for the server and its children.
  void Pause() const;
  void Resume() const;

  // The address of a database. `socket`: the folder of the socket; default: the server's.
  std::string Url(const std::string& database, const std::string& socket = "") const;
  // Runs statements as the superuser, and returns the first column of the last one's rows, with
  // spaces between.
  std::string Sql(const std::string& database, const std::string& sql) const;
  // A new empty database.
  std::string MakeDatabase();
  const std::string& folder() const { return folder_; }
  std::string SocketFile() const { return folder_ + "/.s.PGSQL.5432"; }

 private:
  struct Unstarted {};
  // A database cluster alone, to be copied.
  explicit PostgresServer(Unstarted);
  void MakeFolder();
  // Programs of PostgreSQL by name, others by path.
  void RunProgram(const std::vector<std::string>& words) const;
  pid_t Spawn(const std::vector<std::string>& words) const;
  std::string Log() const;
  // Of the server and its children.
  std::vector<pid_t> Processes() const;
  void Signal(int signal) const;

  std::string folder_;
  std::vector<std::string> settings_;
  pid_t server_ = -1;
  int databases_ = 0;
};

// One for all tests of a program (postgres_main.cc), made at its first use.
PostgresServer& SharedPostgres();

}  // namespace dynmesh::server

#endif  // DYNMESH_TESTS_SERVER_JOURNAL_POSTGRES_SERVER_H_
