#include "server/metrics/metrics.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"

namespace dynmesh::server {
namespace {

// The shortest text that reads back exactly.
std::string NumberText(double value) {
  if (std::isnan(value)) return "NaN";
  if (std::isinf(value)) return value > 0 ? "+Inf" : "-Inf";
  char digits[32];
  return {digits, std::to_chars(digits, std::end(digits), value, std::chars_format::general).ptr};
}

class WrittenByFunction final : public MetricSource {
 public:
  explicit WrittenByFunction(std::function<void(MetricsText&)> write) : write_(std::move(write)) {}
  void Write(MetricsText& out) const override { write_(out); }

 private:
  const std::function<void(MetricsText&)> write_;
};

}  // namespace

Histogram::Histogram(std::vector<double> bounds)
    : bounds_(std::move(bounds)), buckets_(new std::atomic<std::uint64_t>[bounds_.size() + 1]()) {}

void Histogram::Observe(double value) {
  const auto at = std::lower_bound(bounds_.begin(), bounds_.end(), value) - bounds_.begin();
  buckets_[static_cast<std::size_t>(at)].fetch_add(1, std::memory_order_relaxed);
  sum_.fetch_add(value, std::memory_order_relaxed);
}

std::vector<std::uint64_t> Histogram::Cumulative() const {
  std::vector<std::uint64_t> counts(bounds_.size() + 1);
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    counts[i] = sum += buckets_[i].load(std::memory_order_relaxed);
  }
  return counts;
}

std::vector<double> SecondsBounds(double most) {
  // Literals, as the text shows them: computed products would be off by an ulp.
  std::vector<double> bounds = {1e-5, 2.5e-5, 5e-5,  1e-4, 2.5e-4, 5e-4, 1e-3, 2.5e-3,
                                5e-3, 0.01,   0.025, 0.05, 0.1,    0.25, 0.5,  1,
                                2.5,  5,      10,    25,   50,     100,  250,  500,
                                1e3,  2.5e3,  5e3,   1e4,  2.5e4,  5e4,  1e5};
  std::erase_if(bounds, [most](double bound) { return bound > most; });
  return bounds;
}

std::string MetricsText::LabelText(const MetricLabels& labels) {
  std::string text;
  for (const auto& [name, value] : labels) {
    absl::StrAppend(&text, text.empty() ? "" : ",", name, "=\"",
                    absl::StrReplaceAll(value, {{"\\", "\\\\"}, {"\"", "\\\""}, {"\n", "\\n"}}),
                    "\"");
  }
  return text;
}

void MetricsText::Begin(absl::string_view name, absl::string_view type, absl::string_view help) {
  name_ = std::string(name);
  absl::StrAppend(&text_, "# HELP ", name, " ",
                  absl::StrReplaceAll(help, {{"\\", "\\\\"}, {"\n", "\\n"}}), "\n# TYPE ", name,
                  " ", type, "\n");
}

void MetricsText::Line(absl::string_view suffix, absl::string_view labels, double value) {
  absl::StrAppend(&text_, name_, suffix);
  if (!labels.empty()) absl::StrAppend(&text_, "{", labels, "}");
  absl::StrAppend(&text_, " ", NumberText(value), "\n");
}

void MetricsText::Sample(const MetricLabels& labels, double value) {
  Line("", LabelText(labels), value);
}

void MetricsText::Single(absl::string_view name, absl::string_view type, absl::string_view help,
                         double value) {
  Begin(name, type, help);
  Sample({}, value);
}

void MetricsText::Add(const std::string& labels, const Counter& counter) {
  Line("", labels, static_cast<double>(counter.value()));
}

void MetricsText::Add(const std::string& labels, const Gauge& gauge) {
  Line("", labels, gauge.value());
}

void MetricsText::Add(const std::string& labels, const Histogram& histogram) {
  const std::vector<std::uint64_t> counts = histogram.Cumulative();
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const bool last = i == histogram.bounds().size();
    const std::string bound = last ? "+Inf" : NumberText(histogram.bounds()[i]);
    Line("_bucket", absl::StrCat(labels, labels.empty() ? "" : ",", "le=\"", bound, "\""),
         static_cast<double>(counts[i]));
  }
  Line("_sum", labels, histogram.sum());
  Line("_count", labels, static_cast<double>(counts.back()));
}

template <typename T>
T& MetricRegistry::Keep(std::unique_ptr<T> source) {
  T& kept = *source;
  const MutexLock lock(mutex_);
  sources_.push_back(std::move(source));
  return kept;
}

MetricFamily<Counter>& MetricRegistry::AddCounters(const std::string& name,
                                                   const std::string& help) {
  return Keep(std::make_unique<MetricFamily<Counter>>(name, "counter", help,
                                                      [] { return std::make_unique<Counter>(); }));
}

MetricFamily<Gauge>& MetricRegistry::AddGauges(const std::string& name, const std::string& help) {
  return Keep(std::make_unique<MetricFamily<Gauge>>(name, "gauge", help,
                                                    [] { return std::make_unique<Gauge>(); }));
}

MetricFamily<Histogram>& MetricRegistry::AddHistograms(const std::string& name,
                                                       const std::string& help,
                                                       const std::vector<double>& bounds) {
  return Keep(std::make_unique<MetricFamily<Histogram>>(
      name, "histogram", help, [bounds] { return std::make_unique<Histogram>(bounds); }));
}

void MetricRegistry::AddSource(std::function<void(MetricsText&)> write) {
  Keep(std::make_unique<WrittenByFunction>(std::move(write)));
}

std::string MetricRegistry::Text() const {
  MetricsText out;
  const MutexLock lock(mutex_);
  for (const auto& source : sources_) source->Write(out);
  return out.text();
}

}  // namespace dynmesh::server
