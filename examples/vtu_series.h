// A series for ParaView: one .vtu per step, and the .pvd that lists them. For the C++ examples; in
// 2D, with one field of values at vertices.
#ifndef DYNMESH_EXAMPLES_VTU_SERIES_H_
#define DYNMESH_EXAMPLES_VTU_SERIES_H_

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <span>
#include <sstream>
#include <string>
#include <system_error>
#include <utility>

#include "dynmesh/slot_mesh.h"

namespace examples {

class VtuSeries {
 public:
  VtuSeries(std::filesystem::path folder, std::string name)
      : folder_(std::move(folder)), name_(std::move(name)) {}

  // The path of the .pvd.
  std::string path() const { return (folder_ / (name_ + ".pvd")).string(); }

  // Writes one step, and updates the list. `values` is by vertex slot. False if a file cannot be
  // written.
  bool Add(double time, const dynmesh::SlotMesh& mesh, const std::string& field,
           std::span<const double> values) {
    std::error_code error;
    std::filesystem::create_directories(folder_, error);
    std::string number = std::to_string(steps_++);
    if (number.size() < 5) number.insert(0, 5 - number.size(), '0');
    const std::string file = name_ + '_' + number + ".vtu";
    lines_ << "<DataSet timestep=\"" << time << "\" file=\"" << file << "\"/>\n";
    return !error && WriteStep(folder_ / file, mesh, field, values) && WriteList();
  }

 private:
  static constexpr const char* kHeader = "<?xml version=\"1.0\"?>\n";
  static constexpr const char* kArrayEnd = "</DataArray>\n";

  static std::string Array(const std::string& name, const std::string& type, int components = 1) {
    return "<DataArray Name=\"" + name + "\" type=\"" + type + "\" NumberOfComponents=\"" +
           std::to_string(components) + "\" format=\"ascii\">\n";
  }

  static bool WriteStep(const std::filesystem::path& path, const dynmesh::SlotMesh& mesh,
                        const std::string& field, std::span<const double> values) {
    const dynmesh::CompactNumbering numbers = mesh.Compact();
    const std::size_t vertices = numbers.vertex_slots.size(), cells = numbers.simplex_slots.size();
    std::ofstream file(path);
    file.precision(9);
    file << kHeader << "<VTKFile type=\"UnstructuredGrid\" version=\"0.1\">\n<UnstructuredGrid>\n"
         << "<Piece NumberOfPoints=\"" << vertices << "\" NumberOfCells=\"" << cells << "\">\n";
    file << "<Points>\n" << Array("points", "Float64", 3);
    for (const dynmesh::Slot vertex : numbers.vertex_slots) {
      const double* const at = mesh.points().data() + 2 * static_cast<std::size_t>(vertex);
      file << at[0] << ' ' << at[1] << " 0\n";
    }
    file << kArrayEnd << "</Points>\n<PointData>\n" << Array(field, "Float64");
    for (const dynmesh::Slot vertex : numbers.vertex_slots) {
      file << values[static_cast<std::size_t>(vertex)] << '\n';
    }
    file << kArrayEnd << "</PointData>\n<Cells>\n" << Array("connectivity", "Int32");
    for (const dynmesh::Slot cell : numbers.simplex_slots) {
      const dynmesh::Slot* const corners = mesh.cells().data() + 3 * static_cast<std::size_t>(cell);
      for (std::size_t i = 0; i < 3; ++i) {
        file << numbers.vertex_numbers[static_cast<std::size_t>(corners[i])] << ' ';
      }
      file << '\n';
    }
    file << kArrayEnd << Array("offsets", "Int32");
    for (std::size_t i = 1; i <= cells; ++i) file << 3 * i << '\n';
    file << kArrayEnd << Array("types", "UInt8");
    for (std::size_t i = 0; i < cells; ++i) file << "5\n";  // VTK_TRIANGLE
    file << kArrayEnd << "</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
    file.close();
    return file.good();
  }

  bool WriteList() const {
    std::ofstream file(path());
    file << kHeader << "<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>\n"
         << lines_.str() << "</Collection>\n</VTKFile>\n";
    file.close();
    return file.good();
  }

  const std::filesystem::path folder_;
  const std::string name_;
  int steps_ = 0;
  std::ostringstream lines_;  // of the list, one per step
};

}  // namespace examples

#endif  // DYNMESH_EXAMPLES_VTU_SERIES_H_
