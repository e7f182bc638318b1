#include "client/cli/file_stats.h"

#include "absl/strings/str_format.h"
#include "client/cli/command.h"
#include "client/cli/input.h"
#include "client/cli/mesh_flags.h"
#include "client/cli/mesh_statistics.h"
#include "client/cli/quadtree_text.h"
#include "client/cli/size_conformity.h"
#include "client/cli/words.h"
#include "client/verify/verify_quadtree.h"
#include "core/base/text.h"
#include "core/io/common/extension.h"
#include "core/io/formats/mesh_input.h"

namespace dynmesh::cli {
namespace {

absl::Status CheckFlags(const FileStatsFlags& flags) {
  if (auto status = CheckRhoFlag(flags.rho); !status.ok()) return status;
  if (auto status = CheckMinDihedralFlag(flags.min_dihedral); !status.ok()) return status;
  if (!flags.svg.empty() && io::ExtensionOf(flags.svg) != ".svg") {
    return absl::InvalidArgumentError(text::Concat("--svg ", flags.svg, ": must end in .svg"));
  }
  return absl::OkStatus();
}

}  // namespace

void AddFileStatsFlags(CLI::App& command, FileStatsFlags& flags) {
  command
      .add_option("--svg", flags.svg,
                  "Of a file: draw histograms of its angles, in 3D the dihedral ones")
      ->type_name("OUT.svg");
  command.add_flag("--histogram", flags.histogram,
                   "Of a file: print how many angles there are of each degree");
  command.add_flag("--log", flags.log_scale, "Bars of the histograms by logarithm");
  command
      .add_option("--width", flags.width,
                  "Width of the histograms in pixels, 200 to 100000 (default: 1000)")
      ->type_name("PX")
      ->check(CLI::Range(200.0, 1e5));
  command
      .add_option(
          "--rho", flags.rho,
          "Of a file: the quality it is judged by (default: what the file says, else sqrt 2, in 3D "
          "2)")
      ->type_name("R");
  command
      .add_option("--min-dihedral", flags.min_dihedral,
                  "Of a 3D file: count the tetrahedra with a dihedral angle below this, 0 to "
                  "20 degrees (default: what the file says, else 0, none)")
      ->type_name("DEGREES");
  command
      .add_option("--lfs", flags.lfs,
                  "Of a file, with what it was made of: how the distance of each vertex to its "
                  "nearest neighbour follows the local feature size")
      ->type_name("INPUT");
}

bool IsMeshFile(const std::string& name) { return name.find_first_of("./") != std::string::npos; }

namespace {

// The leaves of a quadtree.
int RunLeafStats(const std::string& path, const FileStatsFlags& flags, bool json) {
  for (const auto& [flag, is_given] : {std::pair("--svg", !flags.svg.empty()),
                                       {"--rho", flags.rho.has_value()},
                                       {"--min-dihedral", flags.min_dihedral.has_value()}}) {
    if (is_given) {
      return ReportError(absl::InvalidArgumentError(absl::StrFormat(
          "%s: %s has the leaves of a quadtree, and simplices have that", flag, path)));
    }
  }
  const absl::StatusOr<io::LeafList> list = io::ReadLeaves(path);
  if (!list.ok()) return ReportError(list.status());
  std::vector<Feature> features;
  if (!flags.lfs.empty()) {
    absl::StatusOr<Input> input = LoadInputOfMesh("--lfs", flags.lfs, list->dimension);
    if (!input.ok()) return ReportError(input.status());
    features = std::move(input->features);
  }
  const QuadtreeReport report = VerifyQuadtree(*list, flags.lfs.empty() ? nullptr : &features);
  JsonObject object;
  return PrintOut(json ? QuadtreeJson(report, object).ToLine() : QuadtreeText(report))
             ? kExitDone
             : kExitFailed;
}

}  // namespace

int RunFileStats(const std::string& path, const FileStatsFlags& flags, bool json) {
  if (io::IsLeafFile(path)) return RunLeafStats(path, flags, json);
  if (auto status = CheckFlags(flags); !status.ok()) return ReportError(status);
  const absl::StatusOr<io::MeshFiles> files = io::ReadAnyMesh(path);
  if (!files.ok()) return ReportError(files.status());
  const int dimension = files->mesh.dimension;
  if (auto status = CheckMinDihedralFlag(flags.min_dihedral, path, dimension); !status.ok()) {
    return ReportError(status);
  }
  MeshStatistics statistics = ComputeStatistics(
      files->mesh, flags.rho.value_or(files->rho.value_or(DefaultQuality(dimension))),
      flags.min_dihedral.value_or(dimension == 3 ? files->min_dihedral.value_or(0) : 0));
  statistics.has_histogram = flags.histogram;
  statistics.names = files->names;
  if (!flags.svg.empty()) {
    io::HistogramOptions options;
    options.width = flags.width;
    options.log_scale = flags.log_scale;
    const std::string name = std::filesystem::path(path).filename().string();
    const std::string title = absl::StrFormat(
        "%s: %d %s, %s %.2f to %.2f degrees", name, statistics.simplices, SimplicesWord(dimension),
        AnglesWord(dimension), statistics.quality.min_angle_deg, statistics.quality.max_angle_deg);
    const absl::Status status =
        io::WriteHistogramSvg(title, StatisticsHistograms(statistics), options, flags.svg);
    if (!status.ok()) return ReportError(status);
  }
  if (!flags.lfs.empty()) {
    const absl::StatusOr<Input> input = LoadInputOfMesh("--lfs", flags.lfs, dimension);
    if (!input.ok()) return ReportError(input.status());
    statistics.conformity = MeasureConformity(files->mesh, input->features);
  }
  return PrintOut(json ? StatisticsJson(statistics) : StatisticsText(statistics)) ? kExitDone
                                                                                  : kExitFailed;
}

}  // namespace dynmesh::cli
