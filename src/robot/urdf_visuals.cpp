#include "robot/urdf_visuals.hpp"

#include <algorithm>
#include <cmath>
#include <locale>
#include <map>
#include <sstream>

#include "robot/xml_outline.hpp"

namespace conddp {
namespace {

/// The numbers of an attribute, if it has exactly n finite ones.
template <std::size_t n>
std::optional<std::array<double, n>> read_numbers(const XmlElement& element,
                                                  std::string_view name) {
  const auto text = element.attribute(name);
  if (!text) return std::nullopt;
  std::istringstream stream{std::string(*text)};
  stream.imbue(std::locale::classic());
  std::array<double, n> numbers;
  for (double& number : numbers)
    if (!(stream >> number) || !std::isfinite(number)) return std::nullopt;
  return numbers;
}

SE3<double> read_origin(const XmlOutline& outline, int shape) {
  SE3<double> placement = SE3<double>::identity();
  const auto origin = outline.child(shape, "origin");
  if (!origin) return placement;
  if (const auto xyz = read_numbers<3>(outline.elements[*origin], "xyz"))
    placement.p = {(*xyz)[0], (*xyz)[1], (*xyz)[2]};
  if (const auto rpy = read_numbers<3>(outline.elements[*origin], "rpy"))
    placement.R = rotation_matrix(exp_so3(Vector3<double>{0, 0, (*rpy)[2]})) *
                  rotation_matrix(exp_so3(Vector3<double>{0, (*rpy)[1], 0})) *
                  rotation_matrix(exp_so3(Vector3<double>{(*rpy)[0], 0, 0}));
  return placement;
}

/// Kind and size from <geometry>; false where there is none that is known.
bool read_geometry(const XmlOutline& outline, int element, VisualShape& shape) {
  const auto geometry = outline.child(element, "geometry");
  if (!geometry) return false;
  for (const int child : outline.children(*geometry)) {
    const XmlElement& e = outline.elements[child];
    if (e.tag == "box") {
      const auto size = read_numbers<3>(e, "size");
      if (!size) return false;
      shape.kind = ShapeKind::box;
      shape.size = {(*size)[0], (*size)[1], (*size)[2]};
      return true;
    }
    const auto radius = read_numbers<1>(e, "radius");
    if (e.tag == "cylinder") {
      const auto length = read_numbers<1>(e, "length");
      if (!radius || !length) return false;
      shape.kind = ShapeKind::cylinder;
      shape.size = {(*radius)[0], (*length)[0], 0};
      return true;
    }
    if (e.tag == "sphere") {
      if (!radius) return false;
      shape.kind = ShapeKind::sphere;
      shape.size = {(*radius)[0], 0, 0};
      return true;
    }
    if (e.tag == "mesh") {
      const auto file = e.attribute("filename");
      if (!file) return false;
      shape.kind = ShapeKind::mesh;
      shape.mesh = std::string(*file);
      shape.size = {1, 1, 1};
      if (const auto scale = read_numbers<3>(e, "scale"))
        shape.size = {(*scale)[0], (*scale)[1], (*scale)[2]};
      return true;
    }
  }
  return false;
}

std::optional<std::array<double, 4>> read_color(const XmlOutline& outline, int material) {
  const auto color = outline.child(material, "color");
  auto rgba = color ? read_numbers<4>(outline.elements[*color], "rgba") : std::nullopt;
  if (rgba)
    for (double& part : *rgba) part = std::clamp(part, 0.0, 1.0);
  return rgba;
}

}  // namespace

std::vector<VisualShape> urdf_visuals(std::string_view xml) {
  const XmlOutline outline = scan_xml(xml);
  std::vector<VisualShape> shapes;
  if (outline.defect || outline.elements.empty()) return shapes;
  const int robot = 0;
  std::map<std::string_view, std::array<double, 4>> materials;
  for (const int material : outline.children(robot, "material")) {
    const auto name = outline.elements[material].attribute("name");
    const auto color = read_color(outline, material);
    if (name && color) materials[*name] = *color;
  }
  for (const int link : outline.children(robot, "link")) {
    const auto name = outline.elements[link].attribute("name");
    if (!name) continue;
    for (const std::string_view tag : {"visual", "collision"}) {
      const std::size_t before = shapes.size();
      for (const int element : outline.children(link, tag)) {
        VisualShape shape{.link = std::string(*name)};
        if (!read_geometry(outline, element, shape)) continue;
        shape.placement = read_origin(outline, element);
        if (const auto material = outline.child(element, "material")) {
          shape.color = read_color(outline, *material);
          const auto known = outline.elements[*material].attribute("name");
          if (!shape.color && known && materials.contains(*known))
            shape.color = materials.at(*known);
        }
        shapes.push_back(std::move(shape));
      }
      if (shapes.size() > before) break;
    }
  }
  return shapes;
}

}  // namespace conddp
