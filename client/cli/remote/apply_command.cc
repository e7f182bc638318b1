// dynmesh apply MESH SCRIPT --server ADDR: sends an edit script to a server, one revision per
// batch, with the markers and names of features as their labels. Batches are pipelined and their
// diffs stream back. With --one-by-one each waits for the previous one, and the measured time is a
// whole round trip.
#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <type_traits>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/time/time.h"
#include "client/cli/mesh_flags.h"
#include "client/cli/percentile.h"
#include "client/cli/progress_bar.h"
#include "client/cli/remote/connection.h"
#include "client/cli/remote/remote_commands.h"
#include "core/base/text.h"
#include "core/io/script/edit_script.h"
#include "proto/codec/status_codec.h"

namespace dynmesh::cli {
namespace {

using Clock = std::chrono::steady_clock;

// Without an answer, while the server cannot be reached. With --request-prefix only.
constexpr std::chrono::seconds kPatience(30);
constexpr absl::Duration kPause = absl::Milliseconds(200);

struct ApplyCommand {
  ServerFlags server;
  std::string id;
  std::string script;
  std::string request_prefix;
  bool create = false;
  bool one_by_one = false;
  bool quiet = false;
};

double Microseconds(Clock::duration d) {
  return std::chrono::duration<double, std::micro>(d).count();
}

// True if the options that a script's first line can set agree.
bool SameMesh(const MeshOptions& a, const MeshOptions& b) {
  return io::FormatMeshLine(a) == io::FormatMeshLine(b);
}

class Application {
 public:
  explicit Application(const ApplyCommand& command) : command_(command) {}

  absl::Status Run() {
    absl::StatusOr<std::unique_ptr<client::MeshClient>> client = Connect(command_.server);
    if (!client.ok()) return client.status();
    client_ = *std::move(client);
    if (absl::Status status = ReadScript(); !status.ok()) return status;
    if (absl::Status status = PrepareMesh(); !status.ok()) return status;
    const Clock::time_point start = Clock::now();
    const absl::Status status = command_.one_by_one ? OneByOne() : Pipelined();
    progress_.End();
    if (status.ok()) return Summarise(Clock::now() - start);
    if (made_ && revisions_ == 0) WarnOfEmptyMesh(command_.id);
    return status;
  }

 private:
  // A script without a first line has as many coordinates per point as the mesh has dimensions, so
  // the mesh is queried first. With --create, a bad script makes no mesh.
  absl::Status ReadScript() {
    io::ScriptParseOptions parse;
    parse.require_header = command_.create;
    if (!command_.create) {
      const auto mesh = Patiently([&] { return client_->GetMesh(command_.id); });
      if (!mesh.ok()) return mesh.status();
      parse.dimension = mesh->options.dimension;
    }
    absl::StatusOr<io::EditScript> script = io::ReadEditScript(command_.script, parse);
    if (!script.ok()) return script.status();
    script_ = *std::move(script);
    script_.batches = io::LabelledBatches(script_);
    return absl::OkStatus();
  }

  absl::Status PrepareMesh() {
    const MeshOptions wanted = script_.Options();
    if (command_.create) {
      // The server would refuse it, too, but without the line.
      if (absl::Status s = ValidateOptions(wanted); !s.ok()) {
        return NameOption(s, MeshFlags(),
                          [this](std::string_view option) { return script_.WhereOption(option); });
      }
      const auto made = Patiently([&] { return client_->CreateMesh(command_.id, wanted); });
      made_ = made.ok();
      if (made.ok() || made.status().code() != absl::StatusCode::kAlreadyExists) {
        return made.status();
      }
    }
    const auto mesh = Patiently([&] { return client_->GetMesh(command_.id); });
    if (!mesh.ok()) return mesh.status();
    if (mesh->options.dimension != script_.dimension) {
      return absl::InvalidArgumentError(absl::StrFormat("%s has %d dimensions, the mesh has %d",
                                                        script_.name, script_.dimension,
                                                        mesh->options.dimension));
    }
    if (script_.has_header && !SameMesh(mesh->options, wanted)) {
      PrintWarning(text::Concat("the mesh is not the one of the script's first line, but: ",
                                io::FormatMeshLine(mesh->options)));
    }
    return absl::OkStatus();
  }

  client::EditParams Params(std::size_t batch) const {
    client::EditParams params;
    params.dimension = script_.dimension;
    if (!command_.request_prefix.empty()) {
      params.request_id = absl::StrCat(command_.request_prefix, "-", batch + 1);
    }
    return params;
  }

  // Calls again while the connection is cut, as far as that is safe.
  template <typename Call>
  std::invoke_result_t<const Call&> Patiently(const Call& call) const {
    const Clock::time_point end = Clock::now() + kPatience;
    auto result = call();
    while (IsCut(result.status()) && Clock::now() < end) {
      client_->PauseBeforeRetry(kPause);
      result = call();
    }
    return result;
  }

  absl::Status OneByOne() {
    for (std::size_t b = 0; b < script_.batches.size(); ++b) {
      const Clock::time_point start = Clock::now();
      const auto result = Patiently(
          [&] { return client_->Apply(command_.id, script_.batches[b].edits, Params(b)); });
      latencies_.push_back(Microseconds(Clock::now() - start));
      if (absl::Status status = Take(b, result); !status.ok()) return status;
    }
    return absl::OkStatus();
  }

  // Several sessions if the mesh moves to another server, or the server starts again, meanwhile.
  absl::Status Pipelined() {
    std::size_t answered = 0;
    Clock::time_point last = Clock::now();  // answer
    for (int in_vain = 0;; ++in_vain) {
      const std::size_t before = answered;
      absl::Status cut;
      if (absl::Status s = Session(answered, cut); !s.ok() || cut.ok()) return s;
      if (answered > before) last = Clock::now(), in_vain = 0;
      if (Clock::now() > last + kPatience) return AtLine(answered, cut);
      if (in_vain > 0) client_->PauseBeforeRetry(kPause);
    }
  }

  // Sends the batches from `answered` on, and counts the answers there. `cut`: not OK if the rest
  // can be sent again in another session.
  absl::Status Session(std::size_t& answered, absl::Status& cut) {
    const auto session = client_->OpenEdits(command_.id, /*stop_on_error=*/true);
    std::thread sender([&, first = answered] {
      for (std::size_t b = first; b < script_.batches.size(); ++b) {
        if (!session->Send(script_.batches[b].edits, Params(b)).ok()) return;  // Receive reports it
      }
      // If that fails, Finish reports why.
      static_cast<void>(session->DoneSending());
    });
    absl::Status status;
    while (auto answer = session->Receive()) {
      if (IsCut(answer->result.status())) {
        cut = answer->result.status();
        break;
      }
      status = Take(answered++, answer->result);
      if (!status.ok()) break;
    }
    if (!status.ok() || !cut.ok()) session->Cancel();
    sender.join();
    while (session->Receive().has_value()) {
    }
    const absl::Status end = session->Finish();
    if (!status.ok() || !cut.ok()) return status;
    if (IsCut(end)) cut = end;
    if (!end.ok()) {
      if (!cut.ok()) return absl::OkStatus();
      return answered < script_.batches.size() ? AtLine(answered, end) : end;
    }
    if (answered == script_.batches.size()) return absl::OkStatus();
    return absl::DataLossError("the server did not answer every batch");
  }

  // True if what has no answer can be sent again, perhaps to another server: it was not applied, or
  // the batches have ids.
  bool IsCut(const absl::Status& status) const {
    if (!absl::IsUnavailable(status)) return false;
    const auto error = codec::GetServiceError(status);
    if (error.has_value() && error->reason == codec::reason::kNotOwner) return true;
    return !command_.request_prefix.empty() &&
           (!error.has_value() || error->reason != codec::reason::kJournalFailed);
  }

  absl::Status Take(std::size_t batch, const absl::StatusOr<client::EditResult>& result) {
    if (!result.ok()) return AtLine(batch, result.status());
    ++revisions_;
    edits_ += script_.batches[batch].edits.size();
    replayed_ += result->replayed ? 1 : 0;
    hash_ = result->diff.hash;
    progress_.Show(batch + 1, script_.batches.size());
    if (command_.quiet) return absl::OkStatus();
    if (PrintOut(DiffLine(result->diff, result->replayed ? "replayed" : "applied",
                          command_.server.json))) {
      return absl::OkStatus();
    }
    return absl::UnavailableError("cannot write to standard output");
  }

  // The error of a batch that was refused or not answered, at the line of the edit to blame. If the
  // server is not there: how far the script has come, and how to go on.
  absl::Status AtLine(std::size_t batch, const absl::Status& status) const {
    const auto error = codec::GetServiceError(status);
    std::optional<std::size_t> edit;
    std::uint64_t index = 0;
    if (error.has_value() && error->metadata.contains("edit") &&
        absl::SimpleAtoi(error->metadata.at("edit"), &index)) {
      edit = index;
    }
    std::string told =
        text::Concat(script_.Where(batch, edit), ": ", text::View(WithReason(status).message()));
    if (absl::IsUnavailable(status)) {
      absl::StrAppendFormat(&told, "; %d of %d batches are known to be applied", batch,
                            script_.batches.size());
      told += command_.request_prefix.empty()
                  ? ". With --request-prefix the command goes on after a broken connection"
                  : ". The same command applies the others: what is applied is not repeated";
    }
    return {status.code(), told};
  }

  absl::Status Summarise(Clock::duration took) {
    const double seconds = std::chrono::duration<double>(took).count();
    const double p50 = Percentile(latencies_, 0.50);
    const double p99 = Percentile(latencies_, 0.99);
    std::string line;
    if (command_.server.json) {
      JsonObject object;
      object.Add("summary", true)
          .Add("revisions", revisions_)
          .Add("edits", edits_)
          .Add("replayed", replayed_)
          .Add("seconds", seconds);
      if (command_.one_by_one) {
        object.Add("p50_microseconds", p50).Add("p99_microseconds", p99);
      }
      line = object.AddText("hash", hash_.ToHex()).ToLine();
    } else {
      line = absl::StrFormat("%d revisions, %d edits in %.3f s", revisions_, edits_, seconds);
      if (command_.one_by_one) {
        absl::StrAppendFormat(&line, "; %.0f us typical, %.0f us at the 99th percentile", p50, p99);
      }
      absl::StrAppendFormat(&line, "\nhash %s\n", hash_.ToHex());
    }
    if (PrintOut(line)) return absl::OkStatus();
    return absl::UnavailableError("cannot write to standard output");
  }

  const ApplyCommand& command_;
  io::EditScript script_;
  std::unique_ptr<client::MeshClient> client_;
  std::vector<double> latencies_;
  bool made_ = false;  // the mesh, by this command
  std::uint64_t revisions_ = 0;
  std::uint64_t edits_ = 0;
  std::uint64_t replayed_ = 0;
  MeshHash hash_;
  // If results go to the same terminal, their lines show the progress.
  ProgressBar progress_{ErrorIsTerminal() && (command_.quiet || !OutIsTerminal())};
};

int Run(const ApplyCommand& command) {
  const absl::Status status = Application(command).Run();
  return status.ok() ? kExitDone : ReportServerError(status);
}

}  // namespace

void RegisterApplyCommand(CLI::App& app, CommandSlot& slot) {
  auto command = std::make_shared<ApplyCommand>();
  CLI::App* const sub = AddCommand(app, slot, "apply", "Apply an edit script to a server's mesh",
                                   [command] { return Run(*command); });
  sub->add_option("MESH", command->id, "Its id")->required();
  sub->add_option("SCRIPT", command->script, "The edit script")->required();
  sub->add_flag("--create", command->create,
                "Create the mesh by the script's first line unless it exists");
  sub->add_option("--request-prefix", command->request_prefix,
                  "Give batch N the request id PREFIX-N: applying again repeats nothing. While the "
                  "server cannot be reached, the command tries for up to 30 s")
      ->type_name("PREFIX");
  sub->add_flag("--one-by-one", command->one_by_one,
                "Wait for each answer, and tell how long they took");
  sub->add_flag("-q,--quiet", command->quiet, "No line for each revision");
  AddServerFlags(*sub, command->server);
}

}  // namespace dynmesh::cli
