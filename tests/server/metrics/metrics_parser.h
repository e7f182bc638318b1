// A strict reader of Prometheus' text format, 0.0.4, written from the format's specification: any
// deviation is an error. It requires more than the format does: HELP and TYPE of each family, once
// and together; counters that end in _total; consistent histograms.
#ifndef DYNMESH_TESTS_SERVER_METRICS_METRICS_PARSER_H_
#define DYNMESH_TESTS_SERVER_METRICS_METRICS_PARSER_H_

#include <cctype>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"

namespace dynmesh::server {

class ParsedMetrics {
 public:
  using Labels = std::map<std::string, std::string>;

  explicit ParsedMetrics(const std::string& text) { Parse(text); }

  const std::string& error() const { return error_; }  // empty: the text is as it must be
  bool Has(const std::string& name) const { return types_.contains(name); }
  // NaN if there is no such sample.
  double Value(const std::string& name, const Labels& labels = {}) const {
    const auto it = samples_.find({name, labels});
    return it == samples_.end() ? std::numeric_limits<double>::quiet_NaN() : it->second;
  }
  std::size_t size() const { return samples_.size(); }

 private:
  void Parse(const std::string& text) {
    if (!absl::EndsWith(text, "\n")) return Fail("no end of line at the end", text);
    std::vector<std::string> lines = absl::StrSplit(text, '\n');
    lines.pop_back();
    for (const std::string& line : lines) {
      if (!error_.empty()) return;
      if (absl::StartsWith(line, "#")) {
        Comment(line);
      } else {
        Sample(line);
      }
    }
    if (!help_.empty()) Fail("HELP without TYPE", help_);
    for (const auto& [name, type] : types_) {
      if (type == "histogram") CheckHistogram(name);
    }
  }

  void Fail(const std::string& what, const std::string& line) {
    if (error_.empty()) error_ = absl::StrCat(what, ": ", line);
  }

  static bool IsName(const std::string& name, bool colons) {
    if (name.empty() || std::isdigit(static_cast<unsigned char>(name[0])) != 0) return false;
    for (const char c : name) {
      if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '_' && !(colons && c == ':')) {
        return false;
      }
    }
    return true;
  }

  void Comment(const std::string& line) {
    const std::vector<std::string> words = absl::StrSplit(line, absl::MaxSplits(' ', 3));
    if (words.size() != 4 || words[0] != "#" || !IsName(words[2], true)) {
      return Fail("neither HELP nor TYPE", line);
    }
    if (words[1] == "HELP") {
      if (!help_.empty()) return Fail("HELP without TYPE", help_);
      help_ = words[2];
    } else if (words[1] == "TYPE") {
      family_ = words[2];
      if (help_ != family_) return Fail("TYPE without HELP before it", line);
      help_.clear();
      if (words[3] != "counter" && words[3] != "gauge" && words[3] != "histogram") {
        return Fail("unknown type", line);
      }
      if ((words[3] == "counter") != absl::EndsWith(family_, "_total")) {
        return Fail("counters end in _total, others do not", line);
      }
      if (!types_.emplace(family_, words[3]).second) return Fail("a family twice", line);
    } else {
      Fail("neither HELP nor TYPE", line);
    }
  }

  bool BelongsToFamily(const std::string& name) const {
    const auto type = types_.find(family_);
    if (type == types_.end()) return false;
    if (type->second != "histogram") return name == family_;
    return name == family_ + "_bucket" || name == family_ + "_sum" || name == family_ + "_count";
  }

  void Sample(const std::string& line) {
    std::size_t at = line.find_first_of("{ ");
    if (at == std::string::npos) return Fail("no value", line);
    const std::string name = line.substr(0, at);
    if (!IsName(name, true) || !BelongsToFamily(name)) return Fail("not of this family", line);
    Labels labels;
    if (line[at] == '{') {
      at = ReadLabels(line, at + 1, &labels);
      if (at == std::string::npos) return Fail("labels", line);
    }
    if (at + 1 >= line.size() || line[at] != ' ' || line[at + 1] == ' ') {
      return Fail("one space before the value", line);
    }
    char* end = nullptr;
    const double value = std::strtod(line.c_str() + at + 1, &end);
    if (*end != '\0') return Fail("value", line);
    if (types_[family_] != "gauge" && !(value >= 0)) return Fail("negative", line);
    if (!samples_.emplace(std::pair{name, labels}, value).second) Fail("a sample twice", line);
  }

  // From after '{'; the place after '}'.
  static std::size_t ReadLabels(const std::string& line, std::size_t at, Labels* labels) {
    while (true) {
      const std::size_t equals = line.find("=\"", at);
      if (equals == std::string::npos) return equals;
      const std::string name = line.substr(at, equals - at);
      if (!IsName(name, false)) return std::string::npos;
      std::string value;
      for (at = equals + 2; at < line.size() && line[at] != '"'; ++at) {
        if (line[at] != '\\') {
          value += line[at];
        } else if (const char c = ++at < line.size() ? line[at] : 0; c == 'n') {
          value += '\n';
        } else if (c == '\\' || c == '"') {
          value += c;
        } else {
          return std::string::npos;
        }
      }
      if (at + 1 >= line.size() || !labels->emplace(name, value).second) return std::string::npos;
      if (line[at + 1] == '}') return at + 2;
      if (line[at + 1] != ',') return std::string::npos;
      at += 2;
    }
  }

  void CheckHistogram(const std::string& name) {
    std::map<Labels, std::map<double, double>> buckets;  // by labels but `le`, by bound
    for (const auto& [key, value] : samples_) {
      if (key.first != name + "_bucket") continue;
      Labels labels = key.second;
      const std::string bound = labels.contains("le") ? labels["le"] : "";
      labels.erase("le");
      char* end = nullptr;
      const double le = std::strtod(bound.c_str(), &end);
      if (bound.empty() || *end != '\0') return Fail("a bucket without bound", name);
      buckets[labels][le] = value;
    }
    std::size_t counts = 0;
    for (const auto& [key, value] : samples_) counts += key.first == name + "_count" ? 1 : 0;
    if (counts != buckets.size()) return Fail("a histogram without buckets or count", name);
    for (const auto& [labels, by_bound] : buckets) {
      double before = 0;
      for (const auto& [bound, count] : by_bound) {
        if (count < before) return Fail("buckets are not cumulative", name);
        before = count;
      }
      if (!std::isinf(by_bound.rbegin()->first)) return Fail("no bucket +Inf", name);
      if (Value(name + "_count", labels) != before) return Fail("count is not bucket +Inf", name);
      if (std::isnan(Value(name + "_sum", labels))) return Fail("no sum", name);
    }
  }

  std::string error_;
  std::string help_;    // of which TYPE is to follow
  std::string family_;  // that samples are of
  std::map<std::string, std::string> types_;
  std::map<std::pair<std::string, Labels>, double> samples_;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_TESTS_SERVER_METRICS_METRICS_PARSER_H_
