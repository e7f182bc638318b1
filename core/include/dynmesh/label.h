// Labels: an integer and a name that a client gives to a feature, for its own use.
//
//   dynmesh::Feature inlet = dynmesh::Feature::Segment(3, 1, 2);
//   inlet.label = {7, "inlet"};
//   if (inlet.label->name == "inlet") Open(inlet.label->marker);
//
// A mesh, its trace and its hash do not depend on labels. Values; thread-compatible.
#ifndef DYNMESH_LABEL_H_
#define DYNMESH_LABEL_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>

namespace dynmesh {

// The most bytes of FeatureLabel::name.
inline constexpr std::size_t kMostNameBytes = 255;

// What a client says of a feature. An empty label is the same as none.
struct FeatureLabel {
  std::int64_t marker = 0;  // 0: none
  // Empty: none. At most kMostNameBytes bytes of valid UTF-8 without control characters (U+0000 to
  // U+001F, U+007F to U+009F).
  std::string name = {};

  // Neither marker nor name?
  bool empty() const { return marker == 0 && name.empty(); }
  friend bool operator==(const FeatureLabel&, const FeatureLabel&) = default;
};

// A label, or none. Without one it costs a null pointer.
class OptionalLabel {
 public:
  // None.
  OptionalLabel() noexcept = default;
  // A copy of `label`; none if that is empty.
  OptionalLabel(FeatureLabel label) {  // NOLINT(google-explicit-constructor): a label is one
    if (!label.empty()) label_ = std::make_unique<const FeatureLabel>(std::move(label));
  }
  // The label of `marker` and `name`; none if both are empty.
  OptionalLabel(std::int64_t marker, std::string name)
      : OptionalLabel(FeatureLabel{marker, std::move(name)}) {}
  // A copy of `other`.
  OptionalLabel(const OptionalLabel& other) {
    if (other.label_ != nullptr) label_ = std::make_unique<const FeatureLabel>(*other.label_);
  }
  // Takes the label of `other`, which has none then.
  OptionalLabel(OptionalLabel&& other) noexcept = default;
  // A copy of `other`.
  OptionalLabel& operator=(const OptionalLabel& other) {
    if (label_ != nullptr || other.label_ != nullptr) *this = OptionalLabel(other);
    return *this;
  }
  // Takes the label of `other`.
  OptionalLabel& operator=(OptionalLabel&& other) noexcept = default;
  ~OptionalLabel() = default;

  // Is there a label? Then it is not empty.
  explicit operator bool() const { return label_ != nullptr; }
  // The label; an empty one if there is none.
  const FeatureLabel& operator*() const { return label_ != nullptr ? *label_ : Empty(); }
  // The same.
  const FeatureLabel* operator->() const { return &**this; }
  // Are `a` and `b` the same label, or both none?
  friend bool operator==(const OptionalLabel& a, const OptionalLabel& b) {
    return a.label_ == b.label_ || *a == *b;
  }

 private:
  static const FeatureLabel& Empty() {
    static const FeatureLabel empty;
    return empty;
  }

  std::unique_ptr<const FeatureLabel> label_;
};

}  // namespace dynmesh

#endif  // DYNMESH_LABEL_H_
