#include "core/io/pictures/mesh_animation.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "absl/strings/str_format.h"
#include "core/io/common/file_writer.h"
#include "core/io/pictures/picture_frame.h"
#include "core/io/pictures/simplex_colours.h"
#include "core/io/pictures/svg_legend.h"
#include "core/io/pictures/svg_path.h"

namespace dynmesh::io {
namespace {

constexpr std::string_view kEdge = "#38495c", kSegment = "#14213d";

// The attribute has values[i] from times[i] on, in parts of the whole.
void Animate(std::string_view attribute, const std::vector<std::string_view>& values,
             const std::vector<double>& times, double seconds, FileWriter& out) {
  out << "<animate attributeName=\"" << attribute << "\" calcMode=\"discrete\" dur=\""
      << absl::StrFormat("%gs", seconds) << "\" repeatCount=\"indefinite\" values=\"";
  for (std::size_t i = 0; i < values.size(); ++i) out << (i == 0 ? "" : ";") << values[i];
  out << "\" keyTimes=\"";
  for (std::size_t i = 0; i < times.size(); ++i) {
    out << (i == 0 ? "" : ";") << absl::StrFormat("%.5g", times[i]);
  }
  out << "\"/>";
}

class AnimationDrawing {
 public:
  AnimationDrawing(const AnimationOptions& options, int frames, FileWriter& out)
      : frame_({options.crop.lo[0], options.crop.lo[1]}, {options.crop.hi[0], options.crop.hi[1]},
               options.width),
        frames_(frames),
        seconds_(options.seconds * frames),
        out_(out) {}

  void Open(double width) {
    const double height = std::ceil(frame_.height) + std::ceil(LegendHeight(width));
    out_ << "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" << std::ceil(width)
         << "\" height=\"" << height << "\" viewBox=\"0 0 " << std::ceil(width) << ' ' << height
         << "\">\n<title>A Delaunay mesh that changes, " << frames_
         << " frames</title>\n<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n";
  }

  void Close(double width) {
    WriteLegend({{std::string(kHighlightFill), "added by the last edit"},
                 {std::string(kPlainFill), "as before it"}},
                std::ceil(frame_.height), width, out_);
    out_ << "</svg>\n";
  }

  // One path for the rows that show in the same frames.
  template <std::size_t K>
  void Draw(const std::pair<int, int>& frames,
            const std::vector<std::array<PictureFrame::Position, K>>& rows) {
    bool is_open = false;
    for (const auto& row : rows) {
      PictureFrame::Position lo = row[0], hi = row[0];
      std::array<Pixel, K> pixels;
      for (std::size_t k = 0; k < K; ++k) {
        for (std::size_t j = 0; j < 2; ++j) {
          lo[j] = std::min(lo[j], row[k][j]), hi[j] = std::max(hi[j], row[k][j]);
        }
        pixels[k] = PixelAt(frame_, row[k]);
      }
      if (!frame_.Shows(lo, hi)) continue;
      if (!is_open) OpenPath(K == 3, frames.first == 0);
      is_open = true;
      WriteLinePath(pixels, out_);
      if (K == 3) out_ << 'z';
    }
    if (!is_open) return;
    out_ << "\">";
    Time(K == 3, frames);
    out_ << "</path>\n";
  }

 private:
  void OpenPath(bool is_filled, bool is_first) {
    out_ << "<path fill=\"" << (is_filled ? kPlainFill : "none") << "\" stroke=\""
         << (is_filled ? kEdge : kSegment) << "\" stroke-width=\""
         << (is_filled ? ".4" : "1.4")
         // What plays no animation shows the first frame.
         << (is_first ? "" : "\" visibility=\"hidden") << "\" d=\"";
  }

  void Time(bool is_filled, const std::pair<int, int>& frames) {
    const auto [from, to] = frames;
    const auto part = [&](int frame) { return static_cast<double>(frame) / frames_; };
    std::vector<std::string_view> values = {from == 0 ? "visible" : "hidden"};
    std::vector<double> times = {0};
    if (from != 0) values.push_back("visible"), times.push_back(part(from));
    if (to != frames_) values.push_back("hidden"), times.push_back(part(to));
    if (values.size() > 1) Animate("visibility", values, times, seconds_, out_);
    if (!is_filled || from == 0) return;
    if (to == from + 1) {
      Animate("fill", {kHighlightFill}, {0}, seconds_, out_);
    } else {
      Animate("fill", {kHighlightFill, kPlainFill}, {0, part(from + 1)}, seconds_, out_);
    }
  }

  const PictureFrame frame_;
  const int frames_;
  const double seconds_;
  FileWriter& out_;
};

}  // namespace

template <std::size_t K>
void MeshAnimation::Rows<K>::Remove(const std::array<VertexId, K>& row, int frame) {
  const auto it = present.find(row);
  if (it == present.end()) return;
  if (it->second != frame) gone[{it->second, frame}].push_back(row);
  present.erase(it);
}

template <std::size_t K>
std::map<MeshAnimation::Frames, std::vector<std::array<VertexId, K>>> MeshAnimation::Rows<K>::All(
    int frames) const {
  auto all = gone;
  for (const auto& [row, from] : present) all[{from, frames}].push_back(row);
  for (auto& [when, rows] : all) std::sort(rows.begin(), rows.end());
  return all;
}

void MeshAnimation::Add(const MeshDiff& diff) {
  if (has_begun_) ++frame_;
  const VertexColumns& vertices = diff.added_vertices;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    positions_[vertices.ids[i]] = {vertices.coordinates[2 * i], vertices.coordinates[2 * i + 1]};
  }
  const auto row_at = [](const auto& column, std::size_t i, auto& row) {
    std::copy_n(&column[row.size() * i], row.size(), row.begin());
  };
  std::array<VertexId, 3> triangle;
  for (std::size_t i = 0; i < diff.removed_simplex_count(); ++i) {
    row_at(diff.removed_simplices, i, triangle);
    triangles_.Remove(triangle, frame_);
  }
  for (std::size_t i = 0; i < diff.added_simplex_count(); ++i) {
    row_at(diff.added_simplices, i, triangle);
    triangles_.present.emplace(triangle, frame_);
  }
  std::array<VertexId, 2> segment;
  for (std::size_t i = 0; i < diff.removed_subsegments.size(); ++i) {
    row_at(diff.removed_subsegments.ends, i, segment);
    segments_.Remove(segment, frame_);
  }
  for (std::size_t i = 0; i < diff.added_subsegments.size(); ++i) {
    if (diff.added_subsegments.owners[i] == kBoxFeature) continue;
    row_at(diff.added_subsegments.ends, i, segment);
    segments_.present.emplace(segment, frame_);
  }
}

Box MeshAnimation::Extent() const {
  Box box = {{0, 0, 0}, {0, 0, 0}};
  if (!positions_.empty()) {
    const auto& [x, y] = positions_.begin()->second;
    box.lo = box.hi = {x, y, 0};
  }
  for (const auto& [id, position] : positions_) {
    for (std::size_t k = 0; k < 2; ++k) {
      box.lo[k] = std::min(box.lo[k], position[k]), box.hi[k] = std::max(box.hi[k], position[k]);
    }
  }
  return box;
}

absl::Status MeshAnimation::Write(const AnimationOptions& options, const std::string& path) const {
  FileWriter out(path);
  AnimationDrawing drawing(options, frames(), out);
  const auto draw = [&]<std::size_t K>(const Rows<K>& rows) {
    for (const auto& [when, ids] : rows.All(frames())) {
      std::vector<std::array<PictureFrame::Position, K>> placed(ids.size());
      for (std::size_t i = 0; i < ids.size(); ++i) {
        for (std::size_t k = 0; k < K; ++k) placed[i][k] = positions_.at(ids[i][k]);
      }
      drawing.Draw(when, placed);
    }
  };
  drawing.Open(options.width);
  draw(triangles_);
  draw(segments_);
  drawing.Close(options.width);
  return out.Close();
}

}  // namespace dynmesh::io
