#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include <pugixml.hpp>

namespace conddp {

/// Reason why a document cannot be read.
struct XmlDefect {
  std::string message;
  std::size_t offset = 0;  ///< in bytes
};

/// Loads a text without control characters; entities stay as they are written.
///
/// Reports the first defect: XML that is not well-formed, an internal document type, or elements
/// that are nested too deeply to recurse into them. pugixml itself accepts several roots, text
/// outside of the root, repeated attributes and `<` in their values.
std::optional<XmlDefect> load_xml(std::string_view text, pugi::xml_document& document);

}  // namespace conddp
