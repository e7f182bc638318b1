// dynmesh lfs INPUT|MESH X,Y[,Z] ...: the local feature size at positions: of an input file, in
// process, or its bounds by the leaves of a server's quadtree.
#include <memory>
#include <string>
#include <vector>

#include "absl/strings/str_format.h"
#include "client/cli/file_stats.h"
#include "client/cli/input.h"
#include "client/cli/json.h"
#include "client/cli/remote/connection.h"
#include "client/cli/remote/remote_commands.h"
#include "core/base/text.h"
#include "core/io/common/text_reader.h"
#include "dynmesh/quadtree.h"
#include "dynmesh/quality.h"

namespace dynmesh::cli {
namespace {

struct LfsCommand {
  std::string of;  // a mesh's id or a file
  std::vector<std::string> positions;
  ServerFlags server;
};

absl::StatusOr<std::vector<double>> ParsePositions(const std::vector<std::string>& texts,
                                                   int dimension) {
  std::vector<double> coordinates;
  for (const std::string& text : texts) {
    const std::vector<std::string_view> parts = text::Split(text, ',');
    bool good = parts.size() == static_cast<std::size_t>(dimension);
    for (const std::string_view part : parts) {
      good = good && io::ParseDouble(part, &coordinates.emplace_back());
    }
    if (!good) {
      return absl::InvalidArgumentError(absl::StrFormat("a position is %s (no blanks), found %s",
                                                        dimension == 2 ? "X,Y" : "X,Y,Z",
                                                        text::Quoted(text)));
    }
  }
  return coordinates;
}

int OfInput(const LfsCommand& command) {
  const absl::StatusOr<Input> input = LoadInput(command.of);
  if (!input.ok()) return ReportServerError(input.status());
  const auto positions = ParsePositions(command.positions, input->options.dimension);
  if (!positions.ok()) return ReportServerError(positions.status());
  const std::vector<double> sizes =
      LocalFeatureSizes(input->features, input->options.dimension, *positions);
  if (command.server.json) return Print(JsonObject().AddNumbers("lfs", sizes).ToLine());
  std::string text;
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    absl::StrAppendFormat(&text, "%s  %.9g\n", command.positions[i], sizes[i]);
  }
  return Print(text);
}

int OfQuadtree(const LfsCommand& command) {
  const auto client = Connect(command.server);
  if (!client.ok()) return ReportServerError(client.status());
  const auto info = (*client)->GetMesh(command.of);
  if (!info.ok()) return ReportServerError(info.status());
  if (info->options.kind != MeshKind::kQuadtree) {
    return ReportServerError(absl::FailedPreconditionError(
        absl::StrFormat("mesh %s is no quadtree, and the leaves of a quadtree tell the local "
                        "feature size; create one, or give an input file",
                        command.of)));
  }
  const int dimension = info->options.dimension;
  const auto positions = ParsePositions(command.positions, dimension);
  if (!positions.ok()) return ReportServerError(positions.status());
  const auto located = (*client)->Locate(command.of, dimension, *positions);
  if (!located.ok()) return ReportServerError(located.status());
  std::vector<double> least, greatest;
  std::string text;
  for (std::size_t i = 0; i < located->leaf_sides.size(); ++i) {
    QuadtreeCell leaf;
    leaf.side = located->leaf_sides[i];
    const FeatureSizeBounds bounds = FeatureSizeIn(leaf, dimension);
    least.push_back(bounds.least);
    greatest.push_back(bounds.greatest);
    if (leaf.side > 0) {
      absl::StrAppendFormat(&text, "%s  %.9g to %.9g\n", command.positions[i], bounds.least,
                            bounds.greatest);
    } else {
      absl::StrAppendFormat(&text, "%s  outside the quadtree\n", command.positions[i]);
    }
  }
  if (!command.server.json) return Print(text);
  return Print(JsonObject()
                   .Add("revision", located->revision)
                   .AddNumbers("side", located->leaf_sides)
                   .AddNumbers("least", least)
                   .AddNumbers("greatest", greatest)
                   .ToLine());
}

}  // namespace

void RegisterLfsCommand(CLI::App& app, CommandSlot& slot) {
  auto command = std::make_shared<LfsCommand>();
  CLI::App* const sub = AddCommand(
      app, slot, "lfs",
      "The local feature size at positions: the radius of the least ball that meets two disjoint "
      "features",
      [command] { return IsMeshFile(command->of) ? OfInput(*command) : OfQuadtree(*command); });
  sub->add_option("WHAT", command->of,
                  "An input file, which needs no server: " + io::GeometryFormats() +
                      "; or the id of a quadtree, whose leaves bound it from both sides")
      ->required();
  sub->add_option("POSITION", command->positions, "X,Y or X,Y,Z; any number of them")->required();
  AddServerFlags(*sub, command->server);
}

}  // namespace dynmesh::cli
