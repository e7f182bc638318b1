#include "tests/server/journal/postgres_server.h"

#include <fcntl.h>
#include <grp.h>
#include <pwd.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <pqxx/pqxx>
#include <stdexcept>

#include "absl/strings/str_cat.h"
#include "tests/support/deadline.h"

namespace dynmesh::server {
namespace {

namespace fs = std::filesystem;

// Owns no files.
constexpr uid_t kNoUser = 65534;

// The user that the server runs as; null: the one of this process.
const passwd* ServerUser() {
  if (geteuid() != 0) return nullptr;
  const passwd* const user = getpwnam("postgres");
  return user != nullptr ? user : getpwuid(kNoUser);
}

// Of a process: its state, as a letter, and its parent.
std::pair<char, pid_t> StateOf(pid_t process) {
  std::ifstream in("/proc/" + std::to_string(process) + "/stat");
  std::string number, name, state;
  pid_t parent = 0;
  if (!(in >> number >> name >> state >> parent)) return {'X', 0};
  return {state[0], parent};
}

// A zombie is not.
bool IsAlive(pid_t process) {
  const char state = StateOf(process).first;
  return state != 'X' && state != 'Z';
}

}  // namespace

std::string PostgresServer::Programs() {
  std::vector<std::string> found;
  std::error_code error;
  for (const auto& version : fs::directory_iterator("/usr/lib/postgresql", error)) {
    const std::string programs = version.path().string() + "/bin";
    if (fs::exists(programs + "/initdb") && fs::exists(programs + "/postgres")) {
      found.push_back(programs);
    }
  }
  return found.empty() ? "" : *std::max_element(found.begin(), found.end());
}

PostgresServer::PostgresServer(const std::vector<std::string>& settings) : settings_(settings) {
  // A copy takes a quarter of the work of initdb.
  static const PostgresServer fresh{Unstarted()};
  MakeFolder();
  RunProgram({"/bin/cp", "-a", fresh.folder_ + "/data", folder_ + "/data"});
  Start();
}

PostgresServer::PostgresServer(Unstarted) {
  MakeFolder();
  RunProgram({"initdb", "-D", folder_ + "/data", "-U", "postgres", "-A", "trust", "-E", "UTF8",
              "--locale=C", "--no-sync", "--no-instructions"});
}

PostgresServer::PostgresServer(const PostgresServer& primary, const std::string& name) {
  MakeFolder();
  RunProgram({"pg_basebackup", "-D", folder_ + "/data", "-h", primary.folder(), "-U", "postgres",
              "--no-sync", "-c", "fast"});
  settings_ = {"primary_conninfo=host=" + primary.folder() +
               " user=postgres application_name=" + name};
  std::ofstream(folder_ + "/data/standby.signal");
  Start();
}

PostgresServer::~PostgresServer() {
  Kill();
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
}

void PostgresServer::MakeFolder() {
  // The path of a socket has less than 108 bytes.
  std::string pattern = "/tmp/dynmesh-pg-XXXXXX";
  if (mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("no folder in /tmp");
  folder_ = pattern;
  if (const passwd* const user = ServerUser(); user != nullptr) {
    if (chown(folder_.c_str(), user->pw_uid, user->pw_gid) != 0) {
      throw std::runtime_error("no folder for PostgreSQL's user");
    }
  }
}

pid_t PostgresServer::Spawn(const std::vector<std::string>& words) const {
  const std::string program = words[0][0] == '/' ? words[0] : Programs() + "/" + words[0];
  const std::string log = folder_ + "/log";
  // The program finds its companions beside itself: a name without a folder would mean the PATH.
  std::vector<char*> arguments = {const_cast<char*>(program.c_str())};
  for (size_t i = 1; i < words.size(); ++i) {
    arguments.push_back(const_cast<char*>(words[i].c_str()));
  }
  arguments.push_back(nullptr);
  const passwd* const user = ServerUser();
  const pid_t child = fork();
  if (child != 0) return child;
  // Only calls that are safe after a fork of a program with threads.
  const bool is_user = user == nullptr || (setgroups(0, nullptr) == 0 &&
                                           setgid(user->pw_gid) == 0 && setuid(user->pw_uid) == 0);
  prctl(PR_SET_PDEATHSIG, SIGQUIT);  // an immediate shutdown
  const int out = open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0600);
  if (!is_user || out < 0 || chdir("/") != 0) _exit(126);
  dup2(open("/dev/null", O_RDONLY), 0);
  dup2(out, 1);
  dup2(out, 2);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  execv(program.c_str(), arguments.data());
  _exit(127);
}

void PostgresServer::RunProgram(const std::vector<std::string>& words) const {
  if (test::WaitForEnd(Spawn(words)) != 0) {
    throw std::runtime_error(words[0] + " failed: " + Log());
  }
}

void PostgresServer::Start() {
  std::vector<std::string> words = {"postgres",
                                    "-D",
                                    folder_ + "/data",
                                    "-k",
                                    folder_,
                                    "-c",
                                    "listen_addresses=",
                                    "-c",
                                    "fsync=off",
                                    "-c",
                                    "autovacuum=off",
                                    "-c",
                                    "shared_buffers=16MB",
                                    "-c",
                                    "unix_socket_permissions=0777",
                                    "-c",
                                    "max_connections=60",
                                    "-c",
                                    "wal_receiver_status_interval=1s",
                                    "-c",
                                    "wal_retrieve_retry_interval=100ms"};
  for (const std::string& setting : settings_) {
    words.push_back("-c");
    words.push_back(setting);
  }
  // A killed server leaves the file with its number.
  std::error_code ignored;
  fs::remove(folder_ + "/data/postmaster.pid", ignored);
  server_ = Spawn(words);
  try {
    test::WaitUntil("PostgreSQL", [this] {
      int status = 0;
      if (waitpid(server_, &status, WNOHANG) == server_) {
        server_ = -1;
        throw std::runtime_error("PostgreSQL ended: " + Log());
      }
      try {
        pqxx::connection connection(
            absl::StrCat("host=", folder_, " user=postgres dbname=postgres"));
        return true;
      } catch (const pqxx::failure&) {
        return false;
      }
    });
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(absl::StrCat(error.what(), "\n", Log()));
  }
}

// PostgreSQL makes each of its processes the leader of a group.
std::vector<pid_t> PostgresServer::Processes() const {
  std::vector<pid_t> processes = {server_};
  std::error_code error;
  for (const auto& entry : fs::directory_iterator("/proc", error)) {
    const pid_t id = std::atoi(entry.path().filename().c_str());
    if (id > 0 && StateOf(id).second == server_) processes.push_back(id);
  }
  return processes;
}

void PostgresServer::Signal(int signal) const {
  for (const pid_t process : Processes()) kill(process, signal);
}

void PostgresServer::Kill() {
  if (server_ < 0) return;
  const std::vector<pid_t> processes = Processes();
  for (const pid_t process : processes) kill(process, SIGKILL);
  test::WaitForEnd(server_);
  test::WaitUntil("the end of PostgreSQL's processes", [&processes] {
    return std::none_of(processes.begin(), processes.end(), IsAlive);
  });
  server_ = -1;
}

void PostgresServer::Pause() const { Signal(SIGSTOP); }
void PostgresServer::Resume() const { Signal(SIGCONT); }

std::string PostgresServer::Url(const std::string& database, const std::string& socket) const {
  std::string host = socket.empty() ? folder_ : socket;
  for (std::size_t at = 0; (at = host.find('/', at)) != std::string::npos;) {
    host.replace(at, 1, "%2F");
  }
  return absl::StrCat("postgresql://postgres@", host, "/", database);
}

std::string PostgresServer::Sql(const std::string& database, const std::string& sql) const {
  pqxx::connection connection(absl::StrCat("host=", folder_, " user=postgres dbname=", database));
  pqxx::nontransaction work(connection);
  std::string text;
  for (const auto& row : work.exec(sql)) {
    absl::StrAppend(&text, text.empty() ? "" : " ", row[0].as<std::string>(""));
  }
  return text;
}

std::string PostgresServer::MakeDatabase() {
  std::string name = absl::StrCat("d", ++databases_);
  // Files that are copied take a third of the time of a log of their pages.
  Sql("postgres", "CREATE DATABASE " + name + " STRATEGY file_copy");
  return name;
}

std::string PostgresServer::Log() const {
  std::ifstream in(folder_ + "/log");
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace dynmesh::server
