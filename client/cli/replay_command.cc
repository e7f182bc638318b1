// dynmesh replay SCRIPT [--check N] [-o OUT]: runs an edit script in process, one revision per
// batch. --check compares the mesh and its trace with a run from scratch.
#include <sys/resource.h>

#include <chrono>
#include <memory>
#include <vector>

#include "absl/strings/str_format.h"
#include "client/cli/check_revision.h"
#include "client/cli/command.h"
#include "client/cli/input.h"
#include "client/cli/json.h"
#include "client/cli/memory_flag.h"
#include "client/cli/mesh_flags.h"
#include "client/cli/output.h"
#include "client/cli/percentile.h"
#include "client/cli/progress_bar.h"
#include "client/cli/selection.h"
#include "client/cli/trace_files.h"
#include "client/cli/words.h"
#include "core/base/text.h"
#include "core/io/pictures/mesh_animation.h"
#include "core/io/script/edit_script.h"
#include "dynmesh/dynamic_mesh.h"
#include "dynmesh/error.h"
#include "dynmesh/slot_mesh.h"
#include "dynmesh/trace.h"

namespace dynmesh::cli {
namespace {

using Clock = std::chrono::steady_clock;

struct ReplayCommand {
  std::string script;
  std::uint64_t check = 0;  // interval in revisions; 0: never
  MeshFlags mesh;
  OutputFlags output;
  SelectionFlags selection;
  std::string markers;
  std::string max_memory;
  bool json = false;
  bool highlight = false;
  std::string animation;           // a path; empty: none
  std::uint64_t animate_from = 1;  // the revision of the first frame
  double frame_seconds = 0.2;
  std::string trace;  // a path; empty: none
  std::uint64_t trace_limit = TraceOptions().max_operations;
};

std::uint64_t PeakResidentBytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;  // Linux counts in kilobytes
}

class Replay {
 public:
  Replay(const ReplayCommand& command, const io::EditScript& script, const MemoryBudget& memory)
      : command_(command), script_(script), memory_(memory) {}

  absl::Status Run() {
    MeshOptions options = script_.Options();
    input_.options = options;
    input_.where = [this](FeatureId id) { return WhereLast(id); };
    absl::StatusOr<Selection> selection = Selection::Parse(command_.selection, input_, false);
    if (!selection.ok()) return selection.status();
    selection_ = *std::move(selection);
    labels_.features = std::make_shared<const io::FeatureLabels>(script_.labels);
    if (auto s = ParseMarkersFlag(command_.markers, labels_); !s.ok()) return s;
    if (auto status = ApplyMeshFlags(command_.mesh, options); !status.ok()) return status;
    if (auto s = CheckOutputsOf(options, command_.output); !s.ok()) return s;
    if (auto s = CheckAnimation(options); !s.ok()) return s;
    if (auto s = CheckTrace(options); !s.ok()) return s;
    absl::StatusOr<std::unique_ptr<DynamicMesh>> mesh = DynamicMesh::Create(options);
    if (!mesh.ok()) {
      return NameOption(mesh.status(), command_.mesh,
                        [this](std::string_view option) { return script_.WhereOption(option); });
    }
    mesh_ = *std::move(mesh);
    const MeshStats start = mesh_->Stats();
    if (!command_.animation.empty()) {
      MeshDiff first;  // the mesh of no features
      const Mesh empty = mesh_->Snapshot();
      first.added_vertices = empty.vertices;
      first.added_simplices = empty.simplices;
      animation_.Add(first);
    }
    vertices_ = start.vertices;
    simplices_ = start.simplices;
    if (command_.check != 0) {
      absl::StatusOr<SlotMesh> replica = SlotMesh::FromMesh(mesh_->Snapshot());
      if (!replica.ok()) return replica.status();
      replica_ = std::make_unique<SlotMesh>(*std::move(replica));
    }
    for (std::size_t b = 0; b < script_.batches.size(); ++b) {
      if (auto status = ApplyBatch(b); !status.ok()) return status;
    }
    return Finish(options);
  }

 private:
  absl::Status CheckAnimation(const MeshOptions& options) const {
    if (command_.animation.empty()) return absl::OkStatus();
    if (options.dimension != 2 || options.kind != MeshKind::kDelaunay) {
      return absl::InvalidArgumentError("--animation is for Delaunay meshes of 2D");
    }
    if (!command_.animation.ends_with(".svg")) {
      return absl::InvalidArgumentError(
          text::Concat("--animation: ", command_.animation, ": the extension must be .svg"));
    }
    if (command_.animate_from <= script_.batches.size()) return absl::OkStatus();
    return absl::InvalidArgumentError(
        text::Concat("--animate-from: the script has ", script_.batches.size(), " revisions"));
  }

  absl::Status CheckTrace(const MeshOptions& options) const {
    if (command_.trace.empty()) return absl::OkStatus();
    if (options.kind != MeshKind::kDelaunay) {
      return absl::InvalidArgumentError("--trace is for meshes of kind delaunay: others have no trace");
    }
    return CheckTracePath(command_.trace);
  }

  absl::Status ApplyBatch(std::size_t b) {
    const EditBatch& batch = script_.batches[b].edits;
    if (!command_.trace.empty() && b + 1 == script_.batches.size()) {
      features_before_last_ = mesh_->Features();
    }
    const Clock::time_point start = Clock::now();
    ApplyOptions options;
    options.progress = [&](const ApplyProgress& p) {
      bar_.Show(
          p.done, p.total,
          text::Concat("revision ", b + 1, " of ", script_.batches.size(), ", ", WordOf(p.stage)));
    };
    options.interrupted = [this] { return memory_.IsExceeded(); };
    absl::StatusOr<MeshDiff> diff =
        WithinMemory(memory_, kMemoryAdvice, [&] { return mesh_->Apply(batch, options); });
    const std::chrono::duration<double, std::micro> elapsed = Clock::now() - start;
    if (!diff.ok()) return bar_.End(), AtLine(b, diff.status());
    Count(batch, *diff);
    if (b > 0) microseconds_.push_back(elapsed.count());
    // The last revision is always checked.
    const bool checked = command_.check != 0 && (diff->to_revision % command_.check == 0 ||
                                                 b + 1 == script_.batches.size());
    if (auto status = Check(*diff, checked); !status.ok()) {
      return absl::Status(status.code(),
                          text::Concat(script_.Where(b, std::nullopt), ": revision ",
                                       diff->to_revision, ": ", text::View(status.message())));
    }
    if (b + 1 == script_.batches.size()) bar_.End();
    if (!command_.animation.empty()) {
      animation_.Add(*diff);
      if (b + 1 >= command_.animate_from) animation_.Begin();
    }
    last_added_ = std::move(diff->added_simplices);
    diff->added_simplices = {};
    return PrintRevision(*diff, elapsed.count(), checked);
  }

  // The error of a batch, at the line of the edit to blame.
  absl::Status AtLine(std::size_t b, const absl::Status& status) const {
    const std::optional<ErrorDetail> detail = GetErrorDetail(status);
    std::optional<std::size_t> edit;
    if (detail) edit = detail->edit ? detail->edit : LastEditOf(b, *detail);
    return absl::Status(status.code(),
                        text::Concat(script_.Where(b, edit), ": ", text::View(status.message())));
  }

  // The batch's last edit of the first feature to blame that occurs in it.
  std::optional<std::size_t> LastEditOf(std::size_t b, const ErrorDetail& detail) const {
    const EditBatch& batch = script_.batches[b].edits;
    for (const FeatureId id : detail.features) {
      for (std::size_t e = batch.size(); e-- > 0;) {
        if (batch[e].feature.id == id) return e;
      }
    }
    return std::nullopt;
  }

  // The line of the last edit of a feature.
  std::string WhereLast(FeatureId id) const {
    ErrorDetail detail;
    detail.features = {id};
    for (std::size_t b = script_.batches.size(); b-- > 0;) {
      if (const auto edit = LastEditOf(b, detail)) return script_.Where(b, edit);
    }
    return "";
  }

  void Count(const EditBatch& batch, const MeshDiff& diff) {
    for (const Edit& edit : batch) {
      if (edit.action == Edit::Action::kAdd) ++features_;
      if (edit.action == Edit::Action::kRemove) --features_;
    }
    edits_ += batch.size();
    added_simplices_ = diff.added_simplex_count();
    vertices_ += diff.added_vertices.size() - diff.removed_vertices.size();
    simplices_ += diff.added_simplex_count() - diff.removed_simplex_count();
  }

  absl::Status Check(const MeshDiff& diff, bool now) {
    if (replica_ == nullptr) return absl::OkStatus();
    if (auto status = replica_->Apply(diff); !status.ok()) {
      return absl::InternalError(
          text::Concat("a replica refuses the diff: ", text::View(status.message())));
    }
    return now ? CheckRevision(*mesh_, *replica_) : absl::OkStatus();
  }

  absl::Status PrintRevision(const MeshDiff& diff, double microseconds, bool checked) const {
    std::string line;
    if (command_.json) {
      JsonObject object;
      object.Add("revision", diff.to_revision)
          .Add("features", features_)
          .Add("vertices", vertices_)
          .Add("simplices", simplices_)
          .Add("added_vertices", diff.added_vertices.size())
          .Add("removed_vertices", diff.removed_vertices.size())
          .Add("added_simplices", added_simplices_)
          .Add("removed_simplices", diff.removed_simplex_count())
          .Add("operations", diff.work.executed)
          .Add("created", diff.work.created)
          .Add("dropped", diff.work.dropped)
          .Add("notified", diff.work.notified)
          .Add("visited_cells", diff.work.visited_cells)
          .Add("visited_nodes", diff.work.visited_nodes)
          .Add("microseconds", microseconds)
          .AddText("hash", diff.hash.ToHex());
      if (command_.check != 0) object.Add("checked", checked);
      line = object.ToLine();
    } else {
      line = absl::StrFormat(
          "revision %d: %d features, %d vertices (+%d -%d), %d %s (+%d -%d), "
          "%d operations, %.0f us%s\n",
          diff.to_revision, features_, vertices_, diff.added_vertices.size(),
          diff.removed_vertices.size(), simplices_, SimplicesWord(diff.dimension), added_simplices_,
          diff.removed_simplex_count(), diff.work.executed, microseconds,
          checked ? ", checked" : "");
    }
    if (PrintOut(line)) return absl::OkStatus();
    return absl::UnavailableError("cannot write to standard output");
  }

  absl::Status Finish(const MeshOptions& options) {
    const MeshStats stats = mesh_->Stats();
    const double p50 = Percentile(microseconds_, 0.50);
    const double p99 = Percentile(microseconds_, 0.99);
    std::string line;
    if (command_.json) {
      line = JsonObject()
                 .Add("summary", true)
                 .Add("revisions", script_.batches.size())
                 .Add("edits", edits_)
                 .Add("p50_microseconds", p50)
                 .Add("p99_microseconds", p99)
                 .Add("trace_bytes", stats.trace_bytes)
                 .Add("peak_rss_bytes", PeakResidentBytes())
                 .ToLine();
    } else {
      const std::string times =
          microseconds_.empty()
              ? ""
              : absl::StrFormat(
                    "; after the first: %.0f us typical, %.0f us at the 99th percentile", p50, p99);
      line = absl::StrFormat(
          "%d revisions, %d edits%s; trace %.1f MB, peak memory %.1f MB\nhash %s\n",
          script_.batches.size(), edits_, times, static_cast<double>(stats.trace_bytes) / 1e6,
          static_cast<double>(PeakResidentBytes()) / 1e6, mesh_->hash().ToHex());
    }
    if (!PrintOut(line)) return absl::UnavailableError("cannot write to standard output");
    if (!command_.animation.empty()) {
      const absl::StatusOr<io::SvgOptions> svg = PictureOptions(command_.output, options);
      if (!svg.ok()) return svg.status();
      const io::AnimationOptions animation = {svg->crop.value_or(animation_.Extent()), svg->width,
                                              command_.frame_seconds};
      if (auto s = animation_.Write(animation, command_.animation); !s.ok()) return s;
    }
    if (!command_.trace.empty()) {
      if (auto s = TakeTrace(options); !s.ok()) return s;
    }
    if (command_.output.paths.empty()) return absl::OkStatus();
    Mesh mesh = mesh_->Snapshot();
    labels_.is_part = !selection_.IsEverything();
    if (labels_.is_part) {
      absl::StatusOr<Mesh> part = selection_.Of(mesh);
      if (part.ok() && selection_.IsOpened()) part = selection_.OpenedOf(mesh);
      if (!part.ok()) return part.status();
      mesh = *std::move(part);
    }
    return WriteOutputs(mesh, options, command_.output, labels_,
                        command_.highlight ? last_added_ : SimplexColumn());
  }

  absl::Status TakeTrace(const MeshOptions& options) {
    TraceOptions trace_options;
    trace_options.max_operations = command_.trace_limit;
    trace_options.interrupted = [this] { return memory_.IsExceeded(); };
    const EditBatch last = script_.batches.empty() ? EditBatch() : script_.batches.back().edits;
    const absl::StatusOr<Trace> trace = WithinMemory(memory_, kMemoryAdvice, [&] {
      return TraceOf(features_before_last_, last, options, trace_options);
    });
    if (!trace.ok()) {
      const std::optional<ErrorDetail> detail = GetErrorDetail(trace.status());
      const bool is_large = detail && detail->reason == reason::kWorkLimit;
      return absl::Status(trace.status().code(),
                          text::Concat("--trace: ", text::View(trace.status().message()),
                                       is_large ? " with --trace-limit" : ""));
    }
    return WriteTrace(*trace, command_.trace);
  }

  const ReplayCommand& command_;
  const io::EditScript& script_;
  MemoryBudget memory_;
  std::unique_ptr<DynamicMesh> mesh_;
  std::unique_ptr<SlotMesh> replica_;  // with --check
  std::vector<double> microseconds_;   // of all revisions but the first
  std::uint64_t features_ = 0;
  std::uint64_t vertices_ = 0;
  std::uint64_t simplices_ = 0;
  std::uint64_t added_simplices_ = 0;
  std::uint64_t edits_ = 0;
  Input input_;  // what is known of the script, for `selection_`
  MeshLabels labels_;
  Selection selection_;  // the part of the last mesh to write
  SimplexColumn last_added_;
  io::MeshAnimation animation_;                // with --animation
  std::vector<Feature> features_before_last_;  // with --trace: of the last revision but one
  // If results go to the same terminal, their lines show the progress.
  ProgressBar bar_{ErrorIsTerminal() && !OutIsTerminal()};
};

int Run(ReplayCommand command) {
  if (command.output.fill == "change") {
    command.highlight = true;
    command.output.fill.clear();
  }
  if (auto status = CheckOutputs(command.output); !status.ok()) return ReportError(status);
  const absl::StatusOr<io::EditScript> script = io::ReadEditScript(command.script);
  if (!script.ok()) return ReportError(script.status());
  const absl::StatusOr<MemoryBudget> memory = ParseMemory(command.max_memory);
  if (!memory.ok()) return ReportError(memory.status());
  const absl::Status status = Replay(command, *script, *memory).Run();
  return status.ok() ? kExitDone : ReportError(status);
}

}  // namespace

void RegisterReplayCommand(CLI::App& app, CommandSlot& slot) {
  auto command = std::make_shared<ReplayCommand>();
  CLI::App* const sub = AddCommand(app, slot, "replay", "Apply an edit script in process",
                                   [command] { return Run(*command); });
  sub->add_option("SCRIPT", command->script, "The edit script")->required();
  sub->add_option("--check", command->check,
                  "Every N revisions and at the end: compare mesh and trace with a "
                  "from-scratch run, audit both")
      ->type_name("N")
      ->check(CLI::PositiveNumber);
  AddMeshFlags(*sub, command->mesh);
  AddMemoryFlag(*sub, command->max_memory);
  AddOutputFlags(*sub, command->output);
  AddSelectionFlags(*sub, command->selection);
  AddMarkersFlag(*sub, command->markers);
  sub->add_flag("--highlight", command->highlight,
                "In pictures: show what the last revision added; without --fill the same as "
                "--fill change");
  sub->add_option("--animation", command->animation,
                  "Of a 2D mesh: write an animated picture, a frame for each revision, with what "
                  "the revision added in orange; --crop and --width are obeyed")
      ->type_name("FILE.svg");
  sub->add_option("--animate-from", command->animate_from,
                  "The revision of the first frame (default: 1)")
      ->type_name("N")
      ->check(CLI::PositiveNumber);
  sub->add_option("--frame-seconds", command->frame_seconds,
                  "How long a frame of the animation shows (default: 0.2)")
      ->type_name("S")
      ->check(CLI::Range(0.01, 60.0));
  sub->add_option("--trace", command->trace,
                  "Write the operations of the last mesh, and what the last revision did to "
                  "them: .dot is a graph for Graphviz, .json is for programs")
      ->type_name("FILE");
  sub->add_option("--trace-limit", command->trace_limit,
                  "The most operations of a trace that is written (default: 10000)")
      ->type_name("N")
      ->check(CLI::PositiveNumber);
  sub->add_flag("--json", command->json, "Print one JSON object a revision, then a summary");
}

}  // namespace dynmesh::cli
