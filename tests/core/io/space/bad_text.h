// Files that must be refused, with the line that the message must name.
#ifndef DYNMESH_TESTS_CORE_IO_SPACE_BAD_TEXT_H_
#define DYNMESH_TESTS_CORE_IO_SPACE_BAD_TEXT_H_

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/text.h"
#include "core/io/common/file_features.h"

namespace dynmesh::testing {

struct BadText {
  std::string text;
  int line;             // that the message must name
  const char* message;  // a required part of it
};

inline void ExpectRefused(const std::vector<BadText>& texts, const std::string& name,
                          absl::StatusOr<io::FileFeatures> (*read)(const std::string&)) {
  for (const BadText& bad : texts) {
    const absl::Status status = read(bad.text).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << bad.text;
    const std::string message(status.message());
    EXPECT_TRUE(message.starts_with(text::Concat(name, ":", bad.line, ": "))) << bad.text << "\n"
                                                                              << message;
    EXPECT_NE(message.find(bad.message), std::string::npos) << bad.text << "\n" << message;
  }
}

}  // namespace dynmesh::testing

#endif  // DYNMESH_TESTS_CORE_IO_SPACE_BAD_TEXT_H_
