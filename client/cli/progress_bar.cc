#include "client/cli/progress_bar.h"

#include <algorithm>
#include <cstdio>

#include "absl/strings/str_cat.h"

namespace dynmesh::cli {

const char* WordOf(ApplyProgress::Stage stage) {
  switch (stage) {
    case ApplyProgress::Stage::kValidate:
      return "checking";
    case ApplyProgress::Stage::kRefine:
      return "refining";
    case ApplyProgress::Stage::kDiff:
      return "comparing";
  }
  return "";
}

std::string ProgressLine(std::uint64_t done, std::uint64_t total, const std::string& what) {
  constexpr std::uint64_t kWidth = 40;
  std::string line = "\r";
  if (total > 0) {
    const auto filled = static_cast<std::size_t>(std::min(kWidth, done * kWidth / total));
    absl::StrAppend(&line, "[", std::string(filled, '#'), std::string(kWidth - filled, '.'), "] ",
                    done, "/", total);
  } else if (done > 0) {
    absl::StrAppend(&line, done);
  }
  if (!what.empty()) absl::StrAppend(&line, line.size() > 1 ? " " : "", what);
  return line;
}

void ProgressBar::Show(std::uint64_t done, std::uint64_t total, const std::string& what) {
  if (!shown_) return;
  const auto now = std::chrono::steady_clock::now();
  const bool is_end = done == total && total > 0;
  if (!is_end && what == what_ && now - shown_at_ < std::chrono::milliseconds(100)) return;
  shown_at_ = now;
  what_ = what;
  open_ = true;
  constexpr char kClearToEnd[] = "\033[K";
  std::fprintf(stderr, "%s%s", ProgressLine(done, total, what).c_str(), kClearToEnd);
}

void ProgressBar::End() {
  if (open_) std::fputc('\n', stderr);
  open_ = false;
}

}  // namespace dynmesh::cli
