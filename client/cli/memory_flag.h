// --max-memory: how much memory a command may take.
#ifndef DYNMESH_CLIENT_CLI_MEMORY_FLAG_H_
#define DYNMESH_CLIENT_CLI_MEMORY_FLAG_H_

#include <string>

#include "CLI/CLI.hpp"
#include "absl/status/statusor.h"
#include "core/base/memory_budget.h"

namespace dynmesh::cli {

void AddMemoryFlag(CLI::App& command, std::string& text);

// A number of bytes, or one with K, M, G or T (powers of 1024). Empty: OfWhatIsLeft.
// INVALID_ARGUMENT for other texts.
absl::StatusOr<MemoryBudget> ParseMemory(const std::string& text);

inline constexpr char kMemoryAdvice[] = "--max-memory allows more";

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_CLI_MEMORY_FLAG_H_
