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

// Reads `good` cut off and damaged at every byte. There must be an answer, and mostly an error;
// returns the number of errors.
inline int CountRefusalsOfDamage(const std::string& good,
                                 absl::StatusOr<io::FileFeatures> (*read)(const std::string&)) {
  int refused = 0;
  const auto check = [&](const std::string& text) {
    const absl::StatusOr<io::FileFeatures> input = read(text);
    if (input.ok()) {
      EXPECT_EQ(input->features.size(), input->lines.size());
    } else {
      EXPECT_FALSE(input.status().message().empty());
      ++refused;
    }
  };
  for (std::size_t i = 0; i < good.size(); ++i) {
    check(good.substr(0, i));
    for (const char c : {'9', '-', 'e', '/', '#', '\n', '\0', '\xff', ' '}) {
      std::string bad = good;
      bad[i] = c;
      check(bad);
    }
  }
  return refused;
}

}  // namespace dynmesh::testing

#endif  // DYNMESH_TESTS_CORE_IO_SPACE_BAD_TEXT_H_
