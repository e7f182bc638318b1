#include "core/dynamic_mesh/wedge_table.h"

#include <algorithm>

namespace dynmesh {
namespace {

template <class T>
void SortUnique(std::vector<T>& values) {
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
}

template <int D>
meshing::SegmentShape ShapeIn(const meshing::ElementStore<D>& elements,
                              const typename WedgeTable<D>::Segment& s) {
  if (s.unsplit) return {.unsplit = true};
  const double length =
      meshing::LengthOf(elements.vertex(s.ends[0]).p, elements.vertex(s.ends[1]).p);
  return meshing::ShapeOf<D>(length, s.wedges[0], s.wedges[1]);
}

}  // namespace

template <int D>
typename WedgeTable<D>::Index WedgeTable<D>::Add(Vertex lesser, Vertex greater,
                                                 meshing::FeatureSlot slot, bool unsplit) {
  Index index = static_cast<Index>(segments_.size());
  if (free_.empty()) {
    segments_.emplace_back();
  } else {
    index = free_.back();
    free_.pop_back();
  }
  segments_[index] = Segment{{lesser, greater}};
  segments_[index].slot = slot;
  segments_[index].unsplit = unsplit;
  for (const Vertex end : {lesser, greater}) {
    at_[end].push_back(index);
    touched_.push_back(end);
  }
  return index;
}

template <int D>
typename WedgeTable<D>::Index WedgeTable<D>::Find(Vertex a, Vertex b) const {
  const Users& at_a = at_.at(a);
  const Users& at_b = at_.at(b);
  for (const Index index : at_a.size() < at_b.size() ? at_a : at_b) {
    const auto& [p, q] = segments_[index].ends;
    if ((p == a && q == b) || (p == b && q == a)) return index;
  }
  return meshing::kNil;
}

template <int D>
void WedgeTable<D>::Remove(Index index) {
  for (const Vertex end : segments_[index].ends) {
    const auto at = at_.find(end);
    at->second.erase(std::find(at->second.begin(), at->second.end(), index));
    if (at->second.empty()) at_.erase(at);
    touched_.push_back(end);
  }
  free_.push_back(index);
}

template <int D>
void WedgeTable<D>::Update(const Elements& elements, absl::FunctionRef<void(Segment*)> changed) {
  std::vector<Index> affected;
  SortUnique(touched_);
  for (const Vertex apex : touched_) {
    const auto at = at_.find(apex);
    if (at == at_.end()) continue;
    FindWedgesAt(apex, at->second, elements);
    affected.insert(affected.end(), at->second.begin(), at->second.end());
  }
  touched_.clear();
  SortUnique(affected);
  for (const Index index : affected) {
    Segment& s = segments_[index];
    const meshing::SegmentShape shape = ShapeIn<D>(elements, s);
    if (s.root != meshing::kNil && shape == s.shape) continue;
    s.shape = shape;
    changed(&s);
  }
}

template <int D>
void WedgeTable<D>::FindWedgesAt(Vertex apex, const Users& users, const Elements& elements) {
  others_.clear();
  for (const Index index : users) {
    const Segment& s = segments_[index];
    others_.push_back(elements.vertex(s.ends[s.ends[0] == apex ? 1 : 0]).p);
  }
  const auto wedges = meshing::FindWedges<D>(elements.vertex(apex).p, others_);
  for (std::size_t i = 0; i < others_.size(); ++i) {
    Segment& s = segments_[users[i]];
    s.wedges[s.ends[0] == apex ? 0 : 1] = wedges[i];
  }
}

template <int D>
std::size_t WedgeTable<D>::bytes() const {
  return segments_.capacity() * sizeof(Segment) + free_.capacity() * sizeof(Index) +
         at_.capacity() * (sizeof(Vertex) + sizeof(Users) + 1);
}

template class WedgeTable<2>;
template class WedgeTable<3>;

}  // namespace dynmesh
