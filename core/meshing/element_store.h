// The vertices and subsegments by index, and which of them came or went since the last report.
#ifndef DYNMESH_CORE_MESHING_ELEMENT_STORE_H_
#define DYNMESH_CORE_MESHING_ELEMENT_STORE_H_

#include <cstddef>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "core/base/large_vector.h"
#include "core/meshing/elements.h"

namespace dynmesh::meshing {

// An index stays valid until the element is released and changes are taken. A new element
// invalidates references. Thread-compatible.
template <int D>
class ElementStore {
 public:
  using Vertex = meshing::Vertex<D>;
  using Subsegment = meshing::Subsegment<D>;
  // Outputs have 30 bits for an index. An undo may make as many elements again as there were.
  static constexpr std::size_t kMostElements = std::size_t{1} << 29;

  Vertex& vertex(VertexIndex v) { return vertices_[v]; }
  const Vertex& vertex(VertexIndex v) const { return vertices_[v]; }
  Subsegment& subsegment(SubsegmentIndex s) { return subsegments_[s]; }
  const Subsegment& subsegment(SubsegmentIndex s) const { return subsegments_[s]; }

  // Indices of vertices are below this. Some may be free.
  VertexIndex vertex_end() const { return static_cast<VertexIndex>(vertices_.size()); }
  // How many vertices are present.
  std::size_t vertex_count() const { return vertex_count_; }
  // True if a new vertex gets the index of a former one.
  bool has_free_vertices() const { return !free_vertices_.empty(); }
  // True if the greatest number of vertices or of subsegments has been exceeded.
  bool is_full() const { return is_full_; }
  void ForgetFull() { is_full_ = false; }

  void ReserveVertices(std::size_t count) { vertices_.reserve(count); }
  // A default element.
  VertexIndex NewVertex() {
    const VertexIndex v = New(vertices_, free_vertices_);
    if (!origins_.empty()) origins_.erase(v);
    return v;
  }
  SubsegmentIndex NewSubsegment() { return New(subsegments_, free_subsegments_); }
  // The whole segment between two vertices. Its direction does not depend on the client's, so that
  // rounding and hashes agree.
  SubsegmentIndex NewSegment(VertexIndex a, VertexIndex b, FeatureSlot feature) {
    const SubsegmentIndex s = NewSubsegment();
    Subsegment& sub = subsegments_[s];
    const bool forward = vertices_[a].p < vertices_[b].p;
    sub.a = sub.whole_a = forward ? a : b;
    sub.b = sub.whole_b = forward ? b : a;
    sub.feature = feature;
    return s;
  }

  // The origin of a counterpart, else one without a vertex.
  const Origin& origin(VertexIndex v) const {
    static constexpr Origin kNone;
    if (origins_.empty()) return kNone;
    const auto it = origins_.find(v);
    return it == origins_.end() ? kNone : it->second;
  }
  // REQUIRES: v is new.
  void SetOrigin(VertexIndex v, const Origin& origin) { origins_[v] = origin; }

  // The vertex appears or vanishes. REQUIRES: this is a change.
  void SetPresent(VertexIndex v, bool is) {
    vertices_[v].present = is;
    vertex_count_ += is ? 1 : -1;
    MarkVertexChanged(v);
  }
  void MarkVertexChanged(VertexIndex v) { Mark(vertices_, v, changed_vertices_); }
  void MarkSubsegmentChanged(SubsegmentIndex s) { Mark(subsegments_, s, changed_subsegments_); }
  // The index becomes free when changes are taken.
  void ReleaseVertex(VertexIndex v) { released_vertices_.push_back(v); }
  void ReleaseSubsegment(SubsegmentIndex s) { released_subsegments_.push_back(s); }

  static bool InMesh(const Vertex& v) { return v.present; }
  static bool InMesh(const Subsegment& s) {
    return s.exposed != sac::kNoStamp && s.death == sac::kNoStamp;
  }

  // Calls on_vertex(index, is, was) and on_subsegment(index, is, was) for those that came or went
  // since the last call. Then forgets those that are gone. O(their number).
  template <class OnVertex, class OnSubsegment>
  void TakeChanges(OnVertex on_vertex, OnSubsegment on_subsegment) {
    Take(vertices_, changed_vertices_, on_vertex);
    Take(subsegments_, changed_subsegments_, on_subsegment);
    Free(released_vertices_, free_vertices_);
    Free(released_subsegments_, free_subsegments_);
  }

  // Calls f(vertex index, vertex) / f(subsegment) for those in the mesh. O(all indices).
  template <class F>
  void ForEachVertex(F f) const {
    for (VertexIndex v = 0; v < vertices_.size(); ++v) {
      if (InMesh(vertices_[v])) f(v, vertices_[v]);
    }
  }
  template <class F>
  void ForEachSubsegment(F f) const {
    for (const Subsegment& s : subsegments_) {
      if (InMesh(s)) f(s);
    }
  }
  // The same for those that were in the mesh when changes were last taken. May be called at any
  // time.
  template <class F>
  void ForEachTakenVertex(F f) const {
    for (VertexIndex v = 0; v < vertices_.size(); ++v) {
      if (vertices_[v].in_mesh) f(v, vertices_[v]);
    }
  }
  template <class F>
  void ForEachTakenSubsegment(F f) const {
    for (const Subsegment& s : subsegments_) {
      if (s.in_mesh) f(s);
    }
  }

  std::size_t bytes() const {
    return vertices_.size() * sizeof(Vertex) + subsegments_.capacity() * sizeof(Subsegment) +
           origins_.capacity() * (sizeof(VertexIndex) + sizeof(Origin) + 1);
  }

 private:
  template <class Elements>
  std::uint32_t New(Elements& elements, std::vector<std::uint32_t>& free) {
    if (free.empty()) {
      elements.emplace_back();
      if (elements.size() > kMostElements) is_full_ = true;
      return static_cast<std::uint32_t>(elements.size() - 1);
    }
    const std::uint32_t i = free.back();
    free.pop_back();
    elements[i] = {};
    return i;
  }
  template <class Elements>
  static void Mark(Elements& elements, std::uint32_t i, std::vector<std::uint32_t>& changed) {
    if (elements[i].changed) return;
    elements[i].changed = true;
    changed.push_back(i);
  }
  template <class Elements, class F>
  static void Take(Elements& elements, std::vector<std::uint32_t>& changed, F f) {
    for (const std::uint32_t i : changed) {
      auto& element = elements[i];
      element.changed = false;
      const bool is = InMesh(element);
      f(i, is, element.in_mesh);
      element.in_mesh = is;
    }
    changed.clear();
  }
  static void Free(std::vector<std::uint32_t>& released, std::vector<std::uint32_t>& free) {
    free.insert(free.end(), released.begin(), released.end());
    released.clear();
  }

  LargeVector<Vertex> vertices_;
  LargeVector<Subsegment> subsegments_;
  std::vector<VertexIndex> free_vertices_, changed_vertices_, released_vertices_;
  std::vector<SubsegmentIndex> free_subsegments_, changed_subsegments_, released_subsegments_;
  absl::flat_hash_map<VertexIndex, Origin> origins_;  // of counterparts
  std::size_t vertex_count_ = 0;
  bool is_full_ = false;
};

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_ELEMENT_STORE_H_
