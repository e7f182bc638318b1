#include "client/cli/trace_files.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/strings/str_format.h"
#include "client/cli/json.h"
#include "core/base/text.h"
#include "core/io/common/extension.h"
#include "core/io/common/file_writer.h"

namespace dynmesh::cli {
namespace {

using Fate = TraceOperation::Fate;
using What = TraceOutput::What;

std::string_view NameOf(Fate fate) {
  constexpr std::string_view kNames[] = {"kept", "rerun", "added", "removed"};
  return kNames[static_cast<std::size_t>(fate)];
}
std::string_view ColorOf(Fate fate) {
  constexpr std::string_view kColors[] = {"#eeeeee", "#ffc266", "#a6d9a0", "#f2a6a6"};
  return kColors[static_cast<std::size_t>(fate)];
}
std::string_view NameOf(What what) {
  constexpr std::string_view kNames[] = {"vertex", "subsegment", "exposure", "death"};
  return kNames[static_cast<std::size_t>(what)];
}

std::string TextOfTime(const TraceOperation& operation) {
  return text::Concat("bucket ", operation.bucket, ", round ", operation.round, ", ",
                      operation.step ? text::Concat("step ", *operation.step) : "quality work");
}

// --- Graphviz ---------------------------------------------------------------------------------

class DotText {
 public:
  explicit DotText(const Trace& trace) : trace_(trace) {
    FindMakers();
    FindDrawn();
  }

  std::string Write() {
    Add("digraph trace {\n  rankdir=LR;\n  newrank=true;\n  splines=line;\n  nodesep=0.12;\n  "
        "ranksep=0.4;\n  fontname=\"sans-serif\";\n  label=\"",
        trace_.Count(Fate::kKept), " operations kept (grey), ", trace_.Count(Fate::kRerun),
        " ran again (orange), ", trace_.Count(Fate::kAdded), " added (green), ",
        trace_.Count(Fate::kRemoved), " removed (red)\";\n",
        "  node [shape=box, style=filled, fontname=\"sans-serif\", fontsize=10];\n",
        "  edge [color=\"#888888\", arrowsize=0.6];\n",
        "  input [shape=ellipse, fillcolor=white];\n");
    AddNodes();
    AddRequests();
    AddReads();
    AddCauses();
    Add("}\n");
    return text_;
  }

 private:
  template <class... Parts>
  void Add(const Parts&... parts) {
    (text::Append(text_, parts), ...);
  }
  const std::vector<TraceOperation>& operations() const { return trace_.operations; }

  std::string PositionOf(std::uint32_t vertex) const {
    const auto& p = trace_.vertices[vertex].position;
    return trace_.dimension == 2 ? absl::StrFormat("(%.4g, %.4g)", p[0], p[1])
                                 : absl::StrFormat("(%.4g, %.4g, %.4g)", p[0], p[1], p[2]);
  }

  // The operation that made each vertex. A vertex of the input has none.
  void FindMakers() {
    for (std::size_t i = 0; i < operations().size(); ++i) {
      for (const auto* made : {&operations()[i].made, &operations()[i].made_before}) {
        for (const TraceOutput& output : *made) {
          if (output.what == What::kVertex) maker_.try_emplace(output.ends[0], i);
        }
      }
    }
  }
  // Calls f(operation that made a vertex, operation that reads it).
  template <class F>
  void ForEachRead(F f) const {
    for (std::size_t i = 0; i < operations().size(); ++i) {
      for (const std::uint32_t v : operations()[i].reads) {
        const auto made = maker_.find(v);
        if (made != maker_.end() && made->second != i) f(made->second, i);
      }
    }
  }

  // Most operations of a trace have nothing to do with a batch. Of those that were kept, only those
  // are drawn that made what others read. If all were kept, all are.
  void FindDrawn() {
    is_drawn_.assign(operations().size(), trace_.Count(Fate::kKept) == operations().size());
    for (std::size_t i = 0; i < operations().size(); ++i) {
      if (operations()[i].fate != Fate::kKept) is_drawn_[i] = true;
    }
    ForEachRead([this](std::size_t made, std::size_t reads) {
      if (operations()[reads].fate != Fate::kKept) is_drawn_[made] = true;
    });
  }

  // One box for each epoch, from left to right.
  void AddNodes() {
    std::size_t boxes = 0;
    std::string last_drawn;
    for (std::size_t begin = 0, end = 0; begin < operations().size(); begin = end) {
      const std::string time = TextOfTime(operations()[begin]);
      std::vector<std::size_t> drawn;
      for (; end < operations().size() && TextOfTime(operations()[end]) == time; ++end) {
        if (is_drawn_[end]) drawn.push_back(end);
      }
      if (drawn.empty()) continue;
      Add("  subgraph cluster_", boxes++, " {\n    rank=same;\n    label=\"", time);
      const std::size_t left_out = end - begin - drawn.size();
      if (left_out > 0) Add("\\nand ", left_out, " kept");
      Add("\";\n");
      for (const std::size_t i : drawn) AddNode(i);
      Add("  }\n");
      const std::string first = text::Concat("o", drawn.front());
      if (!last_drawn.empty()) Add("  ", last_drawn, " -> ", first, " [style=invis];\n");
      last_drawn = first;
    }
  }
  void AddNode(std::size_t i) {
    const TraceOperation& operation = operations()[i];
    Add("    o", i, " [fillcolor=\"", ColorOf(operation.fate), "\", label=\"", operation.procedure);
    for (const std::uint32_t v : operation.item) Add(" ", PositionOf(v));
    for (const TraceOutput& output : operation.made) {
      Add("\\n", VerbOf(output.what), " ", PositionOf(output.ends[0]));
      if (output.what != What::kVertex) Add(" ", PositionOf(output.ends[1]));
    }
    Add("\"];\n");
  }
  static std::string_view VerbOf(What what) {
    if (what == What::kExposure) return "exposes";
    return what == What::kDeath ? "splits" : "makes";
  }

  void AddRequests() {
    for (std::size_t i = 0; i < operations().size(); ++i) {
      if (!is_drawn_[i]) continue;
      for (const std::uint32_t r : operations()[i].requests) {
        if (is_drawn_[r]) Add("  o", i, " -> o", r, ";\n");
      }
    }
  }
  void AddReads() {
    ForEachRead([&](std::size_t made, std::size_t reads) {
      if (!is_drawn_[made] || !is_drawn_[reads]) return;
      Add("  o", made, " -> o", reads, " [style=dotted, constraint=false];\n");
    });
  }
  void AddCauses() {
    for (std::size_t i = 0; i < operations().size(); ++i) {
      const TraceOperation& operation = operations()[i];
      if (operation.fate != Fate::kRerun) continue;
      const std::string from = operation.because ? text::Concat("o", *operation.because) : "input";
      Add("  ", from, " -> o", i, " [color=\"#cc5500\", penwidth=2.5];\n");
    }
  }

  const Trace& trace_;
  absl::flat_hash_map<std::uint32_t, std::size_t> maker_;  // by vertex
  std::vector<bool> is_drawn_;
  std::string text_;
};

// --- JSON ---------------------------------------------------------------------------------------

std::vector<std::uint64_t> Wide(const std::vector<std::uint32_t>& values) {
  return {values.begin(), values.end()};
}

std::vector<double> Coordinates(const std::array<double, 3>& position, int dimension) {
  return {position.begin(), position.begin() + dimension};
}

std::vector<JsonObject> OutputsAsJson(const std::vector<TraceOutput>& made) {
  std::vector<JsonObject> objects;
  for (const TraceOutput& output : made) {
    JsonObject object;
    object.AddText("what", NameOf(output.what));
    if (output.what == What::kVertex) {
      object.AddCounts("vertices", {output.ends[0]});
    } else {
      object.AddCounts("vertices", {output.ends[0], output.ends[1]});
    }
    objects.push_back(std::move(object));
  }
  return objects;
}

JsonObject AsJson(const TraceOperation& operation) {
  JsonObject object;
  object.AddText("procedure", operation.procedure)
      .Add("bucket", operation.bucket)
      .Add("round", operation.round);
  if (operation.step) object.Add("step", *operation.step);
  object.AddCounts("item", Wide(operation.item)).AddObjects("made", OutputsAsJson(operation.made));
  if (operation.fate == Fate::kRerun) {
    object.AddObjects("made_before", OutputsAsJson(operation.made_before));
  }
  object.AddCounts("reads", Wide(operation.reads))
      .AddCounts("cells", Wide(operation.cells))
      .AddCounts("requests", Wide(operation.requests))
      .AddText("fate", NameOf(operation.fate));
  if (operation.fate == Fate::kRerun) {
    if (operation.because) {
      object.Add("because", *operation.because);
    } else {
      object.Add("because_of_input", true);
    }
  }
  return object;
}

// One object a line.
template <class Values, class ToJson>
void AddList(std::string_view key, const Values& values, ToJson to_json, std::string& text) {
  text += text::Concat(",\n\"", key, "\": [");
  std::string_view separator = "\n";
  for (const auto& value : values) {
    text += separator;
    text += to_json(value).ToString();
    separator = ",\n";
  }
  text += "]";
}

}  // namespace

std::string TraceAsDot(const Trace& trace) { return DotText(trace).Write(); }

std::string TraceAsJson(const Trace& trace) {
  std::string text = text::Concat("{\"dimension\": ", trace.dimension);
  AddList(
      "vertices", trace.vertices,
      [&](const TraceVertex& vertex) {
        return JsonObject()
            .AddText("id", text::Concat(vertex.id))
            .AddNumbers("position", Coordinates(vertex.position, trace.dimension))
            .Add("input", vertex.is_input);
      },
      text);
  AddList(
      "cells", trace.cells,
      [&](const TraceCell& cell) {
        return JsonObject()
            .AddNumbers("centre", Coordinates(cell.centre, trace.dimension))
            .Add("side", cell.side);
      },
      text);
  AddList("operations", trace.operations, AsJson, text);
  return text + "}\n";
}

absl::Status CheckTracePath(const std::string& path) {
  const std::string extension = io::ExtensionOf(path);
  if (extension == ".dot" || extension == ".json") return absl::OkStatus();
  return absl::InvalidArgumentError(
      text::Concat("--trace: ", path, ": the extension must be .dot or .json"));
}

absl::Status WriteTrace(const Trace& trace, const std::string& path) {
  io::FileWriter out(path);
  out << (io::ExtensionOf(path) == ".dot" ? TraceAsDot(trace) : TraceAsJson(trace));
  return out.Close();
}

}  // namespace dynmesh::cli
