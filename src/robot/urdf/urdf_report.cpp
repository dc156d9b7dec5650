#include "robot/urdf/urdf_report.hpp"

#include <algorithm>

namespace conddp {

UrdfReport::UrdfReport(const XmlOutline& outline, UrdfResult& result)
    : outline_(outline), result_(result) {
  for (int i = 0; i < static_cast<int>(outline.elements.size()); ++i) {
    const XmlElement& element = outline.elements[i];
    if (element.depth != 1 || (element.tag != "link" && element.tag != "joint")) continue;
    if (const auto name = element.attribute("name")) elements_.try_emplace({element.tag, *name}, i);
  }
}

void UrdfReport::error(const UrdfPlace& place, const std::string& message, std::string hint) {
  add(place, message, std::move(hint), false);
}
void UrdfReport::warning(const UrdfPlace& place, const std::string& message, std::string hint) {
  add(place, message, std::move(hint), true);
}
void UrdfReport::error_at(int element, std::string name, std::string message, std::string hint) {
  add_at(element, std::move(name), std::move(message), std::move(hint), false);
}
void UrdfReport::warning_at(int element, std::string name, std::string message, std::string hint) {
  add_at(element, std::move(name), std::move(message), std::move(hint), true);
}
void UrdfReport::note(std::string text) { result_.notes.push_back(std::move(text)); }

bool UrdfReport::has(std::string_view tag, std::string_view name) const {
  return elements_.contains({tag, name});
}

void UrdfReport::add(const UrdfPlace& place, const std::string& message, std::string hint,
                     bool warning) {
  int element = -1;
  if (const auto found = elements_.find({place.tag, place.name}); found != elements_.end()) {
    element = found->second;
    if (!place.child.empty())
      if (const auto child = outline_.child(element, place.child)) element = *child;
  }
  const std::string subject =
      place.tag.empty() ? "" : std::string(place.tag) + " '" + place.name + "': ";
  add_at(element, place.name, subject + message, std::move(hint), warning);
}

void UrdfReport::add_at(int element, std::string name, std::string message, std::string hint,
                        bool warning) {
  UrdfProblem problem{.message = std::move(message),
                      .element = std::move(name),
                      .hint = std::move(hint),
                      .warning = warning};
  if (element >= 0) {
    problem.line = outline_.elements[element].line;
    problem.column = outline_.elements[element].column;
  }
  errors_ += !warning;
  result_.problems.push_back(std::move(problem));
}

std::string listed(const std::vector<std::string>& names, std::size_t shown) {
  std::string text;
  for (std::size_t i = 0; i < std::min(shown, names.size()); ++i)
    text += (i > 0 ? ", " : "") + names[i];
  if (names.size() > shown) text += " and " + std::to_string(names.size() - shown) + " more";
  return text;
}

}  // namespace conddp
