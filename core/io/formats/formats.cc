#include "core/io/formats/formats.h"

#include <algorithm>
#include <iterator>

#include "core/io/common/extension.h"
#include "core/io/formats/geometry.h"
#include "core/io/formats/mesh_input.h"
#include "core/io/formats/mesh_output.h"
#include "core/io/formats/prepare_surface.h"
#include "core/io/maps/map_files.h"
#include "core/io/meshes/medit_writer.h"
#include "core/io/meshes/msh_writer.h"
#include "core/io/meshes/vtu_writer.h"
#include "core/io/pictures/leaf_svg.h"
#include "core/io/plane/planar_input.h"
#include "core/io/plane/planar_output.h"
#include "core/io/solvers/abaqus_writer.h"
#include "core/io/solvers/adcirc_writer.h"
#include "core/io/solvers/sms_writer.h"
#include "core/io/solvers/su2_writer.h"
#include "core/io/space/space_input.h"
#include "core/io/space/surface_files.h"
#include "core/io/space/surface_output.h"

namespace dynmesh::io {
namespace {

// ---- the functions of rows, in the form that they have there

// Files of facets that have a meaning each.
template <absl::StatusOr<FileFeatures> (*kRead)(const std::string&, FaceRules)>
absl::StatusOr<Geometry> ReadFacets(const std::string& path, const GeometryOptions& options) {
  absl::StatusOr<FileFeatures> file = kRead(path, options.faces);
  return file.ok() ? GeometryOfSpace(*std::move(file), path)
                   : absl::StatusOr<Geometry>(file.status());
}

template <absl::StatusOr<FileFeatures> (*kRead)(const std::string&, FaceRules)>
absl::StatusOr<Geometry> ReadSurface(const std::string& path, const GeometryOptions& options) {
  if (options.faces == FaceRules::kAsTheyCome) return ReadFacets<kRead>(path, options);
  absl::StatusOr<FileFeatures> file = kRead(path, FaceRules::kMended);
  if (!file.ok()) return file.status();
  return PrepareSurface(*std::move(file), path, options);
}

absl::StatusOr<FileFeatures> ReadSpaceNodes(const std::string& path, FaceRules) {
  return ReadSpaceNodeFile(path);
}

// Files of Triangle in 2D or of TetGen in 3D: the 2D reader reports 3D ones as UNIMPLEMENTED.
template <absl::StatusOr<FileFeatures> (*kPlane)(const std::string&),
          absl::StatusOr<FileFeatures> (*kSpace)(const std::string&, FaceRules)>
absl::StatusOr<Geometry> ReadPlaneOrSpace(const std::string& path, const GeometryOptions& options) {
  absl::StatusOr<FileFeatures> file = kPlane(path);
  if (file.ok()) return GeometryOfPlane(*std::move(file), path);
  if (!absl::IsUnimplemented(file.status())) return file.status();
  return ReadFacets<kSpace>(path, options);
}

template <absl::StatusOr<ElementMesh> (*kRead)(const std::string&)>
absl::StatusOr<Geometry> ReadBorders(const std::string& path, const GeometryOptions&) {
  const absl::StatusOr<ElementMesh> mesh = kRead(path);
  return mesh.ok() ? GeometryOfElements(*mesh, path, false)
                   : absl::StatusOr<Geometry>(mesh.status());
}

absl::StatusOr<Geometry> ReadMap(const std::string& path, const GeometryOptions& options) {
  MapOptions map;
  map.polygons = options.polygons;
  MendedRings mended;
  if (options.mend_rings) map.mended = &mended;
  absl::StatusOr<FileFeatures> file = ReadMapFile(path, map);
  if (!file.ok()) return file.status();
  Geometry geometry = GeometryOfPlane(*std::move(file), path);
  geometry.mended = mended;
  return geometry;
}

absl::StatusOr<Geometry> ReadScript(const std::string& path, const GeometryOptions&) {
  const absl::StatusOr<EditScript> script = ReadEditScript(path);
  return script.ok() ? GeometryOfScript(*script) : script.status();
}

template <absl::StatusOr<ElementMesh> (*kRead)(const std::string&)>
absl::StatusOr<MeshFiles> ReadForeign(const std::string& path) {
  const absl::StatusOr<ElementMesh> elements = kRead(path);
  if (!elements.ok()) return elements.status();
  MeshFiles files;
  files.mesh = ToIndexed(*elements);
  return files;
}

absl::Status WriteNodes(const IndexedMesh& mesh, const MeshOutput& output,
                        const std::string& path) {
  return WriteMeshFiles(mesh, path, output.files);
}

// Of writers that take the mesh and the path alone.
template <absl::Status (*kWrite)(const IndexedMesh&, const std::string&)>
absl::Status WriteAlone(const IndexedMesh& mesh, const MeshOutput&, const std::string& path) {
  return kWrite(mesh, path);
}
template <absl::Status (*kWrite)(const LeafList&, const std::string&)>
absl::Status WriteAlone(const LeafList& list, const MeshOutput&, const std::string& path) {
  return kWrite(list, path);
}

absl::Status WriteMshMesh(const IndexedMesh& mesh, const MeshOutput& output,
                          const std::string& path) {
  return WriteMsh(mesh, path, output.msh_version, output.binary);
}

absl::Status WriteVtuMesh(const IndexedMesh& mesh, const MeshOutput& output,
                          const std::string& path) {
  return WriteVtu(mesh, output.files.rho, path, output.files.min_dihedral, output.files.threads);
}

absl::Status WritePicture(const IndexedMesh& mesh, const MeshOutput& output,
                          const std::string& path) {
  return WriteSvg(output.shown != nullptr ? *output.shown : mesh, output.picture, path);
}

absl::Status WriteLeafPicture(const LeafList& list, const MeshOutput& output,
                              const std::string& path) {
  return WriteLeafSvg(list, output.picture, path);
}

absl::Status WritePoly(const std::string& path, const FeatureOutput& output) {
  const auto write = output.options.dimension == 2 ? WritePolyFile : WriteSpacePolyFile;
  return write(path, output.features, output.holes, output.regions, output.labels);
}

absl::Status WriteSmesh(const std::string& path, const FeatureOutput& output) {
  return WriteSmeshFile(path, output.features, output.holes, output.regions, output.labels);
}

absl::Status WriteOff(const std::string& path, const FeatureOutput& output) {
  return WriteOffFile(path, output.features);
}

absl::Status WriteScript(const std::string& path, const FeatureOutput& output) {
  return WriteFeatureScript(path, output.options, output.features, output.labels);
}

// ---- the table

constexpr std::string_view kInput = "docs/input.md#formats";
constexpr std::string_view kMeshes = "docs/commands.md#files-of-meshes";

constexpr Format kFormats[] = {
    {.extension = ".node",
     .what = "Triangle and TetGen, with .ele, .edge and, in 3D, .face beside it; .poly, .smesh or "
             ".neigh with that file, too",
     .in_2d = true,
     .in_3d = true,
     .flags = kSecondOrder | kChosenMarkers,
     .document = kMeshes,
     .read_geometry = ReadPlaneOrSpace<ReadNodeFile, ReadSpaceNodes>,
     .read_mesh = ReadMeshFiles,
     .write_mesh = WriteNodes},
    {.extension = ".ele",
     .what = "triangles or tetrahedra beside a .node",
     .in_2d = true,
     .in_3d = true,
     .flags = kBesideNode | kSecondOrder,
     .document = kMeshes,
     .read_mesh = ReadMeshFiles,
     .write_mesh = WriteNodes},
    {.extension = ".edge",
     .what = "edges beside a .node",
     .in_2d = true,
     .in_3d = true,
     .flags = kBesideNode | kSecondOrder | kChosenMarkers,
     .document = kMeshes,
     .read_mesh = ReadMeshFiles,
     .write_mesh = WriteNodes},
    {.extension = ".face",
     .what = "faces beside a .node of 3D",
     .in_2d = true,  // not written, but the others are
     .in_3d = true,
     .flags = kBesideNode | kSecondOrder | kChosenMarkers,
     .document = kMeshes,
     .read_mesh = ReadMeshFiles,
     .write_mesh = WriteNodes},
    {.extension = ".neigh",
     .what = "neighbours beside a .node",
     .in_2d = true,
     .in_3d = true,
     .flags = kBesideNode | kSecondOrder,
     .document = kMeshes,
     .read_mesh = ReadMeshFiles,
     .write_mesh = WriteNodes},
    {.extension = ".poly",
     .what = "Triangle's and TetGen's segments and facets",
     .in_2d = true,
     .in_3d = true,
     .flags =
         kBesideNode | kSecondOrder | kChosenMarkers | kKeepsSegments | kKeepsSeeds | kKeepsMarkers,
     .document = kInput,
     .read_geometry = ReadPlaneOrSpace<ReadPolyFile, ReadSpacePolyFile>,
     .write_features = WritePoly,
     .write_mesh = WriteNodes},
    {.extension = ".smesh",
     .what = "TetGen's facets",
     .in_3d = true,
     .flags =
         kBesideNode | kSecondOrder | kChosenMarkers | kKeepsSegments | kKeepsSeeds | kKeepsMarkers,
     .document = kInput,
     .read_geometry = ReadFacets<ReadSmeshFile>,
     .write_features = WriteSmesh,
     .write_mesh = WriteNodes},
    {.extension = ".off",
     .what = "a surface",
     .in_3d = true,
     .flags = kSurface,
     .document = kInput,
     .read_geometry = ReadSurface<ReadOffFile>,
     .write_features = WriteOff},
    {.extension = ".stl",
     .what = "a surface of triangles",
     .in_3d = true,
     .flags = kSurface,
     .document = kInput,
     .read_geometry = ReadSurface<ReadStlFile>},
    {.extension = ".obj",
     .what = "a surface",
     .in_3d = true,
     .flags = kSurface,
     .document = kInput,
     .read_geometry = ReadSurface<ReadObjFile>},
    {.extension = ".ply",
     .what = "a surface",
     .in_3d = true,
     .flags = kSurface,
     .document = kInput,
     .read_geometry = ReadSurface<ReadPlyFile>},
    {.extension = ".geojson",
     .what = "a map",
     .in_2d = true,
     .flags = kMap,
     .document = kInput,
     .read_geometry = ReadMap},
    {.extension = ".topojson",
     .what = "a map",
     .in_2d = true,
     .flags = kMap,
     .document = kInput,
     .read_geometry = ReadMap},
    {.extension = ".json",
     .what = "a map, of either kind",
     .in_2d = true,
     .flags = kMap,
     .document = kInput,
     .read_geometry = ReadMap},
    {.extension = ".csv",
     .what = "the leaves of a quadtree",
     .in_2d = true,
     .in_3d = true,
     .document = kMeshes,
     .read_leaves = ReadLeafCsv,
     .write_leaves = WriteAlone<WriteLeafCsv>},
    {.extension = ".vtu",
     .what = "VTK, for ParaView",
     .in_2d = true,
     .in_3d = true,
     .flags = kSecondOrder,
     .document = kMeshes,
     .read_geometry = ReadBorders<ReadVtuFile>,
     .read_elements = ReadVtuFile,
     .read_mesh = ReadForeign<ReadVtuFile>,
     .write_mesh = WriteVtuMesh,
     .write_leaves = WriteAlone<WriteLeafVtu>},
    {.extension = ".msh",
     .what = "Gmsh 4.1 and 2.2",
     .in_2d = true,
     .in_3d = true,
     .flags = kSecondOrder | kChosenMarkers,
     .document = kMeshes,
     .read_geometry = ReadBorders<ReadMshFile>,
     .read_elements = ReadMshFile,
     .read_mesh = ReadForeign<ReadMshFile>,
     .write_mesh = WriteMshMesh},
    {.extension = ".mesh",
     .what = "Medit",
     .in_2d = true,
     .in_3d = true,
     .flags = kChosenMarkers,
     .document = kMeshes,
     .read_geometry = ReadBorders<ReadMeditFile>,
     .read_elements = ReadMeditFile,
     .read_mesh = ReadForeign<ReadMeditFile>,
     .write_mesh = WriteAlone<WriteMedit>},
    {.extension = ".inp",
     .what = "Abaqus and CalculiX",
     .in_2d = true,
     .in_3d = true,
     .flags = kSecondOrder | kChosenMarkers,
     .document = kMeshes,
     .write_mesh = WriteAlone<WriteAbaqus>},
    {.extension = ".su2",
     .what = "SU2",
     .in_2d = true,
     .in_3d = true,
     .flags = kChosenMarkers,
     .document = kMeshes,
     .write_mesh = WriteAlone<WriteSu2>},
    {.extension = ".2dm",
     .what = "SMS and QGIS",
     .in_2d = true,
     .flags = kChosenMarkers,
     .document = kMeshes,
     .write_mesh = WriteAlone<WriteSms>},
    {.extension = ".14",
     .what = "ADCIRC",
     .in_2d = true,
     .flags = kChosenMarkers,
     .document = kMeshes,
     .write_mesh = WriteAlone<WriteAdcirc>},
    {.extension = ".grd",
     .what = "ADCIRC",
     .in_2d = true,
     .flags = kChosenMarkers,
     .document = kMeshes,
     .write_mesh = WriteAlone<WriteAdcirc>},
    {.extension = ".svg",
     .what = "a picture",
     .in_2d = true,
     .in_3d = true,
     .flags = kPicture,
     .document = kMeshes,
     .write_mesh = WritePicture,
     .write_leaves = WriteLeafPicture},
    {.extension = ".asc",
     .what = "a raster of ESRI",
     .in_2d = true,
     .document = kInput,
     .read_sizes = ReadAscFile},
    {.extension = ".npy",
     .what = "an array of numpy, which covers the box",
     .in_2d = true,
     .in_3d = true,
     .document = kInput,
     .read_sizes = ReadNpyFile},
    {.extension = ".pos",
     .what = "a view of Gmsh",
     .in_2d = true,
     .in_3d = true,
     .document = kInput,
     .read_sizes = ReadPosFile},
    {.extension = ".mtr",
     .what = "TetGen's, of the input's points, or with .node and .ele of its own",
     .in_2d = true,
     .in_3d = true,
     .document = kInput,
     .read_sizes = ReadMtrFile},
    {.extension = ".dynmesh",
     .what = "an edit script",
     .in_2d = true,
     .in_3d = true,
     .flags = kScript | kKeepsAllButSeeds,
     .document = kInput,
     .read_geometry = ReadScript,
     .write_features = WriteScript},
};

// Formats of geometry and meshes that other programs have: not to be taken for edit scripts.
constexpr std::string_view kOthers[] = {
    ".3ds", ".3mf",  ".bdf",    ".brep", ".cdb",  ".cgns", ".dae", ".dxf",   ".e",   ".exo",
    ".fbx", ".geo",  ".glb",    ".gltf", ".iges", ".igs",  ".med", ".meshb", ".nas", ".png",
    ".shp", ".step", ".sldprt", ".stp",  ".unv",  ".vtk",  ".vtp", ".wkt"};

}  // namespace

std::span<const Format> Formats() { return kFormats; }

const Format* FindFormat(const std::string& path) {
  const std::string extension = ExtensionOf(path);
  const auto* const row = std::ranges::find(kFormats, extension, &Format::extension);
  return row == std::end(kFormats) ? nullptr : row;
}

bool IsOtherFormat(const std::string& path) {
  return std::ranges::find(kOthers, ExtensionOf(path)) != std::end(kOthers);
}

}  // namespace dynmesh::io
