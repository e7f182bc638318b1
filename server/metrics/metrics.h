// Figures for Prometheus: counters, gauges and histograms, families of them that differ in their
// labels, and a registry that writes all as text (exposition format 0.0.4).
//
// Counting is a few relaxed atomic operations, without a lock and without memory: a family is
// asked for its member once, and the member kept. Writing the text takes the families' locks, and
// is O(its length). A text is of no single moment, but a histogram's count is always the sum of its
// buckets. Members live as long as their registry. Thread-safe.
#ifndef DYNMESH_SERVER_METRICS_METRICS_H_
#define DYNMESH_SERVER_METRICS_METRICS_H_

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/string_view.h"

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
  // Upper bounds of the buckets, ascending; the last one, without a bound, is there by itself.
  explicit Histogram(std::vector<double> bounds);
  void Observe(double value);

  const std::vector<double>& bounds() const { return bounds_; }
  // Observations no greater than each bound, then all.
  std::vector<std::uint64_t> Cumulative() const;
  double sum() const { return sum_.load(std::memory_order_relaxed); }

 private:
  const std::vector<double> bounds_;
  const std::unique_ptr<std::atomic<std::uint64_t>[]> buckets_;  // bounds_.size() + 1
  std::atomic<double> sum_{0};
};

// 1e-5, 2.5e-5, 5e-5, 1e-4, ... seconds, to `most` or what is next below it.
std::vector<double> SecondsBounds(double most);

using MetricLabels = std::vector<std::pair<absl::string_view, absl::string_view>>;

// The text, family by family. Not thread-safe.
class MetricsText {
 public:
  // `type`: counter, gauge or histogram. Samples that follow are of this family.
  void Begin(absl::string_view name, absl::string_view type, absl::string_view help);
  void Sample(const MetricLabels& labels, double value);
  // A family of one.
  void Single(absl::string_view name, absl::string_view type, absl::string_view help, double value);

  // With labels as LabelText gives them.
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

// What a registry writes.
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

  // The member with these labels, which is made if there is none. All members of a family have
  // the same names of labels. A lock and a search: once, not each time.
  T& With(const MetricLabels& labels = {}) {
    const std::string key = MetricsText::LabelText(labels);
    const std::lock_guard lock(mutex_);
    std::unique_ptr<T>& member = members_[key];
    if (member == nullptr) member = make_();
    return *member;
  }

  void Write(MetricsText& out) const override {
    const std::lock_guard lock(mutex_);
    out.Begin(name_, type_, help_);
    for (const auto& [labels, member] : members_) out.Add(labels, *member);
  }

 private:
  const std::string name_;
  const std::string type_;
  const std::string help_;
  const Make make_;
  mutable std::mutex mutex_;
  std::map<std::string, std::unique_ptr<T>> members_;  // by their labels' text
};

class MetricRegistry {
 public:
  MetricFamily<Counter>& AddCounters(const std::string& name, const std::string& help);
  MetricFamily<Gauge>& AddGauges(const std::string& name, const std::string& help);
  MetricFamily<Histogram>& AddHistograms(const std::string& name, const std::string& help,
                                         const std::vector<double>& bounds);
  // Called for each text, for figures that are looked up then.
  void AddSource(std::function<void(MetricsText&)> write);

  std::string Text() const;

 private:
  template <typename T>
  T& Keep(std::unique_ptr<T> source);

  mutable std::mutex mutex_;
  std::vector<std::unique_ptr<MetricSource>> sources_;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_METRICS_METRICS_H_
