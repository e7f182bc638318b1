// The calls of a client that wait at servers that share their meshes. A server that is stopped, or
// cut off from the client, does not answer, and gRPC notices that after ten seconds. Another server
// has its meshes sooner. So when an answer does not come within a second:
//   * a call about a mesh asks another server for the mesh, which answers when it has it, or names
//     the one that has. Then the call is cancelled here, and its maker repeats it there;
//   * a call that any server can answer asks its own server for a sign of life, and is cancelled if
//     none comes.
// A server that is only slow keeps its calls: no other server has their meshes.
//
// A stream that has nothing to wait for, as a watch, is one that waits if its server gives no sign
// of life. That is asked for every other second, once for all streams at a server.
//
// A thread of its own looks at the calls, four times a second while there are any. Thread-safe.
#ifndef DYNMESH_CLIENT_WAITING_CALLS_INTERNAL_H_
#define DYNMESH_CLIENT_WAITING_CALLS_INTERNAL_H_

#include <grpcpp/grpcpp.h>

#include <chrono>
#include <list>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include "core/base/mutex.h"

namespace dynmesh::client {

class Stub;

class WaitingCalls {
 public:
  using Clock = std::chrono::steady_clock;

  // One call, from before its begin to after its end. Its methods may be called by any thread.
  class Call;

  // The stub makes it and outlives it.
  explicit WaitingCalls(Stub* stub);
  // Ends what is asked.
  ~WaitingCalls();
  WaitingCalls(const WaitingCalls&) = delete;
  WaitingCalls& operator=(const WaitingCalls&) = delete;

 private:
  struct Entry {
    std::string key;      // as of Stub::Of: the mesh's full name, or any other
    std::string address;  // of the server that was asked
    grpc::ClientContext* context;
    bool is_stream;
    Clock::time_point since;    // an answer is waited for; max: none is
    bool is_suspected = false;  // its server gives no sign of life
  };
  // A question about the mesh of calls that wait at one server, or, with an empty name, about that
  // server.
  using Subject = std::pair<std::string, std::string>;  // mesh, address
  struct Question;
  struct Asked {
    bool runs = false;
    Clock::time_point next;  // not before
  };

  static bool IsMesh(const std::string& key) { return key.rfind("meshes/", 0) == 0; }

  void Run();
  // Asks what is due.
  void Look(Clock::time_point now) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Ask(const Subject& subject, const std::string& of, Clock::time_point now)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // The answer to a question, by a thread of gRPC.
  void Answered(const Question* question, const grpc::Status& status);
  void JudgeSign(const std::string& address, const grpc::Status& status, Clock::time_point now)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void JudgeOwner(const Question& question, const grpc::Status& status, Clock::time_point now)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void GaveNoSign(const std::string& address, Clock::time_point now)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Cancel(const std::string& key, const std::string& address)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  Stub* const stub_;
  Mutex mutex_;
  CondVar wake_;
  std::list<Entry> calls_ ABSL_GUARDED_BY(mutex_);
  std::map<Subject, Asked> asked_ ABSL_GUARDED_BY(mutex_);
  std::map<const Question*, std::unique_ptr<Question>> running_ ABSL_GUARDED_BY(mutex_);
  // Of servers with streams: the last message.
  std::map<std::string, Clock::time_point> heard_ ABSL_GUARDED_BY(mutex_);
  bool parked_ ABSL_GUARDED_BY(mutex_) = false;  // the thread waits for a call
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::thread thread_ ABSL_GUARDED_BY(mutex_);  // runs from the first call on
};

class WaitingCalls::Call {
 public:
  // `key` and `address`: as of Stub::Of. `calls`: null, and the object does nothing, unless servers
  // share their meshes. `is_stream`: nothing is expected at first.
  Call(WaitingCalls* calls, const std::string& key, const std::string& address,
       grpc::ClientContext* context, bool is_stream = false);
  ~Call();
  Call(const Call&) = delete;
  Call& operator=(const Call&) = delete;

  // A message came. `more`: another one is to come; the wait for it begins now.
  void Heard(bool more);
  // An answer is waited for from now on, if none was.
  void Expect();

 private:
  WaitingCalls* const calls_;
  std::list<Entry>::iterator entry_;
};

}  // namespace dynmesh::client

#endif  // DYNMESH_CLIENT_WAITING_CALLS_INTERNAL_H_
