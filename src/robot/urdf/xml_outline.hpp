#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace conddp {

/// What XML takes for white space.
inline constexpr std::string_view kXmlSpace = " \t\r\n";

struct XmlAttribute {
  std::string_view name;
  std::string_view value;  ///< as written, entities not resolved
};

/// An element's place in a document; views into the text that was scanned.
struct XmlElement {
  std::string_view tag;
  int parent = -1;  ///< index of the enclosing element, −1 for the document's root
  int depth = 0;
  int line = 0;    ///< 1-based, of its '<'
  int column = 0;  ///< 1-based, in characters
  std::string_view start_tag;
  std::string_view end_tag;  ///< empty for <tag/>
  std::vector<XmlAttribute> attributes;

  std::optional<std::string_view> attribute(std::string_view name) const;
};

/// Why a document cannot be read.
struct XmlDefect {
  std::string message;
  int line = 0;
  int column = 0;
};

/// The elements of an XML document in the order of their start tags.
///
/// TinyXML, which urdfdom stands on, recurses into nested elements without a limit, has no
/// positions once parsed, and drops what follows the root: so documents are first scanned here,
/// flat, with limits on depth and number of elements.
struct XmlOutline {
  std::vector<XmlElement> elements;
  std::optional<XmlDefect> defect;  ///< set if the document is not well formed or too large

  /// Indices of the children of an element (or of the document for −1), optionally of one tag.
  std::vector<int> children(int element, std::string_view tag = {}) const;
  std::optional<int> child(int element, std::string_view tag) const;
};

inline constexpr int kMaxXmlDepth = 64;
inline constexpr std::size_t kMaxXmlElements = 500'000;

XmlOutline scan_xml(std::string_view text);

}  // namespace conddp
