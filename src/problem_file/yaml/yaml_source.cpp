#include "problem_file/yaml/yaml_source.hpp"

#include <algorithm>
#include <charconv>
#include <set>
#include <sstream>
#include <utility>

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

#include "base/text/utf8.hpp"
#include "problem_file/yaml/yaml_closing.hpp"

namespace conddp {
namespace {

constexpr int kMaxDepth = 64;
constexpr std::string_view kNoAliases = "aliases (*name) are not accepted";
constexpr std::string_view kWriteOut = "write the value out where it is needed";

/// Ends the parse after the reason has been reported.
struct Refused : std::exception {
  const char* what() const noexcept override { return "a reported error of the document"; }
};

/// A text for yaml-cpp, with the positions where it is shorter than the file.
struct EscapedText {
  static constexpr int kShorter = 2;  ///< bytes
  std::string text;
  std::vector<std::size_t> shorter;  ///< last byte of each shortened character
};

/// The surrogate escape at a position, such as "\\uD83D", minus `first`.
std::optional<unsigned> surrogate_at(std::string_view text, std::size_t at, unsigned first) {
  unsigned value = 0;
  if (text.size() < at + 6 || text[at] != '\\' || text[at + 1] != 'u') return std::nullopt;
  const char* end = text.data() + at + 6;
  const auto [stop, error] = std::from_chars(end - 4, end, value, 16);
  if (error != std::errc() || stop != end || value < first || value >= first + 0x400)
    return std::nullopt;
  return value - first;
}

/// JSON escapes a character beyond 16 bits with two surrogates, YAML with one number.
EscapedText without_surrogates(const std::string& text) {
  EscapedText result;
  bool quoted = false;
  for (std::size_t at = 0; at < text.size(); ++at) {
    const auto high = quoted ? surrogate_at(text, at, 0xD800) : std::nullopt;
    const auto low = high ? surrogate_at(text, at + 6, 0xDC00) : std::nullopt;
    if (low) {
      result.text += fmt::format("\\U{:08X}", 0x10000 + *high * 0x400 + *low);
      result.shorter.push_back(result.text.size() - 1);
      at += 11;
      continue;
    }
    if (text[at] == '"') quoted = !quoted;
    result.text += text[at];
    if (quoted && text[at] == '\\' && at + 1 < text.size()) result.text += text[++at];
  }
  return result;
}

/// Builds the tree from yaml-cpp's events. Aliases are rejected before anything expands them, and
/// deep nesting before anything recurses into it.
class TreeBuilder : public YAML::EventHandler {
 public:
  TreeBuilder(const EscapedText& text, int source, int shift, Diagnostics& out)
      : text_(text.text), shorter_(text.shorter), source_(source), shift_(shift), out_(out) {}

  YamlNode root;

  Mark mark_of(const YAML::Mark& mark) {
    if (mark.is_null()) return {source_, 0, 0};
    return {source_, mark.line + 1, column_of(mark.line + 1, mark.column + shift_ + lost(mark))};
  }
  [[noreturn]] void refuse(const YAML::Mark& mark, std::string message, std::string hint) {
    out_.error({mark_of(mark), {}}, std::move(message), std::move(hint));
    throw Refused{};
  }

  static std::size_t offset(const YAML::Mark& mark) {
    return mark.is_null() ? std::string_view::npos : static_cast<std::size_t>(mark.pos);
  }

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override {
    refuse(mark, std::string(kNoAliases), std::string(kWriteOut));
  }
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    check(mark, "?", anchor);
    place({.kind = YamlNode::Kind::kNull, .mark = mark_of(mark)}, mark);
  }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
    check(mark, tag, anchor);
    if (tag == "!" && quote_end(text_, offset(mark)) == text_.npos)
      refuse(mark, "a quoted text is never closed", {});
    if (const std::size_t bad = find_bad_character(value); bad != std::string::npos)
      refuse(mark, "a quoted text with escapes: " + describe_bad_character(value, bad), {});
    place({.kind = YamlNode::Kind::kScalar,
           .mark = mark_of(mark),
           .text = value,
           .quoted = tag == "!"},
          mark);
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    check(mark, tag, anchor);
    open({.kind = YamlNode::Kind::kSequence, .mark = mark_of(mark)}, mark);
  }
  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    check(mark, tag, anchor);
    open({.kind = YamlNode::Kind::kMap, .mark = mark_of(mark)}, mark);
  }
  void OnSequenceEnd() override { close(); }
  void OnMapEnd() override { close(); }

 private:
  /// Bytes that the line lacks before a mark.
  int lost(const YAML::Mark& mark) const {
    const auto begin = std::ranges::lower_bound(shorter_, offset(mark) - mark.column);
    const auto end = std::ranges::lower_bound(shorter_, offset(mark));
    return EscapedText::kShorter * static_cast<int>(end - begin);
  }
  /// Character index (0-based) of a byte in a line. Marks mostly come in order, so counting
  /// continues from the previous mark: a line may be as long as the file.
  int column_of(int line, int byte) {
    const std::string_view text = out_.line(source_, line);
    byte = std::clamp(byte, 0, static_cast<int>(text.size()));
    if (line != counted_line_ || byte < counted_bytes_) {
      counted_line_ = line;
      counted_bytes_ = counted_characters_ = 0;
    }
    counted_characters_ += count_characters(text.substr(counted_bytes_, byte - counted_bytes_));
    counted_bytes_ = byte;
    return counted_characters_ + 1;
  }
  struct Level {
    YamlNode node;
    bool has_key = false;
    std::set<std::string> keys;
  };

  void check(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor) {
    if (anchor != 0) refuse(mark, "anchors (&name) are not accepted", std::string(kWriteOut));
    if (!tag.empty() && tag != "?" && tag != "!")
      refuse(mark, fmt::format("the tag '{}' is not accepted", tag), "leave the tag out");
  }
  void place(YamlNode node, const YAML::Mark& mark) {
    if (levels_.empty()) {
      root = std::move(node);
      return;
    }
    Level& level = levels_.back();
    if (level.node.kind == YamlNode::Kind::kSequence) {
      level.node.items.push_back(std::move(node));
    } else if (level.has_key) {
      YamlNode::Entry& entry = level.node.entries.back();
      if (node.kind == YamlNode::Kind::kNull) node.mark = entry.mark;  // no text to point at
      entry.value = std::move(node);
      level.has_key = false;
    } else {
      begin_entry(level, std::move(node), mark);
    }
  }
  [[noreturn]] void refuse_key(const YamlNode& node, const YAML::Mark& mark) {
    const std::size_t at = offset(mark);
    const char first = at < text_.size() ? text_[at] : ' ';
    if ((first == '[' || first == '{') && !bracket_closes(text_, at))
      refuse(mark, fmt::format("this '{}' is never closed", first), {});
    refuse(mark, fmt::format("a key must be a name, not {}", kind_name(node)), {});
  }
  void begin_entry(Level& level, YamlNode key, const YAML::Mark& mark) {
    if (key.kind != YamlNode::Kind::kScalar) refuse_key(key, mark);
    if (key.text.find_first_of("\n\r\t") != std::string::npos)
      refuse(mark, "a key has no line ends and no tabs", {});
    if (key.text == "<<" && !key.quoted)
      refuse(mark, "merge keys (<<) are not accepted", "write the keys out where they are needed");
    if (!level.keys.insert(key.text).second)
      refuse(
          mark, fmt::format("the key '{}' is given twice", key.text),
          fmt::format("its first value stands on line {}", level.node.find(key.text)->mark.line));
    level.node.entries.push_back({std::move(key.text), key.mark, {}});
    level.has_key = true;
  }
  void open(YamlNode node, const YAML::Mark& mark) {
    if (levels_.size() >= kMaxDepth)
      refuse(mark, fmt::format("the nesting is deeper than {} levels", kMaxDepth), {});
    if (!levels_.empty() && levels_.back().node.kind == YamlNode::Kind::kMap &&
        !levels_.back().has_key)
      refuse_key(node, mark);
    levels_.push_back({std::move(node), false, {}});
  }
  void close() {
    YamlNode node = std::move(levels_.back().node);
    levels_.pop_back();
    place(std::move(node), {});
  }

  std::string_view text_;
  const std::vector<std::size_t>& shorter_;
  int source_;
  int shift_;
  Diagnostics& out_;
  std::vector<Level> levels_;
  int counted_line_ = 0;
  int counted_bytes_ = 0;
  int counted_characters_ = 0;
};

/// Rephrases a few frequent messages of yaml-cpp, which are terse.
std::string_view in_words(std::string_view message) {
  static constexpr std::pair<std::string_view, std::string_view> kWords[] = {
      {"end of map not found", "this line does not continue the mapping above"},
      {"end of sequence not found", "this line does not continue the list above"},
      {"end of sequence flow not found", "a list '[...' is not closed by ']'"},
      {"end of map flow not found", "a mapping '{...' is not closed by '}'"},
      {"illegal flow end", "a ']' or '}' that closes nothing open here"},
      {"unknown token", "nothing starts with this character: quote the text"},
      {"illegal map value", "a ':' where no value can start"}};
  for (const auto& [terse, words] : kWords)
    if (message == terse) return words;
  return message;
}

void report(const YAML::Exception& e, const Mark& mark, Diagnostics& out) {
  if (e.msg.starts_with("the referenced anchor is not defined"))
    return out.error({mark, {}}, std::string(kNoAliases), std::string(kWriteOut));
  const std::string_view line = mark.line > 0 ? out.line(mark.source, mark.line) : "";
  const bool tab = line.substr(0, line.find_first_not_of(" \t")).find('\t') != line.npos;
  std::string hint;
  if (tab)
    hint = "the line begins with a tab: YAML is indented by spaces";
  else if (e.msg == "end of map flow not found" && line.find('[') != line.npos)
    hint = "inside { } an expression with brackets needs quotes: \"q[knee] - 1\"";
  out.error({mark, {}}, fmt::format("not valid YAML: {}", in_words(e.msg)), hint);
}

bool is_xml(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  return first != text.npos && text[first] == '<';
}

}  // namespace

std::optional<YamlNode> parse_yaml(const std::string& text, int source, Diagnostics& out, int shift,
                                   bool allow_null) {
  if (!allow_null && is_xml(text)) {
    out.error({{source, 1, 1}, {}}, "this is XML, not YAML",
              "a problem file names a robot as 'robot: {urdf: FILE}'; 'conddp inspect FILE' shows "
              "it");
    return std::nullopt;
  }
  const EscapedText escaped = without_surrogates(text);
  TreeBuilder builder(escaped, source, shift, out);
  try {
    std::istringstream stream(escaped.text);
    YAML::Parser parser(stream);
    const bool found = parser.HandleNextDocument(builder);
    if (builder.root.kind == YamlNode::Kind::kNull && allow_null)
      return YamlNode{.mark = {source, 1, out.character_column(source, 1, shift)}};
    if (!found || builder.root.kind == YamlNode::Kind::kNull) {
      out.error({{source, 1, 1}, {}}, "there is nothing in the document");
      return std::nullopt;
    }
    YamlNode root = std::move(builder.root);
    // Call only once: the parser reports documents endlessly on some input.
    TreeBuilder rest(escaped, source, shift, out);
    if (parser.HandleNextDocument(rest)) {
      out.error({rest.root.mark.line > 0 ? rest.root.mark : root.mark, {}},
                "something follows the end of the document", "a problem file is one document");
      return std::nullopt;
    }
    return root;
  } catch (const Refused&) {
  } catch (const YAML::Exception& e) {
    report(e, builder.mark_of(e.mark), out);
  } catch (const std::exception& e) {
    out.error({{source, 1, 1}, {}}, fmt::format("not valid YAML: {}", e.what()));
  }
  return std::nullopt;
}

}  // namespace conddp
