// Answers of a faulty server. A part of the input is a kind and a message. A watch begins with the
// events of a correct server, into which messages may be merged (protobuf appends to columns and
// replaces numbers). The hash is corrected if possible, so that only a check of the rows finds the
// fault.
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "core/io/meshes/indexed_mesh.h"
#include "core/mesh_data/diff_meshes.h"
#include "dynmesh/client/mesh_replica.h"
#include "dynmesh/slot_mesh.h"
#include "dynmesh/v1/mesh_service.pb.h"
#include "dynmesh/v1/status_details.pb.h"
#include "proto/codec/grpc_status.h"
#include "proto/codec/mesh_codec.h"
#include "proto/codec/status_codec.h"
#include "tests/core/mesh_data/made_up_mesh.h"
#include "tests/fuzz/quiet.h"
#include "tests/fuzz/small_mesh.h"
#include "tests/fuzz/targets.h"

namespace dynmesh::fuzz {
namespace {

using client::MeshReplica;
using Events = std::vector<v1::WatchEvent>;

constexpr std::size_t kMostParts = 24;

void AddSnapshot(const Mesh& mesh, Events& events) {
  codec::SnapshotFragmenter fragmenter(std::make_shared<Mesh>(mesh), 600);
  v1::WatchEvent event;
  while (fragmenter.Next(event.mutable_snapshot())) events.push_back(event);
}

// A snapshot in chunks, diffs in fragments, progress.
Events HonestEvents(int dimension) {
  testing::Random random(static_cast<std::uint64_t>(dimension));
  Events events;
  std::optional<Mesh> before;
  for (std::uint64_t revision = 5; revision < 9; ++revision) {
    Mesh mesh = testing::MakeUpMesh(random, 10, revision, dimension);
    testing::Label(random, mesh);
    if (!before.has_value()) {
      AddSnapshot(mesh, events);
    } else {
      MeshDiff diff = mesh_data::DiffMeshes(*before, mesh);
      diff.from_revision = revision - 1;
      diff.to_revision = revision;
      codec::DiffFragmenter fragmenter(std::make_shared<MeshDiff>(diff), false, 600);
      v1::WatchEvent event;
      while (fragmenter.Next(event.mutable_diff())) events.push_back(event);
    }
    v1::WatchEvent event;
    event.mutable_progress()->set_revision(revision);
    event.mutable_progress()->set_hash(mesh.hash.ToHex());
    events.push_back(event);
    before = std::move(mesh);
  }
  return events;
}

const Events& Honest(int dimension) {
  static const Events plane = HonestEvents(2), space = HonestEvents(3);
  return dimension == 2 ? plane : space;
}

// A whole snapshot gets the hash of its rows, whatever these are.
void PutHashRight(v1::WatchEvent& event) {
  if (!event.has_snapshot() || event.snapshot().more() || event.snapshot().index() != 0) return;
  event.mutable_snapshot()->set_hash(MeshHash().ToHex());
  codec::SnapshotAssembler assembler;
  const auto mesh = assembler.Add(event.snapshot());
  if (mesh.ok() && mesh->has_value()) {
    event.mutable_snapshot()->set_hash(ComputeHash(**mesh).ToHex());
  }
}

class Watch {
 public:
  // Empty, or what is wrong.
  std::string Take(const v1::WatchEvent& event) {
    const std::uint64_t revision = replica_.revision();
    const MeshHash hash = replica_.hash();
    const auto change = replica_.Take(event);
    if (!change.ok()) {
      if (change.status().message().empty()) return "a refusal without a message";
      if (replica_.state() != MeshReplica::State::kBroken) return "an error, and not broken";
    }
    if (!change.ok() || std::holds_alternative<MeshReplica::Nothing>(*change)) {
      const bool same = replica_.revision() == revision && replica_.hash() == hash;
      return same ? "" : "half an event, or a bad one, changed the mesh";
    }
    if (replica_.state() != MeshReplica::State::kLive) return "an event was taken, and not live";
    return CheckMesh();
  }

  void EndOfStream() { replica_.EndOfStream(); }

  // The watch restarts from a snapshot, and nothing of the old state is left.
  std::string BeginAnew(int dimension) {
    replica_.EndOfStream();
    for (const v1::WatchEvent& event : Honest(dimension)) {
      if (const auto change = replica_.Take(event); !change.ok()) {
        return "an honest event is refused: " + change.status().ToString();
      }
    }
    return CheckMesh();
  }

 private:
  std::string CheckMesh() const {
    const Mesh mesh = replica_.ToMesh();
    if (ComputeHash(mesh) != replica_.hash()) return "the hash is not that of the rows";
    if (!SlotMesh::FromMesh(mesh).ok()) return "the rows are not those of a mesh";
    // The commands' use of it.
    if (const auto indexed = io::IndexMesh(mesh); indexed.ok()) {
      for (std::size_t i = 0; i < indexed->simplex_count(); ++i) io::MeasureSimplex(*indexed, i);
    }
    return "";
  }

  MeshReplica replica_;
};

// The answer to an edit: assembled and fragmented again, it must be the same.
std::string CheckDiff(codec::DiffAssembler& assembler, const v1::MeshDiff& fragment) {
  const auto whole = assembler.Add(fragment);
  if (!whole.ok()) {
    return assembler.empty() ? "" : "a part of a broken diff was kept";
  }
  if (!whole->has_value()) return "";
  codec::DiffFragmenter first(std::make_shared<MeshDiff>(**whole));
  v1::MeshDiff message;
  codec::DiffAssembler again;
  std::optional<MeshDiff> copy;
  while (first.Next(&message)) {
    const auto added = again.Add(message);
    if (!added.ok()) return "our own diff is refused: " + added.status().ToString();
    if (added->has_value()) copy = **added;
  }
  if (!copy.has_value()) return "our own diff has no end";
  codec::DiffFragmenter second(std::make_shared<MeshDiff>(*copy));
  v1::MeshDiff message_again;
  codec::DiffFragmenter anew(std::make_shared<MeshDiff>(**whole));
  while (anew.Next(&message)) {
    if (!second.Next(&message_again) ||
        message.SerializeAsString() != message_again.SerializeAsString()) {
      return "a diff does not survive the wire";
    }
  }
  return "";
}

std::string CheckStatus(const v1::Status& proto, const std::string& bytes) {
  const absl::Status status = codec::StatusFromProto(proto);
  if (proto.code() != 0 && status.ok()) return "an error became none";
  if (const auto error = codec::GetServiceError(status)) (void)error->Features();
  const v1::Status back = codec::StatusToProto(status);
  if (codec::StatusFromProto(back).code() != status.code()) return "a status changed its code";
  const grpc::Status raw(grpc::StatusCode::ABORTED, "words", bytes);
  if (codec::FromGrpcStatus(raw).ok()) return "an error of gRPC became none";
  return "";
}

}  // namespace

std::string FuzzAnswers(std::string_view bytes) {
  BeQuiet();
  Watch watch;
  codec::DiffAssembler answer;
  int dimension = 2;
  std::size_t next = 0;  // of the honest events
  std::size_t parts = 0;
  std::string problem;
  for (const std::string_view part : SplitFiles(bytes)) {
    if (!problem.empty() || ++parts > kMostParts) break;
    const int kind = part.empty() ? 0 : static_cast<unsigned char>(part[0]);
    const std::string body(part.substr(part.empty() ? 0 : 1));
    v1::WatchEvent event;
    v1::MeshDiff diff;
    v1::Status status;
    switch (kind % 8) {
      case 0:  // the correct server's next event, mixed with something
      case 1:  // or an event out of order
        if (kind % 8 == 1 && !body.empty()) next = static_cast<unsigned char>(body[0]);
        event = Honest(dimension)[next++ % Honest(dimension).size()];
        if (kind % 8 == 0 && !event.MergeFromString(body)) break;
        if (kind >= 128) PutHashRight(event);
        problem = watch.Take(event);
        break;
      case 2:
        if (!event.ParseFromString(body)) break;
        if (kind >= 128) PutHashRight(event);
        problem = watch.Take(event);
        break;
      case 3:
        dimension = 5 - dimension;
        next = 0;
        break;
      case 4:
        watch.EndOfStream();
        next = 0;
        break;
      case 5:
        if (diff.ParseFromString(body)) problem = CheckDiff(answer, diff);
        break;
      case 6:
        // As it is, for what only details can break; and parsed.
        (void)status.ParseFromString(body);
        problem = CheckStatus(status, body);
        break;
      default:
        problem = watch.BeginAnew(dimension);
    }
  }
  return problem.empty() ? watch.BeginAnew(dimension) : problem;
}

}  // namespace dynmesh::fuzz
