// A progress line on standard error; empty unless that is a terminal. Thread-compatible.
#ifndef DYNMESH_CLIENT_CLI_PROGRESS_BAR_H_
#define DYNMESH_CLIENT_CLI_PROGRESS_BAR_H_

#include <chrono>
#include <cstdint>
#include <string>

#include "dynmesh/dynamic_mesh.h"

namespace dynmesh::cli {

class ProgressBar {
 public:
  explicit ProgressBar(bool shown) : shown_(shown) {}
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;
  ~ProgressBar() { End(); }

  // At most ten times a second, except at the end. `total` 0: unknown.
  void Show(std::uint64_t done, std::uint64_t total, const std::string& what = "");
  // Ends the line.
  void End();

 private:
  const bool shown_;
  bool open_ = false;
  std::string what_;
  std::chrono::steady_clock::time_point shown_at_;
};

// The word for a stage of a batch: "checking", "refining", "comparing".
const char* WordOf(ApplyProgress::Stage stage);

// "\r[####....] 4/10 what"; unknown parts and the bar for an unknown total are left out.
std::string ProgressLine(std::uint64_t done, std::uint64_t total, const std::string& what);

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_CLI_PROGRESS_BAR_H_
