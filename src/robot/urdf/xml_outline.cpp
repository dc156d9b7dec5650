#include "robot/urdf/xml_outline.hpp"

#include <algorithm>

namespace conddp {
namespace {

constexpr std::size_t kMaxAttributes = 64;
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

/// Part of a document that is skipped, from its opening to its end.
struct Skipped {
  std::string_view opening, end;
  const char* defect;
  bool inside_only;  ///< allowed only inside an element
};
constexpr Skipped kSkipped[] = {
    {"<!--", "-->", "a comment is never closed", false},
    {"<?", "?>", "a processing instruction is never closed", false},
    {"<![CDATA[", "]]>", "CDATA is never closed", true},
};

class Scanner {
 public:
  explicit Scanner(std::string_view text) : text_(text) {}

  XmlOutline run() {
    if (text_.substr(0, 3) == kByteOrderMark) at_ = 3;
    while (!outline_.defect && at_ < text_.size()) step();
    if (!outline_.defect && !open_.empty()) {
      const XmlElement& element = outline_.elements[open_.back()];
      fail(element.start_tag.data() - text_.data(),
           "<" + std::string(element.tag) + "> is never closed");
    }
    return std::move(outline_);
  }

 private:
  void step() {
    if (!pass_text() || at_ >= text_.size()) return;
    if (const Skipped* part = skipped_part()) return skip(*part);
    if (starts("<!")) return document_type();
    if (starts("</")) return end_tag();
    start_tag();
  }

  /// Advances to the next '<' or the end. Returns false on text outside the root element.
  bool pass_text() {
    const std::size_t start = at_;
    at_ = std::min(text_.find('<', at_), text_.size());
    if (!open_.empty()) return true;
    const std::size_t stray = text_.find_first_not_of(kXmlSpace, start);
    if (stray >= at_) return true;
    fail(stray, "text outside the document's root element");
    return false;
  }

  /// Kind of skipped part that begins here, or null.
  const Skipped* skipped_part() const {
    for (const Skipped& part : kSkipped)
      if (starts(part.opening) && !(part.inside_only && open_.empty())) return &part;
    return nullptr;
  }

  void document_type() {
    const std::size_t end = text_.find_first_of("[>", at_);
    if (!open_.empty() || end == text_.npos || text_[end] == '[')
      return fail(at_, "a document type declaration of its own is not accepted here");
    at_ = end + 1;
  }

  void end_tag() {
    const std::size_t begin = at_;
    at_ += 2;
    const std::string_view tag = word("> \t\r\n");
    skip_space();
    if (peek() != '>') return fail(begin, "</" + std::string(tag) + " lacks its '>'");
    ++at_;
    if (open_.empty()) return fail(begin, "</" + std::string(tag) + "> closes nothing");
    XmlElement& element = outline_.elements[open_.back()];
    if (element.tag != tag)
      return fail(begin, "</" + std::string(tag) + "> where <" + std::string(element.tag) +
                             "> of line " + std::to_string(element.line) + " is open");
    element.end_tag = text_.substr(begin, at_ - begin);
    open_.pop_back();
  }

  /// Reason why the element is not allowed here; empty if it is.
  std::string defect_of(const XmlElement& element) const {
    if (element.tag.empty()) return "'<' without an element's name";
    if (open_.empty() && !outline_.elements.empty())
      return "a second root element <" + std::string(element.tag) + ">";
    if (element.depth >= kMaxXmlDepth)
      return "elements are nested deeper than " + std::to_string(kMaxXmlDepth);
    if (outline_.elements.size() >= kMaxXmlElements)
      return "more than " + std::to_string(kMaxXmlElements) + " elements";
    return {};
  }

  void start_tag() {
    XmlElement element;
    const std::size_t begin = at_++;
    locate(begin, element.line, element.column);
    element.tag = word("/> \t\r\n<='\"");
    element.depth = static_cast<int>(open_.size());
    element.parent = open_.empty() ? -1 : open_.back();
    if (const std::string defect = defect_of(element); !defect.empty()) return fail(begin, defect);
    for (skip_space(); peek() != '>' && !starts("/>"); skip_space())
      if (!attribute(element)) return;
    const bool closed = peek() != '>';
    at_ += closed ? 2 : 1;
    element.start_tag = text_.substr(begin, at_ - begin);
    outline_.elements.push_back(std::move(element));
    if (!closed) open_.push_back(static_cast<int>(outline_.elements.size()) - 1);
  }

  bool attribute(XmlElement& element) {
    const std::size_t begin = at_;
    const std::string in = " in <" + std::string(element.tag) + ">";
    XmlAttribute attribute;
    attribute.name = word("=/> \t\r\n<'\"");
    if (attribute.name.empty()) return fail(begin, "an attribute is expected" + in), false;
    const std::string subject = std::string(attribute.name) + in;
    if (!attribute_value(begin, subject, attribute.value)) return false;
    if (element.attributes.size() >= kMaxAttributes)
      return fail(begin, "more than " + std::to_string(kMaxAttributes) + " attributes" + in), false;
    if (element.attribute(attribute.name))
      return fail(begin, "attribute " + subject + " is given twice"), false;
    element.attributes.push_back(attribute);
    return true;
  }

  /// Reads the value of an attribute whose name began at `begin`.
  bool attribute_value(std::size_t begin, const std::string& subject, std::string_view& value) {
    skip_space();
    if (peek() != '=') return fail(begin, "attribute " + subject + " has no value"), false;
    ++at_;
    skip_space();
    const char quote = peek();
    if (quote != '"' && quote != '\'')
      return fail(at_, "the value of " + subject + " is not quoted"), false;
    const std::size_t start = at_ + 1;
    at_ = text_.find_first_of(quote == '"' ? "\"<" : "'<", start);
    if (at_ == text_.npos || text_[at_] == '<')
      return fail(begin, "the value of " + subject + " is never closed"), false;
    value = text_.substr(start, at_ - start);
    ++at_;
    return true;
  }

  bool starts(std::string_view what) const { return text_.substr(at_, what.size()) == what; }
  char peek() const { return at_ < text_.size() ? text_[at_] : '\0'; }
  void skip_space() { at_ = std::min(text_.find_first_not_of(kXmlSpace, at_), text_.size()); }
  std::string_view word(std::string_view stop) {
    const std::size_t begin = at_;
    at_ = std::min(text_.find_first_of(stop, at_), text_.size());
    return text_.substr(begin, at_ - begin);
  }
  void skip(const Skipped& part) {
    const std::size_t found = text_.find(part.end, at_ + part.opening.size());
    if (found == text_.npos) return fail(at_, part.defect);
    at_ = found + part.end.size();
  }

  /// Offsets ascend from call to call, except for that of a defect, which is the last.
  void locate(std::size_t offset, int& line, int& column) {
    if (offset < located_) located_ = 0, line_ = 1, column_ = 1;
    for (; located_ < offset; ++located_) {
      if (text_[located_] == '\n') {
        ++line_;
        column_ = 1;
      } else if ((static_cast<unsigned char>(text_[located_]) & 0xC0) != 0x80) {
        ++column_;
      }
    }
    line = line_;
    column = column_;
  }
  void fail(std::size_t offset, std::string message) {
    XmlDefect defect{std::move(message)};
    locate(offset, defect.line, defect.column);
    outline_.defect = std::move(defect);
  }

  std::string_view text_;
  std::size_t at_ = 0;
  std::size_t located_ = 0;
  int line_ = 1, column_ = 1;
  std::vector<int> open_;
  XmlOutline outline_;
};

}  // namespace

std::optional<std::string_view> XmlElement::attribute(std::string_view name) const {
  for (const XmlAttribute& a : attributes)
    if (a.name == name) return a.value;
  return std::nullopt;
}

std::vector<int> XmlOutline::children(int element, std::string_view tag) const {
  std::vector<int> found;
  const int depth = element < 0 ? 0 : elements[element].depth + 1;
  for (int i = element + 1; i < static_cast<int>(elements.size()); ++i) {
    if (elements[i].depth < depth) break;
    if (elements[i].depth == depth && (tag.empty() || elements[i].tag == tag)) found.push_back(i);
  }
  return found;
}

std::optional<int> XmlOutline::child(int element, std::string_view tag) const {
  const std::vector<int> found = children(element, tag);
  return found.empty() ? std::nullopt : std::optional(found.front());
}

XmlOutline scan_xml(std::string_view text) { return Scanner(text).run(); }

}  // namespace conddp
