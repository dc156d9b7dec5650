#include "robot/urdf/urdf_report.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "base/text/utf8.hpp"

namespace conddp {

UrdfPlace UrdfReport::named(const char* tag, const std::string& name, const char* child) const {
  const pugi::xml_node element = robot_.find_child_by_attribute(tag, "name", name.c_str());
  const pugi::xml_node inner = element.child(child);
  return {inner ? inner : element, name, fmt::format("{} '{}': ", tag, name)};
}

UrdfPlace UrdfReport::around(pugi::xml_node node) const {
  pugi::xml_node top = node;
  while (top && top.parent() != robot_) top = top.parent();
  const pugi::xml_attribute name = top.attribute("name");
  if (!name) return {node};
  return {node, name.value(), fmt::format("{} '{}': ", top.name(), name.value())};
}

void UrdfReport::error(const UrdfPlace& place, const std::string& message, std::string hint) {
  add(place, message, std::move(hint), false);
  ++errors_;
}

void UrdfReport::warning(const UrdfPlace& place, const std::string& message, std::string hint) {
  add(place, message, std::move(hint), true);
}

void UrdfReport::add(const UrdfPlace& place, const std::string& message, std::string hint,
                     bool warning) {
  problems_.emplace_back(place.node ? place.node.offset_debug() - 1 : -1,
                         UrdfProblem{.message = place.subject + message,
                                     .element = place.name,
                                     .hint = std::move(hint),
                                     .warning = warning});
}

UrdfResult UrdfReport::take(std::string_view text) {
  std::stable_sort(problems_.begin(), problems_.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  UrdfResult result;
  std::ptrdiff_t reached = 0;
  TextPlace place;
  for (auto& [offset, problem] : problems_) {
    if (offset >= 0) {
      place = place_after(text.substr(reached, offset - reached), place);
      reached = offset;
      problem.line = place.line;
      problem.column = place.column;
    }
    result.problems.push_back(std::move(problem));
  }
  result.notes = std::move(notes_);
  return result;
}

}  // namespace conddp
