#include "server/base/bus_error.h"

#include <fcntl.h>
#include <signal.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace dynmesh::server {
namespace {

// Only what a handler of signals may call: no allocation, no lock, no log.

// Text of a limited length; the rest is dropped.
struct Line {
  char text[1'024];
  std::size_t size = 0;

  void Add(const char* more, std::size_t length) {
    const std::size_t n = std::min(length, sizeof(text) - size);
    std::memcpy(text + size, more, n);
    size += n;
  }
  void Add(const char* more) { Add(more, std::strlen(more)); }
  void AddNumber(std::int64_t number, int digits) {
    char reversed[20];
    int n = 0;
    for (; number > 0 || n < digits; number /= 10) {
      reversed[n++] = static_cast<char>('0' + number % 10);
    }
    while (n > 0) Add(&reversed[--n], 1);
  }
};

// As the other lines of the log: 2026-01-31T23:59:59.123Z. The civil date by Howard Hinnant's
// days_from_civil, reversed; the library's functions take locks.
void AddTime(Line& line) {
  timespec now = {};
  clock_gettime(CLOCK_REALTIME, &now);
  const std::int64_t days = now.tv_sec / 86'400 + 719'468, second = now.tv_sec % 86'400;
  const std::int64_t era = days / 146'097, day_of_era = days % 146'097;
  const std::int64_t year_of_era =
      (day_of_era - day_of_era / 1'460 + day_of_era / 36'524 - day_of_era / 146'096) / 365;
  const std::int64_t day_of_year =
      day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
  const std::int64_t from_march = (5 * day_of_year + 2) / 153;
  const std::int64_t month = from_march < 10 ? from_march + 3 : from_march - 9;
  line.AddNumber(year_of_era + era * 400 + (month <= 2 ? 1 : 0), 4);
  line.Add("-");
  line.AddNumber(month, 2);
  line.Add("-");
  line.AddNumber(day_of_year - (153 * from_march + 2) / 5 + 1, 2);
  line.Add("T");
  line.AddNumber(second / 3'600, 2);
  line.Add(":");
  line.AddNumber(second / 60 % 60, 2);
  line.Add(":");
  line.AddNumber(second % 60, 2);
  line.Add(".");
  line.AddNumber(now.tv_nsec / 1'000'000, 3);
  line.Add("Z");
}

// Reads /proc/self/maps a line at a time: "begin-end rights offset device inode   path".
class Maps {
 public:
  Maps() : file_(open("/proc/self/maps", O_RDONLY | O_CLOEXEC)) {}
  ~Maps() {
    if (file_ >= 0) close(file_);
  }

  // The path of the mapping that has the address, in `line`; false if there is none.
  bool Find(std::uintptr_t address, Line& line) {
    for (Line row; Next(row);) {
      std::size_t at = 0;
      const std::uintptr_t begin = Hex(row, at);
      const std::uintptr_t end = Hex(row, ++at);
      if (address < begin || address >= end) continue;
      const void* const path = std::memchr(row.text, '/', row.size);
      if (path == nullptr) return false;
      const char* const from = static_cast<const char*>(path);
      line.Add(from, row.size - static_cast<std::size_t>(from - row.text));
      return true;
    }
    return false;
  }

 private:
  bool Next(Line& row) {
    row.size = 0;
    while (true) {
      if (at_ == filled_) {
        const ssize_t n = file_ < 0 ? 0 : read(file_, buffer_, sizeof(buffer_));
        if (n <= 0) return row.size > 0;
        at_ = 0;
        filled_ = static_cast<std::size_t>(n);
      }
      const char c = buffer_[at_++];
      if (c == '\n') return true;
      row.Add(&c, 1);
    }
  }
  static std::uintptr_t Hex(const Line& row, std::size_t& at) {
    std::uintptr_t number = 0;
    for (; at < row.size; ++at) {
      const char c = row.text[at];
      const bool digit = c >= '0' && c <= '9';
      if (!digit && (c < 'a' || c > 'f')) break;
      number = 16 * number + static_cast<std::uintptr_t>(digit ? c - '0' : c - 'a' + 10);
    }
    return number;
  }

  const int file_;
  char buffer_[512];
  std::size_t at_ = 0, filled_ = 0;
};

void Tell(int signal, siginfo_t* info, void*) {
  Line line;
  line.Add("time=");
  AddTime(line);
  line.Add(" level=error event=mapped_file_cut file=\"");
  if (!Maps().Find(reinterpret_cast<std::uintptr_t>(info->si_addr), line)) line.Add("unknown");
  line.Add(
      "\" message=\"the file was cut, or its disk failed, while this process had it in memory: it "
      "ends (signal 7). What was acknowledged is on the disk: start it again, and keep other "
      "programs from the data folder\"\n");
  [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, line.text, line.size);
  // The default action, once this returns and the access is repeated.
  struct sigaction otherwise = {};
  otherwise.sa_handler = SIG_DFL;
  sigaction(signal, &otherwise, nullptr);
  if (info->si_code <= 0) raise(signal);  // another process sent it: nothing is repeated
}

}  // namespace

void TellBusErrors() {
  struct sigaction action = {};
  action.sa_sigaction = &Tell;
  action.sa_flags = SA_SIGINFO;
  sigemptyset(&action.sa_mask);
  sigaction(SIGBUS, &action, nullptr);
}

}  // namespace dynmesh::server
