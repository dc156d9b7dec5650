#include "base/json/json_document.hpp"

#include <algorithm>
#include <array>
#include <set>

#include <nlohmann/json.hpp>

#include "base/files/text_file.hpp"

namespace conddp {
namespace {

using Json = nlohmann::json;
using Keys = std::span<const std::string_view>;

/// The mark of a byte of the text, or of the end of the text beyond it.
Mark mark_at(const std::string& text, std::size_t byte, int source, const Diagnostics& out) {
  const std::string_view before = std::string_view(text).substr(0, std::min(byte, text.size()));
  const std::size_t start = before.rfind('\n') + 1;  // npos + 1 is 0
  const int line = 1 + static_cast<int>(std::count(before.begin(), before.end(), '\n'));
  const int column = out.character_column(source, line, static_cast<int>(before.size() - start));
  return {source, line, column};
}

/// Filters a document while it is parsed: of the outermost object only the wanted members are kept.
class Sieve {
 public:
  explicit Sieve(Keys wanted) : wanted_keys_(wanted) {}

  bool keeps(int depth, Json::parse_event_t event, const Json& value) {
    if (depth > kMaxDepth) throw MalformedSolution{"it is nested too deeply"};
    switch (event) {
      case Json::parse_event_t::object_start:
        keys_[depth + 1].clear();
        return true;
      case Json::parse_event_t::value:
        if (wanted_) count();
        return true;
      case Json::parse_event_t::key:
        return keeps_key(depth, value.get_ref<const std::string&>());
      default:
        return true;
    }
  }

 private:
  static constexpr int kMaxDepth =
      100;  // a configuration is nested as deeply as a problem file may be
  static constexpr int kMaxValues =
      5'000'000;  // a document takes many times the memory of its text

  void count() {
    if (++values_ > kMaxValues)
      throw MalformedSolution{fmt::format("it has more than {} values", kMaxValues)};
  }
  bool keeps_key(int depth, const std::string& key) {
    if (!keys_[depth].insert(key).second)
      throw MalformedSolution{fmt::format("the key '{}' is given twice", key)};
    if (depth != 1) return true;
    wanted_ = wanted_keys_.empty() || key == "format" ||
              std::find(wanted_keys_.begin(), wanted_keys_.end(), key) != wanted_keys_.end();
    return wanted_;
  }

  Keys wanted_keys_;
  int values_ = 0;
  bool wanted_ =
      true;  ///< true if the values are kept; the callback also runs for discarded values
  std::array<std::set<std::string>, kMaxDepth + 2> keys_;  ///< of the open objects
};

/// Copies an object without the members that are not wanted, which are most of a solution: skipping
/// them is many times faster than parsing. Nothing if the text is not as conddp writes it.
class Excerpt {
 public:
  Excerpt(std::string_view text, Keys wanted) : text_(text), wanted_(wanted) {}

  std::optional<std::string> make() {
    std::string kept = "{";
    if (!take('{')) return std::nullopt;
    do {
      const std::size_t start = (skip_blanks(), at_);
      const auto key = skip_key();
      if (!key || !take(':') || !skip_value()) return std::nullopt;
      if (*key != "format" && std::ranges::find(wanted_, *key) == wanted_.end()) continue;
      if (kept.size() > 1) kept += ',';
      kept += text_.substr(start, at_ - start);
    } while (take(','));
    if (!take('}')) return std::nullopt;
    skip_blanks();
    if (at_ != text_.size()) return std::nullopt;
    return kept + '}';
  }

 private:
  char next() const { return at_ < text_.size() ? text_[at_] : '\0'; }
  void skip_blanks() { at_ = std::min(text_.find_first_not_of(" \t\r\n", at_), text_.size()); }
  bool take(char c) {
    skip_blanks();
    if (next() != c) return false;
    ++at_;
    return true;
  }
  std::optional<std::string_view> skip_key() {
    const std::size_t start = at_ + 1;
    if (next() != '"' || !skip_string()) return std::nullopt;
    return text_.substr(start, at_ - 1 - start);
  }
  bool skip_string() {
    for (++at_; at_ < text_.size(); ++at_) {
      if (text_[at_] == '\\')
        ++at_;
      else if (text_[at_] == '"')
        return ++at_, true;
    }
    return false;
  }
  /// To the comma or bracket behind a value, which is not examined.
  bool skip_value() {
    for (int depth = 0; at_ < text_.size();) switch (text_[at_]) {
        case '"':
          if (!skip_string()) return false;
          break;
        case '[':
        case '{':
          ++depth, ++at_;
          break;
        case ']':
        case '}':
          if (depth-- == 0) return true;
          ++at_;
          break;
        case ',':
          if (depth == 0) return true;
          [[fallthrough]];
        default:
          ++at_;
      }
    return false;
  }

  std::string_view text_;
  Keys wanted_;
  std::size_t at_ = 0;
};

Json parse_whole(const std::string& text, Keys wanted_keys) {
  Sieve sieve(wanted_keys);
  return Json::parse(text, [&](int depth, Json::parse_event_t event, Json& value) {
    return sieve.keeps(depth, event, value);
  });
}

/// Errors come from the whole text, so that their places are right.
Json parse(const std::string& text, Keys wanted_keys) {
  if (!wanted_keys.empty())
    if (const auto excerpt = Excerpt(text, wanted_keys).make()) try {
        return parse_whole(*excerpt, wanted_keys);
      } catch (const Json::exception&) {
      } catch (const MalformedSolution&) {
      }
  return parse_whole(text, wanted_keys);
}

/// The parser's message, without its internal codes: "... syntax error while parsing value - ...".
std::string reason(const Json::exception& e) {
  const std::string_view text = e.what();
  for (const std::string_view start : {"syntax error ", "] "})
    if (const std::size_t at = text.find(start); at != text.npos)
      return std::string(text.substr(at + start.size()));
  return std::string(text);
}

/// Joins the names of several kinds: "solution or closed loop".
std::string words_of(std::span<const DocumentKind> kinds) {
  std::string words;
  for (const DocumentKind& kind : kinds)
    words += (words.empty() ? "" : " or ") + std::string(kind.word);
  return words;
}

void check_format(const Json& document, std::span<const DocumentKind> kinds) {
  constexpr std::string_view kVersion = "1";
  solution_member(document, "format");
  const auto kind = std::find_if(kinds.begin(), kinds.end(),
                                 [&](const DocumentKind& k) { return is_of(k, document); });
  if (kind == kinds.end())
    throw MalformedSolution{fmt::format("it is not a {} of conddp", words_of(kinds))};
  if (const std::string version = document["format"].get<std::string>().substr(kind->family.size());
      version != kVersion)
    throw MalformedSolution{
        fmt::format("it has format {}, and this version reads format {}", version, kVersion)};
}

bool is_object(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  return first != text.npos && text[first] == '{';
}

/// Reads a document that may be of several kinds.
std::optional<Json> parse_kinds(const std::string& text, const std::string& name,
                                std::span<const DocumentKind> kinds, Keys keys, Diagnostics& out) {
  const auto source = [&] { return out.add_source(name, text); };
  try {
    Json document = parse(text, keys);
    check_format(document, kinds);
    return document;
  } catch (const Json::parse_error& e) {
    out.error({mark_at(text, e.byte > 0 ? e.byte - 1 : 0, source(), out), {}},
              "not valid JSON: " + reason(e),
              is_object(text)
                  ? ""
                  : fmt::format("a {} is expected, which begins with '{{'", words_of(kinds)));
  } catch (const MalformedSolution& e) {
    out.error({{source(), 0, 0}, {}},
              fmt::format("the {} cannot be used: {}", words_of(kinds), e.what()));
  } catch (const Json::out_of_range& e) {
    // The message is "number overflow parsing '1e999'"; we report the position of that number.
    const std::string_view what = e.what();
    const std::size_t open = std::min(what.find('\''), what.size());
    const std::string_view number =
        what.substr(open, what.rfind('\'') > open ? what.rfind('\'') - open : 0);
    const std::size_t byte = number.size() > 1 ? text.find(number.substr(1)) : 0;
    out.error({mark_at(text, byte, source(), out), {}},
              fmt::format("a number of the {} is out of range", words_of(kinds)));
  } catch (const Json::exception& e) {
    out.error({{source(), 0, 0}, {}},
              fmt::format("the {} cannot be used: {}", words_of(kinds), reason(e)));
  }
  return std::nullopt;
}

}  // namespace

bool is_of(const DocumentKind& kind, const Json& document) {
  const auto format = document.find("format");
  return format != document.end() && format->is_string() &&
         format->get_ref<const std::string&>().starts_with(kind.family);
}

std::optional<Json> parse_document(const std::string& text, const std::string& name,
                                   const DocumentKind& kind, Keys keys, Diagnostics& out) {
  return parse_kinds(text, name, {&kind, 1}, keys, out);
}

std::optional<Json> load_document(const std::filesystem::path& file, const DocumentKind& kind,
                                  Keys keys, const Place& place, Diagnostics& out) {
  return load_document(file, std::span(&kind, 1), keys, place, out);
}

std::optional<Json> load_document(const std::filesystem::path& file,
                                  std::span<const DocumentKind> kinds, Keys keys,
                                  const Place& place, Diagnostics& out) {
  TextFile read = read_text_file(file, kMaxDataBytes);
  if (!read.defect.empty()) {
    out.error(place, std::move(read.defect));
    return std::nullopt;
  }
  const auto text = checked_text(std::move(read.text), file.string(), out);
  if (!text) return std::nullopt;
  return parse_kinds(*text, file.string(), kinds, keys, out);
}

}  // namespace conddp
