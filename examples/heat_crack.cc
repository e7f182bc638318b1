// Heat conduction in a plate through which a cooled crack grows: heat_crack.py as a C++ client.
//
//   heat_crack --server HOST:PORT [--edge 0.02] [--steps 40] [--out out/heat_crack_cc]
//
// The mesh is at a server. The program sends one edit per step and follows the stream of diffs with
// a replica in slots: arrays with one entry per slot need no renumbering. P1 finite elements,
// implicit Euler. Each step assembles the element matrices of the patch only and transfers the
// temperature across the edit.
//
// Writes a series for ParaView, and finally checks that every edit conserves heat, temperatures
// stay within their bounds, and the mesh equals one made from scratch.
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "dynmesh/client/diff_stream.h"
#include "dynmesh/client/edit_session.h"
#include "dynmesh/client/mesh_client.h"
#include "dynmesh/codec/features_at.h"
#include "dynmesh/feature.h"
#include "dynmesh/mesh.h"
#include "dynmesh/options.h"
#include "dynmesh/slot_mesh.h"
#include "dynmesh/transfer.h"
#include "vtu_series.h"

namespace {

using dynmesh::Edit;
using dynmesh::EditBatch;
using dynmesh::Feature;
using dynmesh::FeatureId;
using dynmesh::MeshDiff;
using dynmesh::MeshOptions;
using dynmesh::Slot;
using dynmesh::SlotMesh;
using dynmesh::Transfer;
using dynmesh::client::DiffStream;
using dynmesh::client::DiffStreamOptions;
using dynmesh::client::EditParams;
using dynmesh::client::EditResult;
using dynmesh::client::MeshClient;

constexpr FeatureId kCrack = 10'000;  // ids of the crack's segments follow

// Values at vertices, by slot.
using Field = std::vector<double>;

[[noreturn]] void Fail(std::string_view why) {
  std::fprintf(stderr, "heat_crack: %s\n", std::string(why).c_str());
  std::exit(1);
}

void Check(const absl::Status& status) {
  if (!status.ok()) Fail(status.ToString());
}

template <class T>
T Value(absl::StatusOr<T> result) {
  Check(result.status());
  return *std::move(result);
}

// A mesh at the server, and its replica here. The destructor deletes the server's mesh; if the
// program fails, the mesh stays for inspection.
class RemoteMesh {
 public:
  // A new mesh with `edits` as its first revision.
  RemoteMesh(MeshClient& client, const MeshOptions& options, const EditBatch& edits)
      : client_(client), name_(Value(client.CreateMesh("", options)).id) {
    Send(edits);
    replica_ = Value(SlotMesh::FromMesh(Value(client_.GetSnapshot(name_))));
    DiffStreamOptions from_here;
    from_here.start_revision = replica_.revision();
    from_here.start_hash = replica_.hash();
    stream_ = client_.StreamDiffs(name_, from_here);
  }
  RemoteMesh(const RemoteMesh&) = delete;
  RemoteMesh& operator=(const RemoteMesh&) = delete;
  ~RemoteMesh() {
    stream_->Cancel();
    (void)client_.DeleteMesh(name_);
  }

  // Sends a batch and follows the mesh to the resulting revision. Then the replica's patch has all
  // changes since the last call, including those by other clients.
  void Apply(const EditBatch& edits) { Follow(Send(edits)); }

  const SlotMesh& replica() const { return replica_; }

  // True if the present mesh, here and at the server, equals the one made from scratch of its
  // features.
  bool IsThatOfItsFeatures(const MeshOptions& options) {
    const dynmesh::codec::FeaturesAt now = Value(client_.GetFeatures(name_));
    Follow(now.revision);
    const std::string other = Value(client_.CreateMesh("", options)).id;
    const EditResult built = Value(client_.AddFeatures(other, now.features, NoColumns()));
    Check(client_.DeleteMesh(other));
    return built.diff.hash == replica_.hash();
  }

 private:
  // The diff comes with the stream.
  static EditParams NoColumns() {
    EditParams params;
    params.omit_columns = true;
    return params;
  }

  // The revision made by `edits`. The request's id allows to send a batch again if its answer was
  // lost: the server applies it once. The stream reconnects by itself.
  std::uint64_t Send(const EditBatch& edits) {
    EditParams params = NoColumns();
    params.request_id = absl::StrCat("batch ", ++batches_);
    const absl::Time until = absl::Now() + absl::Seconds(30);
    for (;;) {
      const absl::StatusOr<EditResult> result = client_.Apply(name_, edits, params);
      if (!absl::IsUnavailable(result.status()) || absl::Now() > until) {
        return Value(result).diff.to_revision;
      }
      absl::SleepFor(absl::Milliseconds(100));
    }
  }

  // Joins several diffs to one patch: the first begins it, the others extend it.
  void Follow(std::uint64_t revision) {
    for (bool first = true; replica_.revision() < revision; first = false) {
      const auto event = Value(stream_->Next(absl::Minutes(1)));
      if (!event.has_value()) Fail("no diff came for a minute");
      // The stream was opened without snapshots in place of diffs.
      const MeshDiff& diff = std::get<MeshDiff>(*event);
      Check(first ? replica_.Apply(diff) : replica_.Extend(diff));
    }
  }

  MeshClient& client_;
  const std::string name_;
  int batches_ = 0;
  SlotMesh replica_;
  std::unique_ptr<DiffStream> stream_;
};

// The mass and stiffness matrices of each cell, by slot; 0 for free slots.
class Elements {
 public:
  explicit Elements(const SlotMesh& mesh) : elements_(mesh.regions().size()) {
    for (std::size_t cell = 0; cell < elements_.size(); ++cell) {
      if (mesh.cells()[3 * cell] != dynmesh::kNoSlot) elements_[cell] = Assemble(mesh, cell);
    }
  }

  // Reassembles the cells changed by the mesh's patch.
  void Follow(const SlotMesh& mesh) {
    elements_.resize(mesh.regions().size());
    for (const Slot cell : mesh.patch().removed_simplices) elements_[Index(cell)] = {};
    for (const Slot cell : mesh.patch().added_simplices) {
      elements_[Index(cell)] = Assemble(mesh, Index(cell));
    }
  }

  // (M + dt K) u, with mass M and stiffness K. Element by element, without a global matrix.
  Field Multiply(double dt, const Field& u) const {
    Field result(u.size());
    for (const Element& e : elements_) {
      const std::array<double, 3> at = {u[e.corners[0]], u[e.corners[1]], u[e.corners[2]]};
      const double sum = at[0] + at[1] + at[2];
      for (std::size_t i = 0; i < 3; ++i) {
        const auto& row = e.stiffness[i];
        result[e.corners[i]] +=
            e.area / 12 * (sum + at[i]) + dt * (row[0] * at[0] + row[1] * at[1] + row[2] * at[2]);
      }
    }
    return result;
  }

  // The diagonal of M + dt K, with `slots` entries.
  Field Diagonal(double dt, std::size_t slots) const {
    Field result(slots);
    for (const Element& e : elements_) {
      for (std::size_t i = 0; i < 3; ++i) {
        result[e.corners[i]] += e.area / 6 + dt * e.stiffness[i][i];
      }
    }
    return result;
  }

  double Integral(const Field& u) const {
    double sum = 0;
    for (const Element& e : elements_) {
      sum += e.area / 3 * (u[e.corners[0]] + u[e.corners[1]] + u[e.corners[2]]);
    }
    return sum;
  }

 private:
  struct Element {
    std::array<std::size_t, 3> corners = {0, 0, 0};
    double area = 0;
    std::array<std::array<double, 3>, 3> stiffness = {};
  };

  static std::size_t Index(Slot slot) { return static_cast<std::size_t>(slot); }

  static Element Assemble(const SlotMesh& mesh, std::size_t cell) {
    Element e;
    std::array<std::array<double, 2>, 3> at;
    for (std::size_t i = 0; i < 3; ++i) {
      e.corners[i] = Index(mesh.cells()[3 * cell + i]);
      at[i] = {mesh.points()[2 * e.corners[i]], mesh.points()[2 * e.corners[i] + 1]};
    }
    // The gradient of a hat function is the edge opposite to its corner, rotated, over twice the
    // area.
    std::array<std::array<double, 2>, 3> edge;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto &a = at[(i + 1) % 3], &b = at[(i + 2) % 3];
      edge[i] = {b[0] - a[0], b[1] - a[1]};
    }
    e.area = (edge[0][0] * edge[1][1] - edge[0][1] * edge[1][0]) / 2;
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) {
        const double product = edge[i][0] * edge[j][0] + edge[i][1] * edge[j][1];
        e.stiffness[i][j] = product / (4 * e.area);
      }
    }
    return e;
  }

  std::vector<Element> elements_;
};

double Dot(const Field& a, const Field& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

// One step of implicit Euler: (M + dt K) u = M u_old, by conjugate gradients with the diagonal as
// preconditioner. Where `fixed`, u stays 0.
void DiffuseFor(double dt, const Elements& elements, const std::vector<bool>& fixed, Field& u) {
  const std::size_t n = u.size();
  Field diagonal = elements.Diagonal(dt, n);
  const auto precondition = [&](const Field& r) {
    Field z(n);
    for (std::size_t i = 0; i < n; ++i) z[i] = fixed[i] ? 0 : r[i] / diagonal[i];
    return z;
  };
  const Field right = elements.Multiply(0, u);
  const Field left = elements.Multiply(dt, u);
  Field r(n);
  double norm = 0;
  for (std::size_t i = 0; i < n; ++i) {
    if (fixed[i]) continue;
    r[i] = right[i] - left[i];
    norm += right[i] * right[i];
  }
  Field z = precondition(r), p = z;
  double rz = Dot(r, z);
  for (int iteration = 0; Dot(r, r) > 1e-20 * norm; ++iteration) {
    if (iteration == 5000) Fail("the solver did not converge");
    const Field product = elements.Multiply(dt, p);
    const double alpha = rz / Dot(p, product);
    for (std::size_t i = 0; i < n; ++i) {
      if (fixed[i]) continue;
      u[i] += alpha * p[i];
      r[i] -= alpha * product[i];
    }
    z = precondition(r);
    const double before = std::exchange(rz, Dot(r, z));
    for (std::size_t i = 0; i < n; ++i) p[i] = z[i] + rz / before * p[i];
  }
}

// The slots with temperature 0: vertices on the crack, and free slots.
std::vector<bool> ColdSlots(const SlotMesh& mesh) {
  std::vector<bool> cold(mesh.ids().size());
  for (std::size_t i = 0; i < cold.size(); ++i) cold[i] = mesh.ids()[i] == 0;
  for (std::size_t i = 0; i < mesh.subsegment_owners().size(); ++i) {
    const Slot a = mesh.subsegments()[2 * i], b = mesh.subsegments()[2 * i + 1];
    const FeatureId owner = mesh.subsegment_owners()[i];
    if (a == dynmesh::kNoSlot || owner <= kCrack || owner == dynmesh::kBoxFeature) continue;
    cold[static_cast<std::size_t>(a)] = cold[static_cast<std::size_t>(b)] = true;
  }
  return cold;
}

struct Arguments {
  std::string server;
  double edge = 0.02;  // target length of edges
  int steps = 40;
  std::string out = "out/heat_crack_cc";
};

std::optional<Arguments> Parse(const std::vector<std::string>& words) {
  Arguments arguments;
  for (std::size_t i = 0; i < words.size(); i += 2) {
    if (i + 1 == words.size()) return std::nullopt;
    const std::string &flag = words[i], &value = words[i + 1];
    if (flag == "--server") {
      arguments.server = value;
    } else if (flag == "--out") {
      arguments.out = value;
    } else if (flag == "--edge") {
      if (!absl::SimpleAtod(value, &arguments.edge) || arguments.edge <= 0) return std::nullopt;
    } else if (flag == "--steps") {
      if (!absl::SimpleAtoi(value, &arguments.steps) || arguments.steps < 1) return std::nullopt;
    } else {
      return std::nullopt;
    }
  }
  if (arguments.server.empty()) return std::nullopt;
  return arguments;
}

struct Figures {
  double worst_loss = 0;  // largest relative loss of heat in an edit
  double milliseconds = 0;
  std::size_t changed = 0;  // number of vertices
};

void PrintAndCheck(const Arguments& arguments, const Figures& figures, const SlotMesh& mesh,
                   const Field& temperature, const std::string& series) {
  double least = INFINITY, most = -INFINITY;
  for (std::size_t i = 0; i < temperature.size(); ++i) {
    if (mesh.ids()[i] == 0) continue;
    least = std::min(least, temperature[i]), most = std::max(most, temperature[i]);
  }
  std::printf(
      "%zu vertices, %d steps of the crack: %.0f vertices changed a step, %.2f ms a step for edit, "
      "transfer and assembly\n",
      mesh.vertex_count(), arguments.steps, static_cast<double>(figures.changed) / arguments.steps,
      figures.milliseconds / arguments.steps);
  std::printf("heat kept by every edit to %.1e of it; temperatures %.3f to %.3f; series in %s\n",
              figures.worst_loss, least, most, series.c_str());
  if (figures.worst_loss >= 1e-12) Fail("an edit lost heat");
  if (least <= -0.05 || most >= 1.05) Fail("a temperature is out of bounds");
}

void Run(const Arguments& arguments) {
  MeshOptions options;
  options.box = {{0, 0}, {2, 1}};
  options.max_edge = arguments.edge;
  double x = 0.1, y = 0.5, direction = 0;  // the crack's tip
  const auto client = MeshClient::Connect(arguments.server);
  RemoteMesh mesh(*client, options, {Edit::Add(Feature::Point(1, x, y))});
  const SlotMesh& replica = mesh.replica();
  Elements elements(replica);
  Field temperature(replica.ids().size(), 1.0);
  examples::VtuSeries series(arguments.out, "heat_crack");
  const double step_length = 1.7 / arguments.steps, dt = 0.2 / arguments.steps;
  Figures figures;

  for (int step = 1; step <= arguments.steps; ++step) {
    // The crack turns a little as it grows.
    direction += 0.15 * std::sin(2.5 * step);
    x += step_length * std::cos(direction), y += step_length * std::sin(direction);
    const auto id = static_cast<FeatureId>(step);
    const double before = elements.Integral(temperature);
    const auto start = std::chrono::steady_clock::now();
    mesh.Apply({Edit::Add(Feature::Point(id + 1, x, y)),
                Edit::Add(Feature::Segment(kCrack + id, id, id + 1))});
    temperature.resize(replica.ids().size());
    Check(Value(Transfer::Make(replica)).Carry({.bounded = true}, temperature).status());
    elements.Follow(replica);
    const std::chrono::duration<double, std::milli> spent =
        std::chrono::steady_clock::now() - start;
    figures.milliseconds += spent.count();
    const double loss = std::abs(elements.Integral(temperature) - before) / before;
    figures.worst_loss = std::max(figures.worst_loss, loss);
    figures.changed +=
        replica.patch().added_vertices.size() + replica.patch().removed_vertices.size();

    const std::vector<bool> cold = ColdSlots(replica);
    for (std::size_t i = 0; i < cold.size(); ++i) {
      if (cold[i]) temperature[i] = 0;
    }
    DiffuseFor(dt, elements, cold, temperature);
    if (!series.Add(step * dt, replica, "temperature", temperature)) {
      Fail("cannot write " + series.path());
    }
  }

  PrintAndCheck(arguments, figures, replica, temperature, series.path());
  if (!mesh.IsThatOfItsFeatures(options)) Fail("the mesh is not that of its features");
  std::puts("good");
}

}  // namespace

int main(int count, char** words) {
  const auto arguments = Parse({words + 1, words + count});
  if (!arguments.has_value()) {
    std::fprintf(stderr,
                 "heat_crack --server HOST:PORT [--edge LENGTH] [--steps NUMBER] [--out FOLDER]\n");
    return 2;
  }
  Run(*arguments);
}
