#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <pugixml.hpp>

#include "robot/urdf/urdf_types.hpp"

namespace conddp {

/// Place of a problem, and the link or joint that it is about.
struct UrdfPlace {
  pugi::xml_node node = {};  ///< null: the whole file
  std::string name = {};     ///< of the link or joint
  std::string subject = {};  ///< beginning of the message, such as "link 'name': "
};

/// Collects problems and notes about a document. Links and joints are looked up by name, because
/// urdfdom does not keep positions.
class UrdfReport {
 public:
  explicit UrdfReport(pugi::xml_node robot) : robot_(robot) {}

  /// A joint or link, or its child element `child`. Without a place if there is none of this name.
  UrdfPlace joint(const std::string& name, const char* child = "") const {
    return named("joint", name, child);
  }
  UrdfPlace link(const std::string& name, const char* child = "") const {
    return named("link", name, child);
  }
  /// A node, about the child of <robot> that it belongs to.
  UrdfPlace around(pugi::xml_node node) const;

  /// Adds a problem whose message follows the subject of the place.
  void error(const UrdfPlace& place, const std::string& message, std::string hint = {});
  void warning(const UrdfPlace& place, const std::string& message, std::string hint = {});
  void note(std::string text) { notes_.push_back(std::move(text)); }
  bool has_errors() const { return errors_ > 0; }

  /// Problems in the order of their places in the text, and notes.
  UrdfResult take(std::string_view text);

 private:
  UrdfPlace named(const char* tag, const std::string& name, const char* child) const;
  void add(const UrdfPlace& place, const std::string& message, std::string hint, bool warning);

  pugi::xml_node robot_;
  std::vector<std::pair<std::ptrdiff_t, UrdfProblem>> problems_;  ///< by offset; −1: no place
  std::vector<std::string> notes_;
  int errors_ = 0;
};

}  // namespace conddp
