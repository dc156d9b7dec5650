#include "problem_file/residuals/residual_keys.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "problem_file/model/expression_source.hpp"
#include "problem_file/model/spec.hpp"
#include "problem_file/residuals/residual_table.hpp"
#include "systems/expressions/lexer.hpp"

namespace conddp {

const ResidualKey& contacts_key() {
  static const ResidualKey contacts = [] {
    ResidualKey key = residual_key(
        key::contacts,
        {.says = "For residuals on contacts: one term per contact while it is held; by default all "
                 "contacts with the world, at the last node all of these that it holds"},
        ContactNamesForm{});
    key.complete = [](CostSpec& cost, const TermContext& context) {
      cost.keys.set(key::contacts, context.spec.named_in_term(cost.keys.value(key::contacts),
                                                              cost.where.last_node));
    };
    return key;
  }();
  return contacts;
}

namespace {

bool in_expressions(const CostSpec& cost) { return cost.definition->name == "expression"; }

/// A mapping of factors, or a list of mappings.
std::vector<NamedNumbers> read_factors(const YamlReader& reader) {
  std::vector<NamedNumbers> rows;
  if (reader.is_map()) {
    NamedNumbersForm().read(reader, rows.emplace_back());
    return rows;
  }
  const auto items = reader.items();
  if (!items) return rows;
  if (items->empty()) reader.error("there is no row", "write 'rows: [{theta: 1, omega: 0.5}]'");
  for (const YamlReader& item : *items) NamedNumbersForm().read(item, rows.emplace_back());
  return rows;
}

/// An expression, a list of expressions, or named expressions.
ExpressionRowsSpec read_texts(const YamlReader& reader) {
  ExpressionRowsSpec rows;
  const auto add = [&rows](const YamlReader& row) {
    if (auto text = read_expression(row)) rows.texts.push_back(*std::move(text));
  };
  constexpr std::string_view kHint = "write 'rows: [x^2 + y^2]' or 'rows: {radius: x^2 + y^2}'";
  if (reader.is_map()) {
    const auto entries = reader.named_entries(kHint);
    if (!entries) return rows;
    for (const auto& [name, row] : *entries) {
      rows.names.push_back(name.value);
      add(row);
    }
  } else if (reader.is_sequence()) {
    const auto items = reader.items(kHint);
    if (!items) return rows;
    for (const YamlReader& row : *items) add(row);
  } else {
    add(reader);
    return rows;
  }
  if (rows.texts.empty()) reader.error("there is no row", std::string(kHint));
  return rows;
}

/// True if a text names the previous control: `previous[force]`. The parser reports invalid
/// expressions.
bool names_previous_control(const ExpressionText& text) {
  try {
    ExpressionLexer lexer(text.text);
    while (lexer.next().kind != ExpressionToken::Kind::kEnd)
      if (lexer.take().is(kPreviousControl) && lexer.next().is("[")) return true;
  } catch (const ExpressionError&) {
    return false;
  }
  return false;
}

struct RowsForm {
  bool read(const YamlReader& reader, CostSpec& cost) const {
    if (!in_expressions(cost)) {
      cost.keys.set(key::combination_rows, read_factors(reader));
      return true;
    }
    ExpressionRowsSpec texts = read_texts(reader);
    cost.names_previous_control = std::ranges::any_of(texts.texts, names_previous_control);
    cost.keys.set(key::expression_rows, std::move(texts));
    return true;
  }
  std::optional<OrderedJson> expand(const CostSpec& cost) const {
    OrderedJson json = OrderedJson::array();
    if (!in_expressions(cost)) {
      for (const NamedNumbers& row : cost.keys.value(key::combination_rows))
        json.push_back(*NamedNumbersForm().expand(row));
      return json;
    }
    const ExpressionRowsSpec rows = cost.keys.value(key::expression_rows);
    if (!rows.names.empty()) json = OrderedJson::object();
    for (std::size_t i = 0; i < rows.texts.size(); ++i) {
      if (rows.names.empty())
        json.push_back(rows.texts[i].text);
      else
        json[rows.names[i]] = rows.texts[i].text;
    }
    return json;
  }
  OrderedJson schema(const CostSpec& /*of any residual*/, SchemaDefinitions& definitions) const {
    const OrderedJson factors = NamedNumbersForm().schema();
    const OrderedJson text = ExpressionForm().schema({}, definitions);
    return {{"anyOf",
             {factors,
              {{"type", "object"}, {"additionalProperties", text}},
              {{"type", "array"}, {"minItems", 1}, {"items", {{"anyOf", {factors, text}}}}},
              text}}};
  }
};

/// The residual of a term, by its name.
struct ResidualForm {
  bool read(const YamlReader& reader, CostSpec& cost) const {
    std::vector<std::string> words;
    std::vector<Synonyms> synonyms;
    for (const ResidualDefinition* definition : residual_table()) {
      words.emplace_back(definition->name);
      synonyms.push_back({definition->name, definition->synonyms});
    }
    const auto index = reader.choose(words, "residual", synonyms);
    if (!index) return false;
    cost.definition = residual_table()[*index];
    cost.residual = {words[*index], reader.place()};
    return true;
  }
  std::optional<OrderedJson> expand(const CostSpec& cost) const {
    return OrderedJson(cost.residual.value);
  }
  OrderedJson schema(const CostSpec& cost, SchemaDefinitions& /*definitions*/) const {
    OrderedJson names = OrderedJson::array();
    for (const ResidualDefinition* definition : residual_table())
      if (!cost.where.last_node || definition->at_last_node()) names.push_back(definition->name);
    return {{"enum", std::move(names)}};
  }
};

/// Reports a key that the residual does not have, with the residuals that have it and the
/// alternative of the others.
void report_unfit(const YamlReader& reader, const ResidualKey& key, const CostSpec& cost) {
  std::string hint;
  for (const ResidualDefinition* definition : residual_table())
    if (std::ranges::find(definition->keys, &key) != definition->keys.end())
      hint +=
          fmt::format("{}{}", hint.empty() ? "residuals that have it: " : ", ", definition->name);
  if (!key.traits.instead.empty()) hint += fmt::format("; {}", key.traits.instead);
  reader.error(fmt::format("the residual '{}' has no '{}'", cost.residual.value, key.info.name),
               std::move(hint));
}

/// Reads a key that only some residuals have.
void read_key(Keys& keys, const ResidualKey& key, CostSpec& cost) {
  YamlMap& map = *keys.reading();
  const auto& own = cost.definition->keys;
  const bool fits = std::ranges::find(own, &key) != own.end();
  KeyInfo info = key.info;
  info.required = fits && key.traits.required;
  if (fits || !key.traits.required) key.visit(keys, info, cost);
  const auto value = map.find(info.name);
  if (!value) return;
  if (!fits) report_unfit(*value, key, cost);
  if (!key.traits.excludes.empty()) map.exclusive({info.name, key.traits.excludes});
}

}  // namespace

const ResidualKey& rows_key() {
  static const ResidualKey rows = {
      {.name = "rows",
       .says = "For expression: an expression, a list of them, or expressions by name. For "
               "combination: one row, or a list of rows, of factors by column of the state (flat "
               "ones) or control; 'constant' is added",
       .examples = R"([["x^2 + (y - 1)^2"], {"power": "u[knee]*v[knee]"},
                       {"theta": 1, "omega": 0.5, "constant": -2},
                       [{"q/hip": 1, "q/knee": -1}, {"u/hip": 1}]])"},
      {.required = true},
      [](Keys& keys, const KeyInfo& info, CostSpec& cost) { keys(info, cost, RowsForm{}); }};
  return rows;
}

bool describe_residual(Keys& keys, CostSpec& cost, std::string_view says) {
  keys({.name = "residual", .says = says, .required = true}, cost, ResidualForm{});
  YamlMap* map = keys.reading();
  if (map != nullptr && cost.definition == nullptr) return map->ignore_others(), false;
  for (const ResidualKey* key :
       keys.documents() || map != nullptr ? residual_keys() : cost.definition->keys) {
    const bool stands = key->stands_in(cost.where);
    if (map != nullptr && stands)
      read_key(keys, *key, cost);
    else if (map == nullptr && (stands || !keys.documents()))
      key->visit(keys, key->info, cost);
  }
  return true;
}

bool is_excluded(std::string_view key, const CostSpec& cost) {
  return cost.definition != nullptr &&
         std::ranges::any_of(cost.definition->keys, [&](const ResidualKey* own) {
           return own->traits.excludes == key && cost.keys.has(own->info.name);
         });
}

void complete_residual(CostSpec& cost, const TermContext& context) {
  for (const ResidualKey* key : cost.definition->keys)
    if (key->complete != nullptr) key->complete(cost, context);
}

}  // namespace conddp
