#include "tests/e2e/soak/figures.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>

#include "absl/strings/str_cat.h"
#include "client/cli/percentile.h"

namespace dynmesh::soak {
namespace {

constexpr double kMegabyte = 1 << 20;

using Clock = std::chrono::steady_clock;

double MillisecondsSince(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

bool Paused(const absl::Notification& stop, double seconds) {
  return !stop.WaitForNotificationWithTimeout(absl::Seconds(seconds));
}

// The median of samples[begin, end).
double MedianOf(const std::vector<MemorySample>& samples, std::size_t begin, std::size_t end) {
  std::vector<double> part;
  for (std::size_t i = begin; i < end; ++i) part.push_back(samples[i].megabytes);
  return cli::Percentile(std::move(part), 0.5);
}

// Of the least-squares line, MB a second.
double Slope(const std::vector<MemorySample>& samples, std::size_t begin) {
  const auto n = static_cast<double>(samples.size() - begin);
  double mean_t = 0, mean_m = 0;
  for (std::size_t i = begin; i < samples.size(); ++i) {
    mean_t += samples[i].seconds / n;
    mean_m += samples[i].megabytes / n;
  }
  double both = 0, square = 0;
  for (std::size_t i = begin; i < samples.size(); ++i) {
    const double t = samples[i].seconds - mean_t;
    both += t * (samples[i].megabytes - mean_m);
    square += t * t;
  }
  return square > 0 ? both / square : 0;
}

}  // namespace

cli::JsonObject Spread(const std::vector<double>& samples) {
  cli::JsonObject spread;
  spread.Add("n", samples.size());
  spread.Add("p50", cli::Percentile(samples, 0.5));
  spread.Add("p99", cli::Percentile(samples, 0.99));
  spread.Add("max", cli::Percentile(samples, 1));
  return spread;
}

Growth JudgeGrowth(const std::vector<MemorySample>& samples) {
  Growth growth;
  const std::size_t n = samples.size(), warm = n / 5, tenth = n / 10;
  if (tenth == 0) return growth;
  growth.warm = MedianOf(samples, warm, warm + tenth);
  growth.last = MedianOf(samples, n - tenth, n);
  for (std::size_t i = warm; i < n; ++i) {
    growth.highest = std::max(growth.highest, samples[i].megabytes);
  }
  growth.per_hour = 3600 * Slope(samples, warm);
  return growth;
}

double ResidentMegabytes(pid_t process) {
  std::ifstream in(absl::StrCat("/proc/", process, "/statm"));
  double total = 0, resident = 0;
  if (!(in >> total >> resident)) return 0;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / kMegabyte;
}

double FolderMegabytes(const std::string& folder) {
  double bytes = 0;
  std::error_code error;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder, error)) {
    const auto size = entry.is_regular_file(error) ? entry.file_size(error) : 0;
    if (!error) bytes += static_cast<double>(size);  // else it has just gone
  }
  return bytes / kMegabyte;
}

void ProbeDisk(const std::string& file, double pause_seconds, const absl::Notification& stop,
               Latencies& times) {
  constexpr std::size_t kBlock = 4096, kBlocks = 64;
  const int fd = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (fd < 0) return;
  // The file has its final size before: this measures the transfer of data, as in a journal that
  // overwrites its log.
  std::string block(kBlock * kBlocks, 'x');
  bool good = pwrite(fd, block.data(), block.size(), 0) > 0 && fsync(fd) == 0;
  for (std::size_t i = 0; good && Paused(stop, pause_seconds); ++i) {
    block[0] = static_cast<char>('a' + i % 26);
    const auto start = Clock::now();
    good = pwrite(fd, block.data(), kBlock, static_cast<off_t>(i % kBlocks * kBlock)) > 0 &&
           fdatasync(fd) == 0;
    if (good) times.Add(MillisecondsSince(start));
  }
  close(fd);
}

void ProbeCalls(client::MeshClient& client, double pause_seconds, const absl::Notification& stop,
                Latencies& times) {
  while (Paused(stop, pause_seconds)) {
    const auto start = Clock::now();
    const auto answer = client.GetMesh("no-such-mesh");
    if (absl::IsNotFound(answer.status())) times.Add(MillisecondsSince(start));
  }
}

}  // namespace dynmesh::soak
