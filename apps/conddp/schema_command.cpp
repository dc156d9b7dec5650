#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "base/wrap_text.hpp"
#include "commands.hpp"
#include "embedded_schemas.hpp"
#include "exit_codes.hpp"
#include "streams.hpp"
#include "terminal.hpp"

namespace conddp {
namespace {

int print_schema(const std::string& kind) {
  if (const EmbeddedSchema* schema = find_schema(kind)) {
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

void add_schema_command(CLI::App& app, Command& chosen) {
  CLI::App* command =
      app.add_subcommand("schema", "Print the JSON Schema (draft-07) of a kind of file");
  command->footer("Without a kind: all kinds, a line each.");
  const auto kind = std::make_shared<std::string>();
  std::vector<std::string> kinds;
  for (const EmbeddedSchema& schema : embedded_schemas()) kinds.emplace_back(schema.kind);
  command->add_option("KIND", *kind, "The kind")->type_name("KIND")->check(CLI::IsMember(kinds));
  command->callback([kind, &chosen] { chosen = [kind] { return print_schema(*kind); }; });
}

}  // namespace conddp
