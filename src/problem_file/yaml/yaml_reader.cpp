#include "problem_file/yaml/yaml_reader.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <unordered_set>

#include <fmt/format.h>

#include "base/text/spelling.hpp"
#include "base/text/strict_number.hpp"

namespace conddp {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
const NumberRange kAnyNumber{-kInfinity, kInfinity, false, false, "a number"};
const NumberRange kPositive{0, kInfinity, true, false, "a positive number"};
const NumberRange kNotNegative{0, kInfinity, false, false, "a number that is not negative"};

void YamlReader::error(std::string message, std::string hint) const {
  out_->error(place(), std::move(message), std::move(hint));
}

void YamlReader::expected(std::string_view what, std::string hint) const {
  std::string found(kind_name(*node_));
  if (is_scalar()) {
    constexpr std::size_t kShown = 40;
    const std::string text =
        node_->text.substr(0, kShown) + (node_->text.size() > kShown ? "..." : "");
    found = is_number() ? text : fmt::format("{} ('{}')", found, text);
  }
  error(fmt::format("{} is expected here, not {}", what, found), std::move(hint));
}

bool YamlReader::is_number() const {
  return is_scalar() && !node_->quoted && parse_number(node_->text).value;
}

/// Hint for a nonnumeric text that may be an expression.
static std::string formula_hint(const std::string& text) {
  const bool formula = text.find_first_of("+*/^(") != text.npos || text.find("pi") != text.npos;
  return formula && !text.starts_with('=')
             ? fmt::format("in a problem file a value that begins with '=' is an expression: '={}'",
                           text)
             : "";
}

/// Hint for a quoted text in place of a number.
static std::string hint_without_quotes(const std::string& text) {
  if (parse_number(text).value) return "leave the quotes out";
  std::string with_point = text;
  std::replace(with_point.begin(), with_point.end(), ',', '.');
  return parse_number(with_point).value ? "the decimal sign is a point: " + with_point
                                        : formula_hint(text);
}

std::optional<double> YamlReader::number(const NumberRange& range) const {
  if (!is_scalar()) return expected(range.words), std::nullopt;
  if (node_->quoted) return expected(range.words, hint_without_quotes(node_->text)), std::nullopt;
  const ParsedNumber parsed = parse_number(node_->text);
  if (!parsed.value) {
    error(fmt::format("{} is expected here, and {}", range.words, parsed.defect),
          formula_hint(node_->text));
    return std::nullopt;
  }
  if (std::fpclassify(*parsed.value) == FP_SUBNORMAL) {
    error(fmt::format("{} is expected here, and '{}' is out of range", range.words, node_->text),
          "0 and numbers from 2.3e-308 on are in it");
    return std::nullopt;
  }
  if (!range.contains(*parsed.value)) return expected(range.words), std::nullopt;
  return parsed.value;
}

namespace {

/// "a whole number from 1 to 10".
std::string whole_number(long long lower, long long upper) {
  if (upper == std::numeric_limits<int>::max() || upper == std::numeric_limits<long long>::max())
    return fmt::format("a whole number of at least {}", lower);
  return fmt::format("a whole number from {} to {}", lower, upper);
}

/// The value of digits with an optional sign; empty for any other text.
std::optional<long long> parse_integer(const std::string& text) {
  const char* begin = text.data() + (text.starts_with('+') ? 1 : 0);
  const char* end = text.data() + text.size();
  long long value = 0;
  const auto [stop, code] = std::from_chars(begin, end, value);
  if (code != std::errc() || stop != end) return std::nullopt;
  return value;
}

std::string list_of(const std::vector<std::string>& words) {
  std::string list;
  for (const std::string& word : words) list += (list.empty() ? "" : ", ") + word;
  return list;
}

}  // namespace

std::optional<long long> YamlReader::integer(long long lower, long long upper) const {
  const std::string what = whole_number(lower, upper);
  if (!is_scalar()) return expected(what), std::nullopt;
  if (node_->quoted) return expected(what, hint_without_quotes(node_->text)), std::nullopt;
  if (const ParsedNumber parsed = parse_number(node_->text); !parsed.value) {
    error(fmt::format("{} is expected here, and {}", what, parsed.defect));
    return std::nullopt;
  }
  const auto value = parse_integer(node_->text);
  if (!value || *value < lower || *value > upper) return expected(what), std::nullopt;
  return value;
}

std::optional<std::string> YamlReader::text() const {
  if (!is_scalar() || node_->text.empty()) return expected("a text"), std::nullopt;
  return node_->text;
}

std::optional<Name> YamlReader::name() const {
  if (!is_scalar() || node_->text.empty()) return expected("a name"), std::nullopt;
  if (node_->text.find_first_of("\n\r\t") != std::string::npos)
    return error("a name has no line ends and no tabs"), std::nullopt;
  return Name{node_->text, place()};
}

std::optional<std::vector<YamlReader>> YamlReader::items(std::string_view hint) const {
  if (!is_sequence()) return expected("a list", std::string(hint)), std::nullopt;
  std::vector<YamlReader> readers;
  readers.reserve(node_->items.size());
  for (std::size_t i = 0; i < node_->items.size(); ++i)
    readers.emplace_back(node_->items[i], fmt::format("{}.{}", path_, i), *out_, folder_);
  return readers;
}

std::optional<std::vector<double>> YamlReader::numbers() const {
  const auto readers = items();
  if (!readers) return std::nullopt;
  std::vector<double> values;
  for (const YamlReader& item : *readers) {
    const auto value = item.number();
    if (!value) return std::nullopt;
    values.push_back(*value);
  }
  return values;
}

std::optional<std::vector<double>> YamlReader::numbers(std::size_t count,
                                                       std::string_view what) const {
  if (!is_sequence())
    return expected(fmt::format("a list of {}, {},", counted(count, "number"), what)), std::nullopt;
  if (node_->items.size() != count) {
    error(fmt::format("a list of {}, {}, is expected here; this one has {}",
                      counted(count, "number"), what, node_->items.size()));
    return std::nullopt;
  }
  return numbers();
}

std::optional<std::vector<Name>> YamlReader::names() const {
  const auto readers = items();
  if (!readers) return std::nullopt;
  std::vector<Name> values;
  std::unordered_set<std::string> known;
  for (const YamlReader& item : *readers) {
    const auto value = item.name();
    if (!value) return std::nullopt;
    if (!known.insert(value->value).second) {
      item.error(fmt::format("'{}' stands twice in the list", value->value));
      continue;
    }
    values.push_back(*value);
  }
  return values;
}

std::optional<std::vector<Name>> YamlReader::name_or_names() const {
  if (is_sequence()) return names();
  if (!is_scalar()) return expected("a name or a list of names"), std::nullopt;
  const auto single = name();
  if (!single) return std::nullopt;
  return std::vector<Name>{*single};
}

std::optional<std::size_t> YamlReader::choose(const std::vector<std::string>& words,
                                              std::string_view what,
                                              const std::vector<Synonyms>& more) const {
  if (is_scalar()) {
    const auto found = std::find(words.begin(), words.end(), node_->text);
    if (found != words.end()) return static_cast<std::size_t>(found - words.begin());
  }
  const std::string_view thing = what.substr(0, what.find(" ("));
  const std::string message =
      is_scalar() ? fmt::format("unknown {} '{}'{}", thing, node_->text, what.substr(thing.size()))
                  : fmt::format("{} is not a {}", kind_name(*node_), what);
  std::string hint = is_scalar() ? meaning_question(node_->text, words, more) : std::string();
  if (!hint.empty()) hint += ' ';
  out_->error(place(), message, hint + "accepted: " + list_of(words), words);
  return std::nullopt;
}

std::optional<std::vector<std::pair<Name, YamlReader>>> YamlReader::named_entries(
    std::string_view hint) const {
  if (!is_map()) return expected("a mapping from names to values", std::string(hint)), std::nullopt;
  std::vector<std::pair<Name, YamlReader>> entries;
  for (const YamlNode::Entry& entry : node_->entries) {
    const std::string path = path_.empty() ? entry.key : path_ + "." + entry.key;
    if (entry.key.empty()) {
      out_->error({entry.mark, path}, "a name is empty");
      continue;
    }
    entries.emplace_back(Name{entry.key, {entry.mark, path}},
                         YamlReader(entry.value, path, *out_, folder_));
  }
  return entries;
}

YamlMap::YamlMap(const YamlReader& reader, std::string_view hint)
    : reader_(reader), valid_(reader.is_map()) {
  if (!valid_) reader_.expected("a mapping", std::string(hint));
}

std::optional<YamlReader> YamlMap::find(std::string_view key) {
  if (std::find(known_.begin(), known_.end(), key) == known_.end()) known_.emplace_back(key);
  if (!valid_) return std::nullopt;
  const YamlNode* value = reader_.node().find(key);
  if (value == nullptr) return std::nullopt;
  std::string path = reader_.place().path;
  if (!path.empty()) path += '.';
  path += key;
  return reader_.at(*value, std::move(path));
}

std::optional<YamlReader> YamlMap::require(std::string_view key) {
  auto value = find(key);
  if (!value && valid_) {
    const Place place = reader_.place();
    reader_.error(place.path.empty() ? fmt::format("the key '{}' is missing", key)
                                     : fmt::format("'{}' lacks the key '{}'", place.path, key));
  }
  return value;
}

bool YamlMap::exclusive(std::initializer_list<std::string_view> keys) {
  std::vector<std::string> given;
  Place place;
  for (const YamlNode::Entry& entry : reader_.node().entries)
    if (valid_ && std::find(keys.begin(), keys.end(), entry.key) != keys.end()) {
      given.push_back(entry.key);
      place = {entry.mark, reader_.place().path};
    }
  if (given.size() < 2) return true;
  reader_.diagnostics().error(place, fmt::format("'{}' and '{}' exclude each other",
                                                 given[given.size() - 2], given.back()));
  return false;
}

bool YamlMap::integer(std::string_view key, int& value, int lower, int upper) {
  const auto reader = find(key);
  if (!reader) return false;
  const auto number = reader->integer(lower, upper);
  if (number) value = static_cast<int>(*number);
  return number.has_value();
}

void YamlMap::finish() {
  if (finished_ || !valid_) return;
  finished_ = true;
  for (const YamlNode::Entry& entry : reader_.node().entries) {
    if (std::find(known_.begin(), known_.end(), entry.key) != known_.end()) continue;
    if (reader_.diagnostics().error_count() >= Diagnostics::kMaxErrors) return;
    report_unknown(entry);
  }
}

/// Hint for a number under the name of a column or joint, written beside the keys that take such
/// names.
std::string YamlMap::hint_by_name(const YamlNode::Entry& entry) const {
  if (!YamlReader(entry.value, "", reader_.diagnostics()).is_number()) return "";
  std::string hint;
  for (const std::string_view key : {"values", "joints"})
    if (std::find(known_.begin(), known_.end(), key) != known_.end())
      hint += fmt::format("{}'{}: {{{}: {}}}'", hint.empty() ? "write " : " or ", key, entry.key,
                          entry.value.text);
  return hint.empty() ? "" : hint + "; ";
}

void YamlMap::report_unknown(const YamlNode::Entry& entry) const {
  const std::string path = reader_.place().path;
  std::string hint = meaning_question(entry.key, known_);
  if (hint.empty()) hint = hint_by_name(entry) + "accepted: " + list_of(known_);
  reader_.diagnostics().error({entry.mark, path.empty() ? entry.key : path + "." + entry.key},
                              path.empty()
                                  ? fmt::format("unknown key '{}'", entry.key)
                                  : fmt::format("unknown key '{}' in '{}'", entry.key, path),
                              hint, known_);
}

}  // namespace conddp
