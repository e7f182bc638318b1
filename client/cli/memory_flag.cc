#include "client/cli/memory_flag.h"

#include <charconv>
#include <cstdint>
#include <string_view>

#include "core/base/text.h"

namespace dynmesh::cli {

void AddMemoryFlag(CLI::App& command, std::string& text) {
  command
      .add_option("--max-memory", text,
                  "Give up when the command takes more memory, in bytes or as 500M or 4G (default: "
                  "three quarters of what the machine, its control groups and `ulimit -v` leave)")
      ->type_name("BYTES");
}

absl::StatusOr<MemoryBudget> ParseMemory(const std::string& text) {
  if (text.empty()) return MemoryBudget::OfWhatIsLeft();
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  const std::string unit(static_cast<const char*>(end), text.data() + text.size());
  constexpr std::string_view kUnits = "KMGT";
  const std::size_t power = unit.size() == 1 ? kUnits.find(unit[0]) : kUnits.npos;
  const bool is_unit = unit.empty() || power != kUnits.npos;
  for (std::size_t i = 0; is_unit && !unit.empty() && i <= power; ++i) number *= 1024;
  if (error != std::errc() || !is_unit || !(number >= 1) || !(number < 1e18)) {
    return absl::InvalidArgumentError(text::Concat(
        "--max-memory: expected a number of bytes such as 4000000000, 500M or 4G, found ",
        text::Quoted(text)));
  }
  return MemoryBudget(static_cast<std::uint64_t>(number));
}

}  // namespace dynmesh::cli
