#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "base/text/text_layout.hpp"
#include "commands/commands.hpp"
#include "help/embedded_schemas.hpp"
#include "problem_file/read/problem_schema.hpp"
#include "terminal/exit_codes.hpp"
#include "terminal/streams.hpp"
#include "terminal/terminal.hpp"

namespace conddp {
namespace {

int print_schema(const std::string& kind) {
  if (const EmbeddedSchema* schema = find_schema(kind)) {
    if (kind == "problem")
      print_result(schema_text(problem_schema()));
    else
      print_result(schema->text);
    return kExitConverged;
  }
  constexpr int kColumn = 14;
  for (const EmbeddedSchema& schema : embedded_schemas()) {
    const std::string description = nlohmann::json::parse(schema.text).at("description");
    print_result(wrap_text(fmt::format("{:<{}}{}", schema.kind, kColumn, description),
                           terminal_of(1).message_width(), 0, kColumn));
  }
  return kExitConverged;
}

}  // namespace

Command schema_command() {
  const auto kind = std::make_shared<std::string>();
  std::vector<std::string> kinds;
  for (const EmbeddedSchema& schema : embedded_schemas()) kinds.emplace_back(schema.kind);
  return {.name = "conddp schema",
          .description = "Print the JSON Schema (draft-07) of a kind of file",
          .details = "Without a kind: all kinds, a line each.",
          .arguments = {{.names = {"KIND"},
                         .value = "KIND",
                         .description = "The kind",
                         .choices = std::move(kinds),
                         .target = kind.get()}},
          .run = [kind] { return print_schema(*kind); }};
}

}  // namespace conddp
