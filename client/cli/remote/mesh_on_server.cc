// dynmesh mesh INPUT --server ADDR: the mesh is made by a server that does not keep it.
#include <memory>
#include <string>

#include "absl/strings/strip.h"
#include "client/cli/command.h"
#include "client/cli/progress_bar.h"
#include "client/cli/remote/connection.h"
#include "client/cli/remote_mesher.h"
#include "dynmesh/error.h"
#include "proto/codec/status_codec.h"

namespace dynmesh::cli {
namespace {

// The caller reads errors of the library, which names options without their message.
absl::Status AsOfLibrary(const absl::Status& status) {
  const auto error = codec::GetServiceError(status);
  if (!error.has_value()) return status;
  absl::string_view message = status.message();
  if (error->reason == reason::kBadOption) absl::ConsumePrefix(&message, "options.");
  return MakeError(status.code(), std::string(message), {error->reason, error->Features(), {}});
}

class ServerMesher final : public RemoteMesher {
 public:
  ServerMesher() { server_.address.clear(); }

  void AddFlags(CLI::App& command) override {
    AddConnectionFlags(command, server_,
                       "Make the mesh on this server, which does not keep it (default: in this "
                       "process)");
  }
  bool is_chosen() const override { return !server_.address.empty(); }

  absl::StatusOr<Mesh> Build(std::span<const Feature> features, const MeshOptions& options,
                             const BuildOptions& build) override {
    const auto client = Connect(server_);
    if (!client.ok()) return client.status();
    ProgressBar bar(ErrorIsTerminal());
    client::BuildParams params;
    params.engine = build.engine;
    params.only_inside = build.only_inside;
    params.progress = [&](const client::LoadProgress& p) {
      const bool sending = p.stage == client::LoadProgress::Stage::kSend;
      bar.Show(p.done, sending ? features.size() : p.total, WordOf(p.stage));
    };
    absl::StatusOr<Mesh> mesh = (*client)->BuildMesh(features, options, params);
    bar.End();
    if (!mesh.ok()) return AsOfLibrary(mesh.status());
    return mesh;
  }

 private:
  ServerFlags server_;
};

}  // namespace

std::shared_ptr<RemoteMesher> MakeRemoteMesher() { return std::make_shared<ServerMesher>(); }

}  // namespace dynmesh::cli
