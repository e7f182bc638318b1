#include "tests/e2e/soak/audience_process.h"

#include <sched.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <string_view>
#include <type_traits>

#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "tests/support/deadline.h"

namespace dynmesh::soak {
namespace {

// The first message is text: address, authority, names of meshes. All others are orders, each
// answered by a report followed by the faults as text.
constexpr char kBetween = '\0';
constexpr std::size_t kLargestMessage = 64 << 10;

struct Order {
  double close_seconds = 0;
  std::uint64_t meshes = 0;
  std::array<MeshHead, 16> heads = {};
};

template <class T>
std::string_view BytesOf(const T& t) {
  static_assert(std::is_trivially_copyable_v<T>);
  return {reinterpret_cast<const char*>(&t), sizeof t};
}

bool Send(int socket, std::string_view message) {
  return send(socket, message.data(), message.size(), MSG_NOSIGNAL) ==
         static_cast<ssize_t>(message.size());
}

// Empty if the other process has ended.
std::string Receive(int socket) {
  std::string message(kLargestMessage, '\0');
  const ssize_t size = recv(socket, message.data(), message.size(), 0);
  message.resize(static_cast<std::size_t>(std::max<ssize_t>(size, 0)));
  return message;
}

void Take(AudienceProcess::Share share) {
  // Linux: of this thread, and those that it makes inherit it.
  if (share == AudienceProcess::Share::kRest) {
    const sched_param none = {};
    sched_setscheduler(0, SCHED_IDLE, &none);
  } else {
    setpriority(PRIO_PROCESS, 0, 10);
  }
}

}  // namespace

AudienceProcess::AudienceProcess(const Audience::Plan& plan, Share share) {
  std::array<int, 2> ends;
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    throw std::runtime_error("no pair of sockets");
  }
  std::fflush(nullptr);  // or the child would write it once more
  child_ = fork();
  if (child_ == 0) {
    close(ends[0]);
    Serve(ends[1], plan, share);
  }
  close(ends[1]);
  socket_ = ends[0];
}

AudienceProcess::~AudienceProcess() {
  close(socket_);  // which ends it
  if (child_ > 0) test::WaitForEnd(child_);
}

void AudienceProcess::Start(const std::string& address, const std::string& authority,
                            const std::vector<std::string>& meshes) {
  std::vector<std::string> words = {address, authority};
  words.insert(words.end(), meshes.begin(), meshes.end());
  Send(socket_, absl::StrJoin(words, std::string(1, kBetween)));
}

Audience::Report AudienceProcess::Ask(std::span<const MeshHead> heads, double close_seconds) {
  Order order;
  order.close_seconds = close_seconds;
  order.meshes = std::min(heads.size(), order.heads.size());
  std::copy_n(heads.begin(), order.meshes, order.heads.begin());
  Audience::Report report;
  const std::string answer = Send(socket_, BytesOf(order)) ? Receive(socket_) : "";
  if (answer.size() < sizeof report) {
    report.faults = 1;
    faults_ = {"the watchers' process is gone"};
    return report;
  }
  std::memcpy(&report, answer.data(), sizeof report);
  faults_ = absl::StrSplit(answer.substr(sizeof report), kBetween, absl::SkipEmpty());
  return report;
}

void AudienceProcess::Serve(int socket, const Audience::Plan& plan, Share share) {
  // The summary after an interruption needs the watchers, so they ignore the signal.
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, SIG_IGN);
  Take(share);
  const std::string start = Receive(socket);
  const std::vector<std::string> words = absl::StrSplit(start, kBetween);
  if (words.size() < 2) _exit(0);
  client::ClientOptions options;
  options.own_connection = true;
  options.tls_ca = words[1];
  const auto client = client::MeshClient::Connect(words[0], options);
  Faults faults;
  Audience audience(plan, {words.begin() + 2, words.end()}, &faults);
  audience.Start(words[0], words[1], *client);
  while (true) {
    const std::string message = Receive(socket);
    Order order;
    if (message.size() != sizeof order) _exit(0);  // no more are wanted
    std::memcpy(&order, message.data(), sizeof order);
    const std::span<const MeshHead> heads(order.heads.data(), order.meshes);
    if (order.close_seconds >= 0) audience.Close(heads, order.close_seconds);
    std::string answer(BytesOf(audience.ReportOf(heads)));
    for (const std::string& fault : faults.words()) {
      if (answer.size() + fault.size() + 1 > kLargestMessage) break;
      answer.append(1, kBetween).append(fault);
    }
    if (!Send(socket, answer)) _exit(0);
  }
}

}  // namespace dynmesh::soak
