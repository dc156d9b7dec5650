#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace conddp {

/// White space in XML.
inline constexpr std::string_view kXmlSpace = " \t\r\n";

struct XmlAttribute {
  std::string_view name;
  std::string_view value;  ///< as written, entities not resolved
};

/// An element and its place in the document; the views point into the scanned text.
struct XmlElement {
  std::string_view tag;
  int parent = -1;  ///< index of the enclosing element; −1 for the root element
  int depth = 0;
  int line = 0;    ///< 1-based, of its '<'
  int column = 0;  ///< 1-based, in characters
  std::string_view start_tag;
  std::string_view end_tag;  ///< empty for <tag/>
  std::vector<XmlAttribute> attributes;

  std::optional<std::string_view> attribute(std::string_view name) const;
};

/// Reason why a document cannot be read.
struct XmlDefect {
  std::string message;
  int line = 0;
  int column = 0;
};

/// The elements of an XML document in the order of their start tags.
///
/// TinyXML, the parser behind urdfdom, recurses into nested elements without a limit, keeps no
/// positions, and drops content after the root element. This scanner therefore reads documents
/// first, without recursion and with limits on depth and number of elements.
struct XmlOutline {
  std::vector<XmlElement> elements;
  std::optional<XmlDefect> defect;  ///< set if the document is not well formed or too large

  /// Indices of the children of an element (−1: of the document), optionally only those of one tag.
  std::vector<int> children(int element, std::string_view tag = {}) const;
  std::optional<int> child(int element, std::string_view tag) const;
};

inline constexpr int kMaxXmlDepth = 64;
inline constexpr std::size_t kMaxXmlElements = 500'000;

XmlOutline scan_xml(std::string_view text);

}  // namespace conddp
