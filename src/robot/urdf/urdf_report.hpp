#pragma once

#include <map>
#include <string>
#include <string_view>
#include <utility>

#include "robot/urdf/urdf_types.hpp"
#include "robot/urdf/xml_outline.hpp"

namespace conddp {

/// Link or joint that a message is about, and the child element that locates it in the file.
struct UrdfPlace {
  std::string_view tag;  ///< "link", "joint", or empty for the whole file
  std::string name;
  std::string_view child = {};
};
inline UrdfPlace at_link(std::string name, std::string_view child = {}) {
  return {"link", std::move(name), child};
}
inline UrdfPlace at_joint(std::string name, std::string_view child = {}) {
  return {"joint", std::move(name), child};
}

/// Collects problems and notes into a result and locates them in the file. Links and joints are
/// looked up by name in the outline of the text, because urdfdom does not keep positions.
class UrdfReport {
 public:
  UrdfReport(const XmlOutline& outline, UrdfResult& result);

  /// The message follows the prefix "link 'name': ".
  void error(const UrdfPlace& place, const std::string& message, std::string hint = {});
  void warning(const UrdfPlace& place, const std::string& message, std::string hint = {});
  /// Reports a problem at an element of the outline; the message gets no prefix.
  void error_at(int element, std::string name, std::string message, std::string hint = {});
  void warning_at(int element, std::string name, std::string message, std::string hint = {});
  void note(std::string text);

  bool has_errors() const { return errors_ > 0; }
  /// True if the file has a link or joint (tag "link" or "joint") of this name.
  bool has(std::string_view tag, std::string_view name) const;

 private:
  void add(const UrdfPlace& place, const std::string& message, std::string hint, bool warning);
  void add_at(int element, std::string name, std::string message, std::string hint, bool warning);

  const XmlOutline& outline_;
  UrdfResult& result_;
  std::map<std::pair<std::string_view, std::string_view>, int> elements_;
  int errors_ = 0;
};

/// Comma-separated list such as "a, b and 3 more".
std::string listed(const std::vector<std::string>& names, std::size_t shown = 6);

}  // namespace conddp
