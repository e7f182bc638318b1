#include "server/journal/wal_walk.h"

#include <filesystem>
#include <fstream>
#include <system_error>
#include <vector>

#include "absl/strings/str_cat.h"

namespace dynmesh::server {
namespace {

// https://www.sqlite.org/fileformat2.html#walformat. All numbers are big-endian.
constexpr std::size_t kHeaderBytes = 32, kFrameHeaderBytes = 24;
constexpr std::uint32_t kMagic = 0x377f0682, kVersion = 3'007'000;
constexpr std::uint32_t kLeastPage = 512, kLargestPage = 65'536, kUsualPage = 4'096;

std::uint32_t Big(const unsigned char* at) {
  return std::uint32_t{at[0]} << 24 | std::uint32_t{at[1]} << 16 | std::uint32_t{at[2]} << 8 |
         std::uint32_t{at[3]};
}
std::uint32_t Little(const unsigned char* at) {
  return std::uint32_t{at[3]} << 24 | std::uint32_t{at[2]} << 16 | std::uint32_t{at[1]} << 8 |
         std::uint32_t{at[0]};
}
std::uint64_t Long(const unsigned char* at) { return std::uint64_t{Big(at)} << 32 | Big(at + 4); }

struct Sum {
  std::uint32_t a = 0, b = 0;
  bool operator==(const Sum&) const = default;

  // `bytes` is a multiple of 8.
  void Add(const unsigned char* at, std::size_t bytes, bool big) {
    for (const unsigned char* const end = at + bytes; at < end; at += 8) {
      a += (big ? Big(at) : Little(at)) + b;
      b += (big ? Big(at + 4) : Little(at + 4)) + a;
    }
  }
};

Sum SumAt(const unsigned char* at) { return {Big(at), Big(at + 4)}; }

struct Header {
  bool sound = false;
  bool big = false;  // byte order of the checksums' words
  std::uint32_t page = 0;
  std::uint64_t salt = 0;
  Sum sum;
};

Header HeaderOf(const unsigned char* at) {
  Header header;
  header.big = (Big(at) & 1) != 0;
  header.page = Big(at + 8);
  header.salt = Long(at + 16);
  header.sum = SumAt(at + 24);
  Sum sum;
  sum.Add(at, 24, header.big);
  const bool page = header.page >= kLeastPage && header.page <= kLargestPage &&
                    (header.page & (header.page - 1)) == 0;
  header.sound = (Big(at) & ~1u) == kMagic && Big(at + 4) == kVersion && page && sum == header.sum;
  return header;
}

// Processes the frames in order.
class Walk {
 public:
  explicit Walk(const Header& header) : header_(header), before_(header.sum), made_(header.sum) {
    follows_ = header.sound;
    walk_.salt = header.sound ? header.salt : 0;
  }

  void Take(const unsigned char* frame) {
    ++number_;
    const std::uint64_t salt = Long(frame + 8);
    const Sum written = SumAt(frame + 16);
    const Sum sum = SumOf(frame, before_);
    // The damage may be in the checksum of the frame before.
    const bool continues = Big(frame) != 0 && (sum == written || SumOf(frame, made_) == written);
    const bool ends = Big(frame + 4) != 0;
    follows_ = follows_ && Big(frame) != 0 && sum == written && salt == header_.salt;
    if (follows_) {
      if (ends) walk_.taken = walk_.shown = number_;
    } else if (continues && ended_ && number_ > 1 && salt == SaltToHave()) {
      walk_.shown = number_ - 1;
      walk_.salt = salt;
    }
    before_ = written;
    made_ = sum;
    salt_ = salt;
    ended_ = ends;
  }
  const WalWalk& walk() const { return walk_; }

 private:
  Sum SumOf(const unsigned char* frame, Sum before) const {
    before.Add(frame, 8, header_.big);
    before.Add(frame + kFrameHeaderBytes, header_.page, header_.big);
    return before;
  }
  // The salt expected of a frame. Frames left of an older log may stand behind those of the present
  // one.
  std::uint64_t SaltToHave() const { return header_.sound ? header_.salt : salt_; }

  const Header header_;
  Sum before_;  // as stored in the frame before, or in the header
  Sum made_;    // as computed, from the checksum of the frame before that
  bool ended_ = false;
  std::uint64_t salt_ = 0;
  bool follows_ = false;  // SQLite reads up to here
  std::uint32_t number_ = 0;
  WalWalk walk_;
};

}  // namespace

absl::StatusOr<WalWalk> WalkWal(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    std::error_code error;
    if (!std::filesystem::exists(path, error) && !error) return WalWalk();
    return absl::UnavailableError(absl::StrCat("cannot read ", path));
  }
  const auto read = [&file](std::vector<unsigned char>& bytes) {
    file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    return static_cast<std::size_t>(file.gcount()) == bytes.size();
  };
  std::vector<unsigned char> bytes(kHeaderBytes);
  if (!read(bytes)) return WalWalk();
  Header header = HeaderOf(bytes.data());
  if (!header.sound) {
    // The values of this program's databases.
    header.page = kUsualPage;
    header.big = false;
  }
  Walk walk(header);
  bytes.resize(kFrameHeaderBytes + header.page);
  while (read(bytes)) walk.Take(bytes.data());
  if (file.bad()) return absl::UnavailableError(absl::StrCat("cannot read ", path));
  return walk.walk();
}

std::uint64_t WalSalt(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  unsigned char bytes[kHeaderBytes];
  if (!file.read(reinterpret_cast<char*>(bytes), sizeof(bytes))) return 0;
  return Long(bytes + 16);
}

}  // namespace dynmesh::server
