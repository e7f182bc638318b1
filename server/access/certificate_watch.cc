#include "server/access/certificate_watch.h"

#include "server/base/log.h"

namespace dynmesh::server {
namespace {

// The same as in deploy/alerts.yml.
constexpr absl::Duration kSoon = absl::Hours(14 * 24);

std::string Text(absl::Time time) {
  return absl::FormatTime(absl::RFC3339_sec, time, absl::UTCTimeZone());
}

}  // namespace

void CertificateWatch::Use(const std::string& file, const Validity& validity) {
  file_ = file;
  validity_ = validity;
  told_.reset();
}

std::optional<CertificateWatch::Finding> CertificateWatch::FindAt(absl::Time now) const {
  if (now >= validity_.until) return Finding::kExpired;
  if (now < validity_.from) return Finding::kNotValidYet;
  if (validity_.until - now < kSoon) return Finding::kEndsSoon;
  return std::nullopt;
}

std::optional<CertificateWatch::Finding> CertificateWatch::Due(absl::Time now) {
  const std::optional<Finding> finding = FindAt(now);
  const absl::Duration pause = finding == Finding::kEndsSoon ? absl::Hours(24) : absl::Hours(1);
  // The time of day can be set back.
  const bool is_news = finding != told_ || now - told_at_ >= pause || now < told_at_;
  told_ = finding;
  if (!finding.has_value() || !is_news) return std::nullopt;
  told_at_ = now;
  return finding;
}

void CertificateWatch::TellRefused(const std::string& file, const Validity& validity,
                                   absl::Time now) {
  constexpr char kStays[] = "the former certificate stays in use while it is valid";
  if (now >= validity.until) {
    Log(LogLevel::kError, "certificate_expired",
        {{"file", file}, {"until", Text(validity.until)}, {"message", kStays}});
  } else {
    Log(LogLevel::kError, "certificate_not_valid_yet",
        {{"file", file}, {"from", Text(validity.from)}, {"message", kStays}});
  }
}

void CertificateWatch::Look(absl::Time now) {
  const std::optional<Finding> finding = Due(now);
  if (!finding.has_value()) return;
  constexpr char kAdvice[] = "replace the file: it is read again, without a restart";
  switch (*finding) {
    case Finding::kEndsSoon:
      Log(LogLevel::kWarning, "certificate_ends_soon",
          {{"file", file_}, {"until", Text(validity_.until)}, {"message", kAdvice}});
      return;
    case Finding::kExpired:
      Log(LogLevel::kError, "certificate_expired",
          {{"file", file_}, {"until", Text(validity_.until)}, {"message", kAdvice}});
      return;
    case Finding::kNotValidYet:
      Log(LogLevel::kError, "certificate_not_valid_yet",
          {{"file", file_},
           {"from", Text(validity_.from)},
           {"message", "clients refuse it until then, unless this machine's clock is wrong"}});
      return;
  }
}

}  // namespace dynmesh::server
