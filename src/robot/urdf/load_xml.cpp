#include "robot/urdf/load_xml.hpp"

#include <algorithm>
#include <set>

#include <fmt/format.h>

#include "base/text/utf8.hpp"

namespace conddp {
namespace {

constexpr int kMaxDepth = 64;
constexpr const char* kDocumentType = "a document type declaration of its own is not accepted here";

std::optional<XmlDefect> attribute_defect(pugi::xml_node element) {
  std::set<std::string_view> names;
  for (const pugi::xml_attribute attribute : element.attributes()) {
    const bool closed = std::string_view(attribute.value()).find('<') == std::string_view::npos;
    if (closed && names.insert(attribute.name()).second) continue;
    const std::string name = fmt::format("{} in <{}>", attribute.name(), element.name());
    return XmlDefect{
        closed ? "attribute " + name + " is given twice"
               : "the value of " + name + " is never closed",
        static_cast<std::size_t>(element.offset_debug() + (attribute.name() - element.name()))};
  }
  return std::nullopt;
}

/// Finds the first defect of the nodes that pugixml read.
class DefectFinder : public pugi::xml_tree_walker {
 public:
  DefectFinder(std::string_view text, pugi::xml_node root) : text_(text), root_(root) {}

  bool for_each(pugi::xml_node& node) override {
    found = defect_of(node);
    return !found;
  }

  std::optional<XmlDefect> found;

 private:
  std::optional<XmlDefect> defect_of(pugi::xml_node node) const {
    const std::size_t offset = node.offset_debug();
    if (node.type() == pugi::node_element) {
      if (depth() == 0 && node != root_)
        return XmlDefect{fmt::format("a second root element <{}>", node.name()), offset - 1};
      if (depth() >= kMaxDepth)
        return XmlDefect{fmt::format("elements are nested deeper than {}", kMaxDepth), offset - 1};
      return attribute_defect(node);
    }
    const bool is_type = node.type() == pugi::node_doctype;
    if (is_type && std::string_view(node.value()).find('[') != std::string_view::npos)
      return XmlDefect{kDocumentType, text_.rfind("<!", offset)};
    if (is_type || depth() > 0) return std::nullopt;
    return XmlDefect{"text outside the document's root element", offset};
  }

  std::string_view text_;
  pugi::xml_node root_;
};

/// Error of pugixml, the text at its place, and the message.
struct ParseError {
  pugi::xml_parse_status status;
  std::string_view opening;
  const char* message;
};
constexpr ParseError kParseErrors[] = {
    {pugi::status_bad_comment, "<!-", "a comment is never closed"},
    {pugi::status_bad_pi, "<?", "a processing instruction is never closed"},
    {pugi::status_bad_cdata, "<![", "CDATA is never closed"},
    {pugi::status_bad_doctype, "<!", kDocumentType},
    {pugi::status_bad_end_element, "</", "an end tag lacks its '>'"},
    {pugi::status_unrecognized_tag, "<", "'<' without an element's name"},
};

pugi::xml_node last_node(pugi::xml_node node) {
  while (node.last_child()) node = node.last_child();
  return node;
}

constexpr unsigned kOptions =
    pugi::parse_doctype | pugi::parse_cdata | pugi::parse_fragment | pugi::parse_trim_pcdata;

pugi::xml_parse_result load(const std::string& text, pugi::xml_document& document) {
  return document.load_buffer(text.data(), text.size(), kOptions, pugi::encoding_utf8);
}

/// Defect of an end tag, or of an element that is open at the end of the text.
XmlDefect end_tag_defect(const std::string& text, std::size_t stop, pugi::xml_document& document) {
  const bool at_tag = text.compare(stop - 2, 2, "</") == 0;
  const std::size_t offset = at_tag ? stop - 2 : stop;
  // An additional element becomes the last child of the element that is open.
  load(text.substr(0, offset) + "<_/>\n", document);
  const pugi::xml_node open = last_node(document).parent();
  const std::size_t open_offset = open.offset_debug() - 1;
  if (!at_tag) return {fmt::format("<{}> is never closed", open.name()), open_offset};
  const std::string tag = text.substr(offset, text.find_first_of("> \t\r\n", offset) - offset);
  if (!open.parent()) return {tag + "> closes nothing", offset};
  const int line = place_after(std::string_view(text).substr(0, open_offset)).line;
  return {fmt::format("{}> where <{}> of line {} is open", tag, open.name(), line), offset};
}

/// Defect at which pugixml stops.
XmlDefect parse_defect(const pugi::xml_parse_result& result, const std::string& text,
                       pugi::xml_document& document) {
  const std::size_t stop = std::min<std::size_t>(result.offset, text.size());
  const pugi::xml_node last = last_node(document);
  if (result.status == pugi::status_end_element_mismatch)
    return end_tag_defect(text, stop, document);
  if (result.status == pugi::status_bad_start_element)
    return {fmt::format("an attribute is expected in <{}>", last.name()), stop};
  if (result.status == pugi::status_bad_attribute) {
    const bool quoted = text[stop - 1] == '"' || text[stop - 1] == '\'';
    return {fmt::format("the value of {} in <{}> is not {}", last.last_attribute().name(),
                        last.name(), quoted ? "closed, or no blank follows" : "quoted"),
            stop};
  }
  for (const ParseError& error : kParseErrors)
    if (error.status == result.status) return {error.message, text.rfind(error.opening, stop)};
  return {result.description(), stop};
}

}  // namespace

std::optional<XmlDefect> load_xml(std::string_view text, pugi::xml_document& document) {
  // A final line end lets pugixml report the end of the text always in the same way.
  const std::string whole = std::string(text) + '\n';
  const pugi::xml_parse_result result = load(whole, document);
  DefectFinder finder(whole, document.document_element());
  document.traverse(finder);
  if (finder.found) return finder.found;
  if (!result) return parse_defect(result, whole, document);
  if (!document.document_element()) return XmlDefect{"the file has no XML element", 0};
  return std::nullopt;
}

}  // namespace conddp
