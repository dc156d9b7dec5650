#include "command_doc.hpp"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace conddp {
namespace {

/// A type name is "NAME", then for each check ":{a,b}" (words) or another description.
void read_type(const std::string& type, OptionDoc& doc) {
  const std::size_t colon = type.find(':');
  doc.value = type.substr(0, colon);
  if (colon == type.npos) return;
  const std::string check = type.substr(colon + 1);
  if (!check.starts_with('{')) {
    doc.range = check.substr(std::min(check.find('['), check.size()));
    return;
  }
  const std::string words = check.substr(1, check.find('}') - 1);
  for (std::size_t start = 0; start <= words.size();) {
    const std::size_t end = std::min(words.find(',', start), words.size());
    doc.choices.push_back(words.substr(start, end - start));
    start = end + 1;
  }
}

}  // namespace

OptionDoc describe(const CLI::Option& option) {
  OptionDoc doc{.description = option.get_description(),
                .fallback = option.get_default_str(),
                .positional = option.get_positional(),
                .required = option.get_required()};
  for (const std::string& name : option.get_snames()) doc.names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) doc.names.push_back("--" + name);
  if (doc.positional) doc.names = {option.get_name()};
  if (option.get_items_expected_max() == 0) return doc;
  read_type(option.get_type_name(), doc);
  doc.repeatable = option.get_items_expected_max() > 1;
  doc.folder = doc.value == "FOLDER";
  for (std::size_t dot = doc.value.find('.'); dot != std::string::npos;) {
    const std::size_t next = doc.value.find('.', dot + 1);
    doc.suffixes.push_back(doc.value.substr(dot, next - dot));
    dot = next;
  }
  return doc;
}

std::string OptionDoc::heading() const {
  if (positional) {
    const std::string word = value + (repeatable ? "..." : "");
    return required ? word : fmt::format("[{}]", word);
  }
  return fmt::format("{}{}{}", fmt::join(names, ", "), value.empty() ? "" : " ", value);
}

std::string OptionDoc::explanation() const {
  std::string text = description;
  if (!choices.empty()) text += fmt::format(": {}", fmt::join(choices, ", "));
  if (!range.empty()) text += " " + range;
  if (!fallback.empty()) text += fmt::format(" (default: {})", fallback);
  if (repeatable && !positional) text += " (repeatable)";
  return text;
}

std::string CommandDoc::short_name() const { return name.substr(name.rfind(' ') + 1); }

std::string CommandDoc::usage() const {
  std::string text = name + " [OPTIONS]";
  if (!commands.empty()) text += " SUBCOMMAND";
  for (const OptionDoc& positional : positionals) text += " " + positional.heading();
  return text;
}

CommandDoc describe(const CLI::App& app) {
  CommandDoc doc{.name = app.get_name(), .description = app.get_description()};
  for (const CLI::App* up = app.get_parent(); up != nullptr; up = up->get_parent())
    doc.name = up->get_name() + " " + doc.name;
  doc.details = app.get_footer();
  for (const CLI::Option* option : app.get_options())
    (option->get_positional() ? doc.positionals : doc.options).push_back(describe(*option));
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
    doc.commands.push_back(describe(*command));
  return doc;
}

}  // namespace conddp
