// Certificates of a test, made by the `openssl` command in a folder of its own: no key is ever
// part of the sources.
#ifndef DYNMESH_TESTS_SUPPORT_CERTIFICATES_H_
#define DYNMESH_TESTS_SUPPORT_CERTIFICATES_H_

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>

#include "tests/support/temp_folder.h"

namespace dynmesh::test {

inline std::string ReadAll(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

// Atomic: complete or as before, as an operator should replace such a file.
inline void WriteAtOnce(const std::string& path, const std::string& text) {
  std::ofstream(path + ".new", std::ios::binary) << text;
  std::filesystem::rename(path + ".new", path);
}

class Certificates {
 public:
  std::string Path(const std::string& file) const { return folder_.path() + "/" + file; }
  std::string Certificate(const std::string& name) const { return ReadAll(Path(name + ".pem")); }
  std::string Key(const std::string& name) const { return ReadAll(Path(name + ".key")); }

  // NAME.pem and NAME.key, self-signed.
  void MakeAuthority(const std::string& name) {
    Run("openssl req -x509 " + NewKey(name) + " -days 2 -out " + name + ".pem");
  }
  // Signed by an authority, for 127.0.0.1; of `days` below zero it has expired.
  void Make(const std::string& name, const std::string& authority, int days = 2) {
    std::ofstream(Path("names")) << "subjectAltName=IP:127.0.0.1,DNS:localhost\n";
    Run("openssl req " + NewKey(name) + " -out " + name + ".csr");
    Run("openssl x509 -req -in " + name + ".csr -CA " + authority + ".pem -CAkey " + authority +
        ".key -CAcreateserial -days " + std::to_string(days) + " -extfile names -out " + name +
        ".pem");
  }

 private:
  static std::string NewKey(const std::string& name) {
    return "-newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -subj /CN=" + name +
           " -keyout " + name + ".key";
  }
  void Run(const std::string& command) {
    const std::string line = "cd " + folder_.path() + " && " + command + " 2>openssl.log";
    if (std::system(line.c_str()) != 0) {
      throw std::runtime_error(command + ": " + ReadAll(Path("openssl.log")));
    }
  }

  TempFolder folder_;
};

}  // namespace dynmesh::test

#endif  // DYNMESH_TESTS_SUPPORT_CERTIFICATES_H_
