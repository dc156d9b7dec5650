#include <algorithm>

#include <fmt/format.h>

#include "base/text/text_layout.hpp"
#include "commands/commands.hpp"
#include "help/catalogue_lists.hpp"
#include "terminal/exit_codes.hpp"
#include "terminal/streams.hpp"
#include "terminal/terminal.hpp"

namespace conddp {
namespace {

std::string words(const OrderedJson& value) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_boolean()) return value ? "yes" : "no";
  if (value.is_null()) return "none";
  if (value.is_number()) return fmt::format("{}", value.get<double>());
  if (!value.is_array()) return value.dump();
  std::string text;
  for (const OrderedJson& item : value) text += (text.empty() ? "" : ", ") + words(item);
  return text;
}

/// Fields with columns of their own, or meant only for programs.
constexpr std::string_view kUnsaid[] = {"name",   "description", "keys",
                                        "schema", "places",      "needs_keys"};

/// Further facts of an entry, for example "at least 0, default 100".
std::string facts(const OrderedJson& entry) {
  std::string text;
  for (const auto& [field, value] : entry.items()) {
    if (std::find(std::begin(kUnsaid), std::end(kUnsaid), field) != std::end(kUnsaid)) continue;
    std::string name = field;
    std::replace(name.begin(), name.end(), '_', ' ');
    if (field == "required") {
      if (value) text += (text.empty() ? "" : "; ") + name;
      continue;
    }
    text += fmt::format("{}{}: {}", text.empty() ? "" : "; ", name, words(value));
  }
  return text;
}

/// An entry on one line, or wrapped to the terminal: the name, then the description in a column.
std::string entry_text(const OrderedJson& entry, int indent, int column, int width) {
  std::string text =
      fmt::format("{:<{}}", entry.at("name").get<std::string>(), column - indent - 1);
  text += " " + entry.at("description").get<std::string>();
  if (text.ends_with('.')) text.pop_back();
  if (const std::string more = facts(entry); !more.empty()) text += " (" + more + ")";
  return wrap_text(text, width, indent, width > 0 ? std::min(column, width / 2) : column);
}

std::string kind_text(const ListKind& kind, int width) {
  const OrderedJson entries = kind.entries();
  std::size_t longest = 0;
  for (const OrderedJson& entry : entries)
    longest = std::max(longest, entry.at("name").get<std::string>().size());
  const int column = static_cast<int>(longest) + 4;
  std::string text = wrap_text(fmt::format("{} ({})", kind.name, kind.description), width, 0, 2);
  if (entries.empty()) text += "  none here\n";
  for (const OrderedJson& entry : entries) {
    text += entry_text(entry, 2, column, width);
    if (entry.contains("keys"))
      for (const OrderedJson& key : entry["keys"]) text += entry_text(key, 6, column + 8, width);
  }
  return text;
}

int list(const std::string& chosen_kind, bool json) {
  OrderedJson object = OrderedJson::object();
  const int width = terminal_of(1).message_width();
  bool first = true;
  for (const ListKind& kind : list_kinds()) {
    if (!chosen_kind.empty() && kind.name != chosen_kind) continue;
    if (json)
      object[std::string(kind.name)] = kind.entries();
    else
      print_result((first ? "" : "\n") + kind_text(kind, width));
    first = false;
  }
  if (json) print_result(json_text(object));
  return kExitConverged;
}

}  // namespace

Command list_command() {
  const auto kind = std::make_shared<std::string>();
  const auto json = std::make_shared<bool>(false);
  std::vector<std::string> kinds;
  for (const ListKind& known : list_kinds()) kinds.emplace_back(known.name);
  return {.name = "conddp list",
          .description = "List what a problem file can name, and the example problems",
          .details = "Without a kind: everything.",
          .arguments = {{.names = {"KIND"},
                         .value = "KIND",
                         .description = "The kind",
                         .choices = std::move(kinds),
                         .target = kind.get()},
                        flag({"--json"}, *json, "Print JSON (conddp schema list)")},
          .run = [kind, json] { return list(*kind, *json); }};
}

}  // namespace conddp
