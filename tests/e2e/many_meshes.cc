#include "tests/e2e/many_meshes.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "dynmesh/client/mesh_client.h"
#include "tests/e2e/random_edits.h"

namespace dynmesh::test {
namespace {

// Edits of a mesh under way: fewer than a server takes without the answers being received.
constexpr int kWindow = 256;

class EditedMesh {
 public:
  EditedMesh(client::MeshClient* client, int dimension, int number)
      : client_(client),
        name_(absl::StrCat("many-", number)),
        edits_(static_cast<std::uint64_t>(number), dimension) {
    params_.dimension = dimension;
    params_.omit_columns = true;
  }

  absl::Status Make(std::size_t points) {
    MeshOptions options;
    options.dimension = params_.dimension;
    if (absl::Status s = client_->CreateMesh(name_, options).status(); !s.ok()) return s;
    return client_->Apply(name_, edits_.Fill(points), params_).status();
  }
  void Open() { session_ = client_->OpenEdits(name_); }
  absl::Status Send() { return session_->Send({edits_.Next()}, params_); }
  absl::Status Receive() {
    const auto answer = session_->Receive();
    return answer.has_value() ? answer->result.status() : session_->Finish();
  }
  absl::Status Close() {
    if (absl::Status s = session_->DoneSending(); !s.ok()) return s;
    while (session_->Receive().has_value()) {
    }
    return session_->Finish();
  }
  absl::Status Delete() { return client_->DeleteMesh(name_); }

 private:
  client::MeshClient* const client_;
  const std::string name_;
  RandomEdits edits_;
  client::EditParams params_;
  std::unique_ptr<client::EditSession> session_;
};

}  // namespace

absl::StatusOr<double> EditManyMeshes(const std::string& servers, int dimension, int count,
                                      std::size_t points, int edits) {
  std::vector<std::string> addresses = absl::StrSplit(servers, ',');
  std::vector<std::unique_ptr<client::MeshClient>> clients;
  for (std::size_t i = 0; i < addresses.size(); ++i) {
    client::ClientOptions options;
    options.own_connection = true;
    clients.push_back(client::MeshClient::Connect(absl::StrJoin(addresses, ","), options));
    std::rotate(addresses.begin(), addresses.begin() + 1, addresses.end());
  }
  std::vector<std::unique_ptr<EditedMesh>> meshes;
  for (int i = 0; i < count; ++i) {
    const auto client = static_cast<std::size_t>(i) % clients.size();
    meshes.push_back(std::make_unique<EditedMesh>(clients[client].get(), dimension, i));
    if (absl::Status s = meshes.back()->Make(points); !s.ok()) return s;
  }
  absl::Status status;
  const auto all = [&](absl::Status (EditedMesh::*call)()) {
    for (std::size_t i = 0; i < meshes.size() && status.ok(); ++i) {
      status = (meshes[i].get()->*call)();
    }
  };
  for (const auto& mesh : meshes) mesh->Open();
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 0; i < edits + kWindow && status.ok(); ++i) {
    if (i < edits) all(&EditedMesh::Send);
    if (i >= kWindow) all(&EditedMesh::Receive);
  }
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  all(&EditedMesh::Close);
  all(&EditedMesh::Delete);
  if (!status.ok()) return status;
  return count * edits / took.count();
}

}  // namespace dynmesh::test
