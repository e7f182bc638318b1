// Metrics for Prometheus: counters, gauges and histograms, families of them that differ in their
// labels, and a registry that writes all as text (exposition format 0.0.4).
//
// Counting is a few relaxed atomic operations, without a lock or an allocation: look a member up in
// its family once and keep it. Writing the text locks the families and is O(its length). The text
// is not one consistent moment, but a histogram's count is always the sum of its buckets. Members
// live as long as their registry. Thread-safe.
#ifndef DYNMESH_SERVER_METRICS_METRICS_H_
#define DYNMESH_SERVER_METRICS_METRICS_H_

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/string_view.h"
#include "core/base/mutex.h"

namespace dynmesh::server {

class Counter {
 public:
  void Add(std::uint64_t n = 1) { value_.fetch_add(n, std::memory_order_relaxed); }
  std::uint64_t value() const { return value_.load(std::memory_order_relaxed); }

 private:
  std::atomic<std::uint64_t> value_{0};
};

class Gauge {
 public:
  void Set(double value) { value_.store(value, std::memory_order_relaxed); }
  void Add(double change) { value_.fetch_add(change, std::memory_order_relaxed); }
  double value() const { return value_.load(std::memory_order_relaxed); }

 private:
  std::atomic<double> value_{0};
};

class Histogram {
 public:
  // Upper bounds of the buckets, ascending. A last bucket without a bound is added.
  explicit Histogram(std::vector<double> bounds);
  void Observe(double value);

  const std::vector<double>& bounds() const { return bounds_; }
  // Number of observations <= each bound, then of all.
  std::vector<std::uint64_t> Cumulative() const;
  double sum() const { return sum_.load(std::memory_order_relaxed); }

 private:
  const std::vector<double> bounds_;
  const std::unique_ptr<std::atomic<std::uint64_t>[]> buckets_;  // bounds_.size() + 1
  std::atomic<double> sum_{0};
};

// 1e-5, 2.5e-5, 5e-5, 1e-4, ... seconds, up to the last that is <= `most`.
std::vector<double> SecondsBounds(double most);

using MetricLabels = std::vector<std::pair<absl::string_view, absl::string_view>>;

// Writes the text family by family. Not thread-safe.
class MetricsText {
 public:
  // Begins a family; the samples that follow belong to it. `type`: counter, gauge or histogram.
  void Begin(absl::string_view name, absl::string_view type, absl::string_view help);
  void Sample(const MetricLabels& labels, double value);
  // A family with one sample.
  void Single(absl::string_view name, absl::string_view type, absl::string_view help, double value);

  // `labels` as from LabelText.
  void Add(const std::string& labels, const Counter& counter);
  void Add(const std::string& labels, const Gauge& gauge);
  void Add(const std::string& labels, const Histogram& histogram);

  const std::string& text() const { return text_; }

  // name="value",... with values escaped; empty for no labels.
  static std::string LabelText(const MetricLabels& labels);

 private:
  void Line(absl::string_view suffix, absl::string_view labels, double value);

  std::string name_;
  std::string text_;
};

// A source of text for a registry.
class MetricSource {
 public:
  virtual ~MetricSource() = default;
  virtual void Write(MetricsText& out) const = 0;
};

template <typename T>
class MetricFamily final : public MetricSource {
 public:
  using Make = std::function<std::unique_ptr<T>()>;
  MetricFamily(std::string name, std::string type, std::string help, Make make)
      : name_(std::move(name)),
        type_(std::move(type)),
        help_(std::move(help)),
        make_(std::move(make)) {}

  // The member with these labels; made if absent. All members of a family have the same label
  // names. Costs a lock and a search: call it once and keep the result.
  T& With(const MetricLabels& labels = {}) {
    const std::string key = MetricsText::LabelText(labels);
    const MutexLock lock(mutex_);
    std::unique_ptr<T>& member = members_[key];
    if (member == nullptr) member = make_();
    return *member;
  }

  void Write(MetricsText& out) const override {
    const MutexLock lock(mutex_);
    out.Begin(name_, type_, help_);
    for (const auto& [labels, member] : members_) out.Add(labels, *member);
  }

 private:
  const std::string name_;
  const std::string type_;
  const std::string help_;
  const Make make_;
  mutable Mutex mutex_;
  // By their labels' text.
  std::map<std::string, std::unique_ptr<T>> members_ ABSL_GUARDED_BY(mutex_);
};

class MetricRegistry {
 public:
  MetricFamily<Counter>& AddCounters(const std::string& name, const std::string& help);
  MetricFamily<Gauge>& AddGauges(const std::string& name, const std::string& help);
  MetricFamily<Histogram>& AddHistograms(const std::string& name, const std::string& help,
                                         const std::vector<double>& bounds);
  // `write` is called for each text, for figures computed then.
  void AddSource(std::function<void(MetricsText&)> write);

  std::string Text() const;

 private:
  template <typename T>
  T& Keep(std::unique_ptr<T> source);

  mutable Mutex mutex_;
  std::vector<std::unique_ptr<MetricSource>> sources_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_METRICS_METRICS_H_
