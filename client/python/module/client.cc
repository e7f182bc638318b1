// Meshes of a server, through the C++ client.
#include <pybind11/functional.h>
#include <pybind11/stl.h>

#include <map>

#include "client/python/module/arrays.h"
#include "client/python/module/bind.h"
#include "client/python/module/progress_call.h"
#include "client/python/module/status.h"
#include "dynmesh/client/mesh_client.h"

namespace dynmesh::python {
namespace {

using client::MeshClient;

py::dict InfoDict(const client::MeshInfo& info) {
  py::dict d;
  d["id"] = info.id;
  d["revision"] = info.revision;
  d["hash"] = info.hash.ToHex();
  d["options"] = OptionsDict(info.options);
  d["damage"] = info.damage;
  d["owner"] = info.owner;
  d["read_only"] = info.read_only;
  return d;
}

py::dict StatsDict(const client::ServerStatus& status) {
  py::dict d;
  d["version"] = status.version;
  d["uptime"] = absl::ToDoubleSeconds(status.uptime);
  d["meshes"] = status.meshes;
  d["watchers"] = status.watchers;
  if (!status.mesh.has_value()) return d;
  const client::MeshStatus& mesh = *status.mesh;
  py::dict m;
  m["revision"] = mesh.stats.revision, m["features"] = mesh.stats.features;
  m["vertices"] = mesh.stats.vertices, m["simplices"] = mesh.stats.simplices;
  m["oldest_revision"] = mesh.oldest_revision, m["hash"] = mesh.hash.ToHex();
  d["mesh"] = m;
  return d;
}

client::EditParams ParamsOf(const Batch& batch, const std::string& request_id,
                            std::optional<std::uint64_t> expected_revision, bool validate_only) {
  client::EditParams params;
  params.request_id = request_id;
  params.expected_revision = expected_revision;
  params.validate_only = validate_only;
  params.dimension = batch.dimension;
  return params;
}

std::shared_ptr<Diff> DiffOf(client::EditResult result) {
  return std::make_shared<Diff>(Diff{std::move(result.diff), result.replayed});
}

const char* NameOf(client::LoadProgress::Stage stage) {
  constexpr const char* kNames[] = {"send", "wait", "validate", "refine", "diff", "write"};
  return kNames[static_cast<std::size_t>(stage)];
}

// Those that the batch adds, with the labels that it sets then.
std::vector<Feature> FeaturesOf(const Batch& batch) {
  std::vector<Feature> features;
  features.reserve(batch.edits.size());
  std::map<FeatureId, std::size_t>
      rows;  // of the first of `features`, as far as they are looked for
  for (const Edit& edit : batch.edits) {
    if (edit.action != Edit::Action::kSetLabel) {
      features.push_back(edit.feature);
      continue;
    }
    while (rows.size() < features.size()) rows.emplace(features[rows.size()].id, rows.size());
    const auto row = rows.find(edit.feature.id);
    Require(row != rows.end(), "a load labels what it has added: there is no feature " +
                                   std::to_string(edit.feature.id));
    features[row->second].label = edit.feature.label;
  }
  return features;
}

py::dict Load(MeshClient& client, const std::string& mesh, const Batch& batch,
              const std::string& request_id, const py::object& progress) {
  const std::vector<Feature> features = FeaturesOf(batch);
  client::LoadParams params;
  params.request_id = request_id;
  params.dimension = batch.dimension;
  ProgressCall call(progress);
  params.cancelled = call.cancelled();
  params.progress = [&](const client::LoadProgress& p) { call(NameOf(p.stage), p.done, p.total); };
  absl::StatusOr<client::LoadResult> result = absl::UnknownError("");
  {
    py::gil_scoped_release release;
    result = client.Load(mesh, features, params);
  }
  call.RaiseIf(!result.ok());
  const client::LoadResult loaded = Value(std::move(result));
  py::dict d;
  d["from_revision"] = loaded.from_revision, d["to_revision"] = loaded.to_revision;
  d["hash"] = loaded.hash.ToHex(), d["replayed"] = loaded.replayed;
  return d;
}

// Waits in slices, so that Ctrl-C is handled.
py::object Next(client::DiffStream& stream, double seconds) {
  constexpr double kSlice = 0.1;
  for (double left = seconds; left > 0; left -= kSlice) {
    std::optional<client::DiffStream::Event> event;
    {
      py::gil_scoped_release release;
      event = Value(stream.Next(absl::Seconds(std::min(left, kSlice))));
    }
    if (event.has_value()) {
      if (auto* diff = std::get_if<MeshDiff>(&*event)) {
        return py::cast(std::make_shared<Diff>(Diff{std::move(*diff), false}));
      }
      return py::cast(std::make_shared<Mesh>(std::get<Mesh>(std::move(*event))));
    }
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
  }
  return py::none();
}

MeshHash HashOf(const std::string& hex) { return Value(MeshHash::FromHex(hex)); }

}  // namespace

void BindClient(py::module_& module) {
  using Release = py::call_guard<py::gil_scoped_release>;
  py::class_<client::EditSession>(module, "EditSession")
      .def("send",
           [](client::EditSession& session, const Batch& batch, const std::string& request_id) {
             py::gil_scoped_release release;
             Check(session.Send(batch.edits, ParamsOf(batch, request_id, {}, false)));
           })
      .def("done",
           [](client::EditSession& session) {
             py::gil_scoped_release release;
             Check(session.DoneSending());
           })
      // The next answer, or nothing at the end; raises the server's error of the batch.
      .def("receive",
           [](client::EditSession& session) -> std::shared_ptr<Diff> {
             std::optional<client::EditSession::Answer> answer;
             {
               py::gil_scoped_release release;
               answer = session.Receive();
             }
             if (!answer.has_value()) return nullptr;
             return DiffOf(Value(std::move(answer->result)));
           })
      .def("finish",
           [](client::EditSession& session) {
             py::gil_scoped_release release;
             Check(session.Finish());
           })
      .def("cancel", &client::EditSession::Cancel);

  py::class_<client::DiffStream>(module, "DiffStream")
      .def("next", &Next, py::arg("seconds"))
      .def("cancel", &client::DiffStream::Cancel, Release());

  py::class_<MeshClient>(module, "Client")
      .def(py::init([](const std::string& address, const std::string& token,
                       const std::string& tls_ca, const std::string& tls_certificate,
                       const std::string& tls_key, double timeout, bool from_followers) {
             client::ClientOptions options;
             options.token = token;
             options.tls_ca = tls_ca;
             options.tls_certificate = tls_certificate;
             options.tls_key = tls_key;
             if (timeout > 0) options.timeout = absl::Seconds(timeout);
             options.own_connection = true;
             options.from_followers = from_followers;
             return MeshClient::Connect(address, options);
           }),
           py::arg("address"), py::arg("token"), py::arg("tls_ca"), py::arg("tls_certificate"),
           py::arg("tls_key"), py::arg("timeout"), py::arg("from_followers"))
      .def("servers_returned", &MeshClient::servers_returned)
      .def("create",
           [](MeshClient& c, const std::string& id, const py::dict& options,
              const std::string& request_id) {
             const MeshOptions asked = OptionsOf(options);
             py::gil_scoped_release release;
             auto info = Value(c.CreateMesh(id, asked, request_id));
             py::gil_scoped_acquire acquire;
             return InfoDict(info);
           })
      .def("get",
           [](MeshClient& c, const std::string& mesh) {
             py::gil_scoped_release release;
             auto info = Value(c.GetMesh(mesh));
             py::gil_scoped_acquire acquire;
             return InfoDict(info);
           })
      .def("list",
           [](MeshClient& c) {
             py::gil_scoped_release release;
             const auto infos = Value(c.ListMeshes());
             py::gil_scoped_acquire acquire;
             py::list result;
             for (const auto& info : infos) result.append(InfoDict(info));
             return result;
           })
      .def("delete",
           [](MeshClient& c, const std::string& mesh) {
             py::gil_scoped_release release;
             Check(c.DeleteMesh(mesh));
           })
      .def(
          "apply",
          [](MeshClient& c, const std::string& mesh, const Batch& batch,
             const std::string& request_id, std::optional<std::uint64_t> expected_revision,
             bool validate_only) {
            py::gil_scoped_release release;
            return DiffOf(Value(c.Apply(
                mesh, batch.edits, ParamsOf(batch, request_id, expected_revision, validate_only))));
          })
      .def("load", &Load)
      .def("revert",
           [](MeshClient& c, const std::string& mesh, std::uint64_t revision,
              const std::string& request_id) {
             py::gil_scoped_release release;
             client::EditParams params;
             params.request_id = request_id;
             return DiffOf(Value(c.RevertTo(mesh, revision, params)));
           })
      .def("features",
           [](MeshClient& c, const std::string& mesh, int dimension,
              std::optional<std::uint64_t> revision) {
             py::gil_scoped_release release;
             const auto features = Value(c.GetFeatures(mesh, revision));
             py::gil_scoped_acquire acquire;
             return FeatureDicts(features.features, dimension);
           })
      .def("snapshot",
           [](MeshClient& c, const std::string& mesh) {
             py::gil_scoped_release release;
             return std::make_shared<Mesh>(Value(c.GetSnapshot(mesh)));
           })
      .def(
          "locate",
          [](MeshClient& c, const std::string& mesh, int dimension, const InArray<double>& points) {
            client::Located located;
            {
              const auto positions = SpanOf(points);
              py::gil_scoped_release release;
              located = Value(c.Locate(mesh, dimension, positions));
            }
            return py::make_tuple(located.revision, Take(std::move(located.simplices),
                                                         static_cast<std::size_t>(dimension + 1)));
          })
      .def("stats",
           [](MeshClient& c, const std::string& mesh) {
             py::gil_scoped_release release;
             const auto status = Value(c.GetStats(mesh));
             py::gil_scoped_acquire acquire;
             return StatsDict(status);
           })
      .def(
          "open_edits",
          [](MeshClient& c, const std::string& mesh, bool stop_on_error) {
            return c.OpenEdits(mesh, stop_on_error);
          },
          py::keep_alive<0, 1>())
      .def(
          "stream",
          [](MeshClient& c, const std::string& mesh, std::uint64_t revision,
             const std::string& hash, bool takes_snapshots, double patience) {
            client::DiffStreamOptions options;
            options.start_revision = revision;
            options.start_hash = HashOf(hash);
            options.takes_snapshots = takes_snapshots;
            options.patience = absl::Seconds(patience);
            return c.StreamDiffs(mesh, options);
          },
          py::keep_alive<0, 1>());
}

}  // namespace dynmesh::python
