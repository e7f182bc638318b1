// Writes the seeds of the targets that take messages: make_wire_corpus tests/fuzz/corpus
// Those of `requests`, `answers` and `journal` there are made by this.
#include <filesystem>
#include <fstream>
#include <string>

#include "dynmesh/v1/mesh_service.pb.h"
#include "dynmesh/v1/status_details.pb.h"
#include "proto/codec/edit_codec.h"
#include "proto/codec/journal_codec.h"
#include "proto/codec/mesh_codec.h"
#include "proto/codec/status_codec.h"

namespace dynmesh::fuzz {
namespace {

class Seed {
 public:
  Seed& Part(int kind, const std::string& body) {
    if (!bytes_.empty()) bytes_ += "\n---\n";
    bytes_ += static_cast<char>(kind) + body;
    return *this;
  }
  template <typename Message>
  Seed& Say(int kind, const Message& message) {
    return Part(kind, message.SerializeAsString());
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

void Write(const std::filesystem::path& file, const std::string& bytes) {
  std::filesystem::create_directories(file.parent_path());
  std::ofstream(file, std::ios::binary) << bytes;
}

EditBatch Square(int dimension) {
  const double z = dimension == 3 ? 0.5 : 0;
  Feature labelled = Feature::Point(1, 0.25, 0.25, z);
  labelled.label = FeatureLabel{-3, "corner"};
  return {Edit::Add(labelled),
          Edit::Add(Feature::Point(2, 0.75, 0.25, z)),
          Edit::Add(Feature::Point(3, 0.75, 0.75, z)),
          Edit::Add(Feature::Point(4, 0.25, 0.75, z)),
          Edit::Add(Feature::Polygon(5, {{1, 2, 3, 4}})),
          Edit::Add(Feature::Segment(6, 1, 2)),
          Edit::Add(Feature::Size(7, {0.5, 0.5, z}, {SizeShape::kDisc, 0.3, 0.1, {}})),
          Edit::SetLabel(5, {1, "\u00c4u\u00dferes"})};
}

template <typename Request>
Request Edits(const std::string& mesh, const EditBatch& batch, int dimension) {
  Request request;
  request.set_mesh(mesh);
  for (const Edit& edit : batch) codec::EncodeEdit(edit, dimension, request.add_edits());
  return request;
}

v1::CreateMeshRequest Create(const std::string& id, int dimension) {
  v1::CreateMeshRequest request;
  request.set_mesh_id(id);
  request.set_request_id("made");
  MeshOptions options;
  options.dimension = dimension;
  options.quality = DefaultQuality(dimension);
  codec::EncodeOptions(options, request.mutable_options());
  request.mutable_options()->set_max_vertices(800);
  return request;
}

v1::WatchRequest WatchFrom(const std::string& mesh, int revision) {
  v1::WatchRequest request;
  request.set_mesh(mesh);
  if (revision >= 0) request.set_start_revision(static_cast<std::uint64_t>(revision));
  return request;
}

// Kinds as in requests_fuzz.cc.
void WriteRequests(const std::filesystem::path& folder) {
  const std::string m = "meshes/m", s = "meshes/s";
  auto named = Edits<v1::ApplyEditsRequest>(m, Square(2), 2);
  named.set_request_id("r");
  auto expecting = Edits<v1::ApplyEditsRequest>(m, {Edit::Move(1, 0.3, 0.2)}, 2);
  expecting.set_expected_revision(1);
  auto checked = Edits<v1::ApplyEditsRequest>(m, {Edit::Remove(7)}, 2);
  checked.set_validate_only(true);
  v1::WatchRequest part = WatchFrom(m, -1);
  part.add_regions(5);
  Write(folder / "plane", Seed()
                              .Say(3, named)
                              .Say(3, named)
                              .Say(3, expecting)
                              .Say(3, expecting)
                              .Say(3, checked)
                              .Say(6, WatchFrom(m, -1))
                              .Say(6, WatchFrom(m, 1))
                              .Say(6, part)
                              .bytes());
  Write(folder / "space", Seed()
                              .Say(0, Create("s", 3))
                              .Say(3, Edits<v1::ApplyEditsRequest>(s, Square(3), 3))
                              .Say(6, WatchFrom(s, -1))
                              .bytes());
  v1::AddFeaturesRequest add;
  add.set_mesh(m);
  codec::EncodeFeature(Feature::Point(9, 0.5, 0.5), 2, add.add_features());
  v1::RemoveFeaturesRequest remove;
  remove.set_mesh(m);
  remove.add_ids(9);
  v1::LocatePointsRequest locate;
  locate.set_mesh(m);
  for (const double x : {0.5, 0.5, -3.0, 0.2}) locate.add_coordinates(x);
  v1::GetSnapshotRequest snapshot;
  snapshot.set_mesh(m);
  v1::DeleteMeshRequest gone;
  gone.set_mesh(m);
  Write(folder / "others", Seed()
                               .Say(1, add)
                               .Say(7, locate)
                               .Say(8, snapshot)
                               .Say(2, remove)
                               .Say(2, remove)
                               .Say(9, gone)
                               .Say(8, snapshot)
                               .bytes());
  auto first = Edits<v1::EditBatch>(m, {Edit::Add(Feature::Point(1, 0.1, 0.9))}, 2);
  first.set_more(true);
  const auto last = Edits<v1::EditBatch>("", {Edit::Add(Feature::Point(2, 0.2, 0.9))}, 2);
  const auto bad = Edits<v1::EditBatch>("", {Edit::Remove(77)}, 2);
  Write(folder / "stream", Seed().Say(4, first).Say(4, last).Say(4, bad).Say(4, first).bytes());
  Write(folder / "packed-plane",
        Seed().Part(10, "\x01\x07\x01\x05\x40\x40\x80\x80\x07\x02").bytes());
  Write(folder / "packed-space",
        Seed().Part(11, "\x01\x07\x01\x05\x40\x40\x80\x80\x20\x20").bytes());
}

EditBatch Capsules(int dimension) {
  const double z = dimension == 3 ? 0.5 : 0;
  const Path path = {{0.25, 0.25, z}, {0.75, 0.25, z}, {0.75, 0.75, z}};
  return {Edit::Add(Feature::SizeCapsule(7, path, 0.1, 0.3)),
          Edit::Set(Feature::SizeCapsule(7, {path[0], path[2]}, 0.05, 0.3))};
}

void WriteCapsules(const std::filesystem::path& folder) {
  Write(folder / "capsules", Seed()
                                 .Say(3, Edits<v1::ApplyEditsRequest>("meshes/m", Capsules(2), 2))
                                 .Say(0, Create("s", 3))
                                 .Say(3, Edits<v1::ApplyEditsRequest>("meshes/s", Capsules(3), 3))
                                 .bytes());
}

// Kinds as in answers_fuzz.cc.
void WriteAnswers(const std::filesystem::path& folder) {
  Seed honest;
  for (int i = 0; i < 20; ++i) honest.Part(0, "");
  Write(folder / "honest-plane", honest.bytes());
  Seed space;
  space.Part(3, "");
  for (int i = 0; i < 20; ++i) space.Part(0, "");
  Write(folder / "honest-space", space.bytes());
  v1::WatchEvent event;
  event.mutable_snapshot()->set_dimension(2);
  event.mutable_snapshot()->set_revision(3);
  auto* vertices = event.mutable_snapshot()->mutable_vertices();
  for (int i = 0; i < 3; ++i) {
    const double place[] = {0.5 * i, 0.25 * i * i};
    vertices->add_ids(VertexIdAt(place, 2));
    vertices->add_coordinates(place[0]);
    vertices->add_coordinates(place[1]);
    vertices->add_owners(static_cast<std::uint64_t>(i));
    vertices->mutable_containing_dimensions()->push_back(static_cast<char>(i));
    event.mutable_snapshot()->mutable_simplices()->add_vertex_ids(vertices->ids(i));
  }
  event.mutable_snapshot()->mutable_simplices()->add_regions(7);
  event.mutable_snapshot()->mutable_labels()->add_features(2);
  event.mutable_snapshot()->mutable_labels()->add_names("inlet");
  Write(folder / "own-rows", Seed().Say(130, event).bytes());
  v1::WatchEvent mixed;
  *mixed.mutable_snapshot()->mutable_simplices() = event.snapshot().simplices();
  Write(folder / "mixed", Seed().Say(128, mixed).Part(4, "").Say(0, mixed).Part(7, "").bytes());
  v1::MeshDiff diff;
  diff.set_dimension(2);
  diff.set_to_revision(1);
  *diff.mutable_added_vertices() = event.snapshot().vertices();
  *diff.mutable_added_simplices() = event.snapshot().simplices();
  *diff.mutable_labels() = event.snapshot().labels();
  v1::MeshDiff begin = diff;
  begin.set_more(true);
  diff.set_hash(MeshHash().ToHex());
  Write(folder / "answer", Seed().Say(5, begin).Say(5, diff).Say(5, diff).bytes());
  codec::ServiceError error;
  error.reason = codec::reason::kQueueFull;
  error.metadata["features"] = "1,2,3";
  error.field = "edits[3]";
  error.retry_after = absl::Milliseconds(5);
  const absl::Status status =
      codec::MakeServiceError(absl::StatusCode::kResourceExhausted, "full", error);
  Write(folder / "status", Seed().Say(6, codec::StatusToProto(status)).bytes());
}

// Kinds as in journal_fuzz.cc.
void WriteJournal(const std::filesystem::path& folder) {
  for (const int dimension : {2, 3}) {
    const int odd = dimension - 2;
    const std::string end = dimension == 2 ? "-plane" : "-space";
    const EditBatch batch = Square(dimension);
    std::vector<Feature> features;
    for (const Edit& edit : batch) {
      if (edit.action == Edit::Action::kAdd) features.push_back(edit.feature);
    }
    const auto with = [](int kind, const std::string& b) { return static_cast<char>(kind) + b; };
    Write(folder / ("entry" + end),
          with(0 + odd, codec::EncodeJournalEntry(batch, MeshHash{1, 2}, dimension)));
    Write(folder / ("snapshot" + end),
          with(2 + odd, codec::EncodeJournalSnapshot(features, MeshHash{1, 2}, dimension)[0]));
    Write(folder / ("answer" + end),
          with(4 + odd, codec::EncodeJournalAnswer({1, 2, 3, 4, {5, 6}, {}})));
    codec::JournalMesh mesh;
    mesh.options.dimension = dimension;
    mesh.options.quality = DefaultQuality(dimension);
    mesh.create_time = absl::FromUnixSeconds(1'700'000'000);
    mesh.request_id = "made";
    Write(folder / ("mesh" + end), with(6 + odd, codec::EncodeJournalMesh(mesh)));
  }
}

}  // namespace
}  // namespace dynmesh::fuzz

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const std::filesystem::path folder = argv[1];
  dynmesh::fuzz::WriteRequests(folder / "requests");
  dynmesh::fuzz::WriteCapsules(folder / "requests");
  dynmesh::fuzz::WriteAnswers(folder / "answers");
  dynmesh::fuzz::WriteJournal(folder / "journal");
}
