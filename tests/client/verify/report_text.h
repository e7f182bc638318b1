// The text of a report of `verify`, for assertions.
#ifndef DYNMESH_TESTS_CLIENT_VERIFY_REPORT_TEXT_H_
#define DYNMESH_TESTS_CLIENT_VERIFY_REPORT_TEXT_H_

#include <gtest/gtest.h>

#include <set>
#include <string>

#include "client/verify/verify.h"

namespace dynmesh::cli {

// A check that failed gives examples, another none.
inline std::set<std::string> FailedChecks(const VerifyReport& report) {
  std::set<std::string> names;
  for (const VerifyCheck& check : report.checks) {
    if (check.failures != 0) names.insert(check.name);
    EXPECT_EQ(check.failures == 0, check.examples.empty());
  }
  return names;
}

inline std::string Describe(const VerifyReport& report) {
  std::string text;
  for (const VerifyCheck& check : report.checks) {
    for (const std::string& example : check.examples) text += check.name + ": " + example + "\n";
  }
  return text;
}

}  // namespace dynmesh::cli

#endif  // DYNMESH_TESTS_CLIENT_VERIFY_REPORT_TEXT_H_
