#include "server/access/tls.h"

#include <grpc/grpc.h>
#include <grpc/grpc_security.h>
#include <openssl/bio.h>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/x509.h>

#include <algorithm>
#include <array>
#include <ctime>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "core/base/mutex.h"
#include "server/access/certificate_watch.h"
#include "server/access/file_stamp.h"
#include "server/base/log.h"

namespace dynmesh::server {
namespace {

struct Free {
  void operator()(BIO* p) const { BIO_free(p); }
  void operator()(X509* p) const { X509_free(p); }
  void operator()(EVP_PKEY* p) const { EVP_PKEY_free(p); }
};
template <typename T>
using Owned = std::unique_ptr<T, Free>;

constexpr absl::Duration kBetweenReadings = absl::Seconds(1);

// The result of one reading of the files.
struct Material {
  std::string certificate;
  std::string key;
  std::string client_ca;
};

absl::Status Bad(const char* flag, const std::string& path, absl::string_view why) {
  ERR_clear_error();
  return absl::InvalidArgumentError(absl::StrCat(flag, ": ", path, ": ", why));
}

Owned<BIO> Open(const std::string& pem) {
  return Owned<BIO>(BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())));
}

// No password: OpenSSL would prompt on the terminal.
int NoPassword(char*, int, int, void*) { return -1; }

absl::Status CheckMaterial(const TlsFiles& files, const Material& m) {
  const Owned<BIO> chain = Open(m.certificate);
  const Owned<X509> leaf(PEM_read_bio_X509(chain.get(), nullptr, &NoPassword, nullptr));
  if (leaf == nullptr) return Bad("tls-cert", files.certificate, "holds no PEM certificate");
  while (const Owned<X509> next{PEM_read_bio_X509(chain.get(), nullptr, &NoPassword, nullptr)}) {
  }
  if (ERR_GET_REASON(ERR_peek_last_error()) != PEM_R_NO_START_LINE) {
    return Bad("tls-cert", files.certificate, "its chain has a certificate that cannot be read");
  }
  const Owned<EVP_PKEY> key(
      PEM_read_bio_PrivateKey(Open(m.key).get(), nullptr, &NoPassword, nullptr));
  if (key == nullptr) {
    return Bad("tls-key", files.key, "holds no PEM private key without a password");
  }
  if (X509_check_private_key(leaf.get(), key.get()) != 1) {
    return Bad("tls-key", files.key,
               absl::StrCat("does not belong to the certificate in ", files.certificate));
  }
  if (files.client_ca.empty()) return ERR_clear_error(), absl::OkStatus();
  const Owned<X509> authority(
      PEM_read_bio_X509(Open(m.client_ca).get(), nullptr, &NoPassword, nullptr));
  if (authority == nullptr) {
    return Bad("tls-client-ca", files.client_ca, "holds no PEM certificate");
  }
  return ERR_clear_error(), absl::OkStatus();
}

// The infinite future if `time` is invalid.
absl::Time TimeOf(const ASN1_TIME* time) {
  std::tm utc = {};
  if (ASN1_TIME_to_tm(time, &utc) == 1) return absl::FromTM(utc, absl::UTCTimeZone());
  ERR_clear_error();
  return absl::InfiniteFuture();
}

// The intersection over all certificates in a text, as a chain needs all of them.
Validity ValidityOf(const std::string& pem) {
  Validity all;
  const Owned<BIO> chain = Open(pem);
  while (const Owned<X509> next{PEM_read_bio_X509(chain.get(), nullptr, &NoPassword, nullptr)}) {
    all.from = std::max(all.from, TimeOf(X509_get0_notBefore(next.get())));
    all.until = std::min(all.until, TimeOf(X509_get0_notAfter(next.get())));
  }
  ERR_clear_error();
  return all;
}

absl::StatusOr<Material> ReadMaterial(const TlsFiles& files) {
  Material material;
  for (const auto& [flag, path, text] :
       {std::tuple{"tls-cert", &files.certificate, &material.certificate},
        std::tuple{"tls-key", &files.key, &material.key},
        std::tuple{"tls-client-ca", &files.client_ca, &material.client_ca}}) {
    if (path->empty()) continue;
    absl::StatusOr<std::string> read = ReadSmallFile(flag, *path);
    if (!read.ok()) return read.status();
    *text = *std::move(read);
  }
  if (absl::Status status = CheckMaterial(files, material); !status.ok()) return status;
  return material;
}

class FileCredentials final : public TlsCredentials {
 public:
  FileCredentials(const TlsFiles& files, const std::array<FileStamp, 3>& stamps, Material first)
      : files_(files), stamps_(stamps) {
    {
      const MutexLock lock(mutex_);
      Use(std::move(first));
    }
    auto* options = grpc_ssl_server_credentials_create_options_using_config_fetcher(
        files.client_ca.empty() ? GRPC_SSL_DONT_REQUEST_CLIENT_CERTIFICATE
                                : GRPC_SSL_REQUEST_AND_REQUIRE_CLIENT_CERTIFICATE_AND_VERIFY,
        &FileCredentials::Fetch, this);
    credentials_ = grpc_ssl_server_credentials_create_with_options(options);
  }
  ~FileCredentials() override { grpc_server_credentials_release(credentials_); }

  void SetAuthMetadataProcessor(const std::shared_ptr<grpc::AuthMetadataProcessor>&) override {}

  void Look(absl::Time now) override {
    const MutexLock lock(mutex_);
    if (now - looked_ < kBetweenReadings && now >= looked_) return;
    looked_ = now;
    ReadAgainIfChanged();
    if (next_.has_value() && MayReplace(*next_, now)) UseNext();
    own_.Look(now);
    clients_.Look(now);
  }

  static std::array<FileStamp, 3> Stamps(const TlsFiles& files) {
    return {StampOf(files.certificate), StampOf(files.key), StampOf(files.client_ca)};
  }

 private:
  int AddPortToServer(const std::string& address, grpc_server* server) override {
    return grpc_server_add_http2_port(server, address.c_str(), credentials_);
  }

  // gRPC calls it when it starts to listen and at every new connection.
  static grpc_ssl_certificate_config_reload_status Fetch(void* self,
                                                         grpc_ssl_server_certificate_config** out) {
    return static_cast<FileCredentials*>(self)->Refresh(out);
  }

  grpc_ssl_certificate_config_reload_status Refresh(grpc_ssl_server_certificate_config** out) {
    const MutexLock lock(mutex_);
    ReadAgainIfChanged();
    if (std::exchange(fetched_, true)) return GRPC_SSL_CERTIFICATE_CONFIG_RELOAD_UNCHANGED;
    const grpc_ssl_pem_key_cert_pair pair = {material_.key.c_str(), material_.certificate.c_str()};
    *out = grpc_ssl_server_certificate_config_create(
        // gRPC requires roots even if it requests no client certificate.
        (files_.client_ca.empty() ? material_.certificate : material_.client_ca).c_str(), &pair, 1);
    return GRPC_SSL_CERTIFICATE_CONFIG_RELOAD_NEW;
  }

  void ReadAgainIfChanged() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    // Before the reading: a change during it is noticed the next time.
    const std::array<FileStamp, 3> stamps = Stamps(files_);
    if (stamps == stamps_) return;
    stamps_ = stamps;
    absl::StatusOr<Material> read = ReadMaterial(files_);
    next_.reset();
    if (!read.ok()) {
      Log(LogLevel::kError, "tls_reload_failed",
          {{"error", read.status().message()}, {"message", "the former certificate stays"}});
      return;
    }
    next_ = *std::move(read);
    if (const absl::Time now = absl::Now(); MayReplace(*next_, now)) {
      UseNext();
    } else {
      TellRefused(*next_, now);
    }
  }

  // False: a certificate that is in use is valid, and the one in its place is not. Each new
  // connection would fail.
  bool MayReplace(const Material& next, absl::Time now) const
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    const auto may = [now](const std::string& old_pem, const std::string& new_pem) {
      return ValidityOf(new_pem).Contains(now) || !ValidityOf(old_pem).Contains(now);
    };
    return may(material_.certificate, next.certificate) &&
           (files_.client_ca.empty() || may(material_.client_ca, next.client_ca));
  }

  void TellRefused(const Material& next, absl::Time now) const {
    for (const auto& [file, pem] : {std::pair{&files_.certificate, &next.certificate},
                                    std::pair{&files_.client_ca, &next.client_ca}}) {
      const Validity validity = ValidityOf(*pem);
      if (!validity.Contains(now)) CertificateWatch::TellRefused(*file, validity, now);
    }
  }

  void UseNext() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    Log(LogLevel::kInfo, "tls_reloaded", {{"certificate", files_.certificate}});
    Use(*std::exchange(next_, std::nullopt));
  }

  void Use(Material material) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    material_ = std::move(material);
    fetched_ = false;
    own_.Use(files_.certificate, ValidityOf(material_.certificate));
    own_.Look(absl::Now());
    if (files_.client_ca.empty()) return;
    clients_.Use(files_.client_ca, ValidityOf(material_.client_ca));
    clients_.Look(absl::Now());
  }

  const TlsFiles files_;
  grpc_server_credentials* credentials_ = nullptr;
  Mutex mutex_;
  CertificateWatch own_ ABSL_GUARDED_BY(mutex_);
  CertificateWatch clients_ ABSL_GUARDED_BY(mutex_);
  absl::Time looked_ ABSL_GUARDED_BY(mutex_) = absl::InfinitePast();
  std::array<FileStamp, 3> stamps_ ABSL_GUARDED_BY(mutex_);
  Material material_ ABSL_GUARDED_BY(mutex_);  // in use
  // In the files, but not valid while that is.
  std::optional<Material> next_ ABSL_GUARDED_BY(mutex_);
  bool fetched_ ABSL_GUARDED_BY(mutex_) = false;  // gRPC has the content of material_
};

}  // namespace

absl::StatusOr<std::shared_ptr<TlsCredentials>> MakeTlsCredentials(const TlsFiles& files) {
  const std::array<FileStamp, 3> stamps = FileCredentials::Stamps(files);
  absl::StatusOr<Material> material = ReadMaterial(files);
  if (!material.ok()) return material.status();
  return std::make_shared<FileCredentials>(files, stamps, *std::move(material));
}

absl::StatusOr<absl::Time> EndOfCertificate(const std::string& file) {
  const absl::StatusOr<std::string> pem = ReadSmallFile("tls-cert", file);
  if (!pem.ok()) return pem.status();
  const Owned<X509> leaf(PEM_read_bio_X509(Open(*pem).get(), nullptr, &NoPassword, nullptr));
  const absl::Time end =
      leaf == nullptr ? absl::InfiniteFuture() : TimeOf(X509_get0_notAfter(leaf.get()));
  if (end == absl::InfiniteFuture()) return Bad("tls-cert", file, "holds no PEM certificate");
  return end;
}

}  // namespace dynmesh::server
