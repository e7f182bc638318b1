#include <algorithm>
#include <set>

#include "absl/time/time.h"
#include "client/stub_internal.h"
#include "proto/codec/grpc_status.h"
#include "proto/codec/status_codec.h"

namespace dynmesh::client {
namespace {

using Clock = WaitingCalls::Clock;

constexpr std::chrono::milliseconds kTick(250);
constexpr std::chrono::seconds kWait(1);   // for an answer, before anything is asked
constexpr std::chrono::seconds kAgain(1);  // between two questions about the same
// An owner's lease may have to end, and the mesh to be made again; the next question goes to
// another server.
constexpr absl::Duration kOwnerLimit = absl::Seconds(3);
constexpr std::chrono::milliseconds kQuiet(1500);  // of a server with streams, before it is asked
constexpr absl::Duration kSignLimit = absl::Milliseconds(1250);
// It was sent to two servers already: the third one does not name the server that should open a
// free mesh, but opens it, and names only a server that has it.
constexpr int kSentOn = 2;

}  // namespace

struct WaitingCalls::Question {
  Subject subject;
  Stub::ServerPtr server;  // that is asked
  grpc::ClientContext context;
  v1::GetMeshRequest mesh_request;
  v1::Mesh mesh;
  v1::GetStatsRequest sign_request;
  v1::GetStatsResponse sign;
};

WaitingCalls::WaitingCalls(Stub* stub) : stub_(stub) {}

WaitingCalls::~WaitingCalls() {
  {
    const MutexLock lock(mutex_);
    stopping_ = true;
    for (const auto& [key, question] : running_) question->context.TryCancel();
    wake_.NotifyAll();
    wake_.Wait(mutex_, [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return running_.empty(); });
  }
  if (thread_.joinable()) thread_.join();
}

WaitingCalls::Call::Call(WaitingCalls* calls, const std::string& key, const std::string& address,
                         grpc::ClientContext* context, bool is_stream)
    : calls_(calls) {
  if (calls_ == nullptr) return;
  const Clock::time_point now = Clock::now();
  const MutexLock lock(calls_->mutex_);
  entry_ = calls_->calls_.insert(
      calls_->calls_.end(),
      Entry{key, address, context, is_stream, is_stream ? Clock::time_point::max() : now});
  if (is_stream) calls_->heard_.emplace(address, now);
  if (!calls_->thread_.joinable()) {
    calls_->thread_ = std::thread([calls = calls_] { calls->Run(); });
  } else if (calls_->parked_) {
    calls_->wake_.NotifyAll();
  }
}

WaitingCalls::Call::~Call() {
  if (calls_ == nullptr) return;
  const MutexLock lock(calls_->mutex_);
  calls_->calls_.erase(entry_);
}

void WaitingCalls::Call::Heard(bool more) {
  if (calls_ == nullptr) return;
  const Clock::time_point now = Clock::now();
  const MutexLock lock(calls_->mutex_);
  entry_->since = more ? now : Clock::time_point::max();
  entry_->is_suspected = false;
  if (entry_->is_stream) calls_->heard_[entry_->address] = now;
}

void WaitingCalls::Call::Expect() {
  if (calls_ == nullptr) return;
  const Clock::time_point now = Clock::now();
  const MutexLock lock(calls_->mutex_);
  entry_->since = std::min(entry_->since, now);
}

void WaitingCalls::Run() {
  const MutexLock lock(mutex_);
  while (!stopping_) {
    if (calls_.empty()) {
      heard_.clear();
      asked_.clear();
      parked_ = true;
      wake_.Wait(mutex_, [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
        return stopping_ || !calls_.empty();
      });
      parked_ = false;
    }
    wake_.WaitFor(mutex_, kTick,
                  [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return stopping_; });
    if (!stopping_) Look(Clock::now());
  }
}

void WaitingCalls::Look(Clock::time_point now) {
  std::set<Subject> due;
  std::set<std::string> streams;  // servers that have some
  for (const Entry& call : calls_) {
    if (call.is_stream) streams.insert(call.address);
    const bool waits = call.since != Clock::time_point::max() && call.since + kWait <= now;
    if (waits || call.is_suspected) due.emplace(IsMesh(call.key) ? call.key : "", call.address);
  }
  std::erase_if(heard_, [&](const auto& of) { return !streams.contains(of.first); });
  for (const auto& [address, last] : heard_) {
    if (last + kQuiet <= now) due.emplace("", address);
  }
  std::erase_if(asked_, [&](const auto& of) { return !of.second.runs && !due.contains(of.first); });
  for (const Subject& subject : due) {
    const auto before = asked_.find(subject);
    if (before != asked_.end() && (before->second.runs || before->second.next > now)) continue;
    // The server itself, or another one.
    const std::string of =
        subject.first.empty() ? subject.second : stub_->AddressOtherThan(subject.second);
    if (!of.empty()) Ask(subject, of, now);
  }
}

void WaitingCalls::Ask(const Subject& subject, const std::string& of, Clock::time_point now) {
  auto made = std::make_unique<Question>();
  Question* const question = made.get();
  question->subject = subject;
  question->server = stub_->At(of);
  asked_[subject] = Asked{true, now + kAgain};
  running_[question] = std::move(made);
  const auto answered = [this, question](const grpc::Status& s) { Answered(question, s); };
  if (subject.first.empty()) {
    stub_->Prepare(question->context, kSignLimit);
    question->server->service->async()->GetStats(&question->context, &question->sign_request,
                                                 &question->sign, answered);
  } else {
    question->mesh_request.set_mesh(subject.first);
    stub_->Prepare(question->context, kOwnerLimit, kSentOn);
    question->server->service->async()->GetMesh(&question->context, &question->mesh_request,
                                                &question->mesh, answered);
  }
}

void WaitingCalls::Answered(const Question* question, const grpc::Status& status) {
  const Clock::time_point now = Clock::now();
  const MutexLock lock(mutex_);
  const auto running = running_.find(question);
  asked_[question->subject].runs = false;
  const auto& [mesh, address] = question->subject;
  if (!stopping_ && mesh.empty()) JudgeSign(address, status, now);
  if (!stopping_ && !mesh.empty()) JudgeOwner(*question, status, now);
  // Before the stub may go, which has the server's connection, too.
  running_.erase(running);
  if (stopping_) wake_.NotifyAll();
}

void WaitingCalls::JudgeSign(const std::string& address, const grpc::Status& status,
                             Clock::time_point now) {
  const absl::Status answer = codec::FromGrpcStatus(status);
  const bool is_late = absl::IsDeadlineExceeded(answer) || absl::IsUnavailable(answer);
  if (is_late && !codec::GetServiceError(answer).has_value()) return GaveNoSign(address, now);
  if (const auto heard = heard_.find(address); heard != heard_.end()) heard->second = now;
  for (Entry& call : calls_) {
    if (call.address == address) call.is_suspected = false;
  }
}

void WaitingCalls::JudgeOwner(const Question& question, const grpc::Status& status,
                              Clock::time_point now) {
  const auto& [mesh, address] = question.subject;
  if (status.ok()) {
    stub_->Moved(mesh, question.server->address);
    return Cancel(mesh, address);
  }
  const auto error = codec::GetServiceError(codec::FromGrpcStatus(status));
  if (!error.has_value() || error->reason != codec::reason::kNotOwner) return;
  const auto owner = error->metadata.find("owner");
  if (owner == error->metadata.end() || owner->second == address ||
      owner->second == question.server->address || !stub_->Knows(owner->second)) {
    return;
  }
  // A third one has it. It is asked, too: it may be the one that is stopped.
  Ask(question.subject, owner->second, now);
}

void WaitingCalls::GaveNoSign(const std::string& address, Clock::time_point now) {
  for (Entry& call : calls_) {
    if (call.address != address) continue;
    if (IsMesh(call.key)) {
      call.is_suspected = true;
    } else if (call.is_stream || call.since + kWait <= now) {
      call.context->TryCancel();  // any other server can answer
    }
  }
}

void WaitingCalls::Cancel(const std::string& key, const std::string& address) {
  for (const Entry& call : calls_) {
    if (call.key == key && call.address == address) call.context->TryCancel();
  }
}

}  // namespace dynmesh::client
