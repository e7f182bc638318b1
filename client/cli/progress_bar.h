// A line on standard error that shows how far something is, for people: nothing where that is no
// terminal. Thread-compatible.
#ifndef DYNMESH_CLIENT_CLI_PROGRESS_BAR_H_
#define DYNMESH_CLIENT_CLI_PROGRESS_BAR_H_

#include <chrono>
#include <cstdint>
#include <string>

namespace dynmesh::cli {

class ProgressBar {
 public:
  explicit ProgressBar(bool shown) : shown_(shown) {}
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;
  ~ProgressBar() { End(); }

  // Ten times a second at most, but for what is done. `total` 0: not known.
  void Show(std::uint64_t done, std::uint64_t total, const std::string& what = "");
  // Ends the line.
  void End();

 private:
  const bool shown_;
  bool open_ = false;
  std::string what_;
  std::chrono::steady_clock::time_point shown_at_;
};

// "\r[####....] 4/10 what"; without a bar, and without what is not known.
std::string ProgressLine(std::uint64_t done, std::uint64_t total, const std::string& what);

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_CLI_PROGRESS_BAR_H_
