#include "robot/urdf/urdf_visuals.hpp"

#include <algorithm>
#include <cmath>
#include <locale>
#include <map>
#include <sstream>

#include "robot/urdf/xml_outline.hpp"

namespace conddp {
namespace {

/// First n numbers of an attribute, if all of them are present and finite.
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

/// Kind and size of a shape. Readers return none if its attributes are missing.
struct Geometry {
  ShapeKind kind;
  Vector3<double> size;
};

Vector3<double> vector(const std::array<double, 3>& v) { return {v[0], v[1], v[2]}; }

std::optional<Geometry> read_box(const XmlElement& box) {
  const auto size = read_numbers<3>(box, "size");
  if (!size) return std::nullopt;
  return Geometry{ShapeKind::box, vector(*size)};
}

std::optional<Geometry> read_cylinder(const XmlElement& cylinder) {
  const auto radius = read_numbers<1>(cylinder, "radius");
  const auto length = read_numbers<1>(cylinder, "length");
  if (!radius || !length) return std::nullopt;
  return Geometry{ShapeKind::cylinder, {(*radius)[0], (*length)[0], 0}};
}

std::optional<Geometry> read_sphere(const XmlElement& sphere) {
  const auto radius = read_numbers<1>(sphere, "radius");
  if (!radius) return std::nullopt;
  return Geometry{ShapeKind::sphere, {(*radius)[0], 0, 0}};
}

std::optional<Geometry> read_mesh(const XmlElement& mesh, const Vector3<double>& default_scale) {
  if (!mesh.attribute("filename")) return std::nullopt;
  const auto scale = read_numbers<3>(mesh, "scale");
  return Geometry{ShapeKind::mesh, scale ? vector(*scale) : default_scale};
}

std::optional<Geometry> read_geometry(const XmlElement& e, const Vector3<double>& default_scale) {
  if (e.tag == "box") return read_box(e);
  if (e.tag == "cylinder") return read_cylinder(e);
  if (e.tag == "sphere") return read_sphere(e);
  if (e.tag == "mesh") return read_mesh(e, default_scale);
  return std::nullopt;
}

/// Reads kind and size from <geometry>.
void read_geometry(const XmlOutline& outline, int element, VisualShape& shape) {
  const auto geometry = outline.child(element, "geometry");
  if (!geometry) return;
  const std::vector<int> children = outline.children(*geometry);
  if (children.empty()) return;
  const XmlElement& e = outline.elements[children.front()];
  shape.mesh = std::string(e.tag);
  const auto found = read_geometry(e, shape.size);
  if (!found) return;
  shape.kind = found->kind;
  shape.size = found->size;
  if (shape.kind == ShapeKind::mesh) shape.mesh = std::string(*e.attribute("filename"));
}

/// Matrix of <inertia>; missing numbers are zero.
Symmetric3<double> read_matrix(const XmlElement& inertia) {
  const auto entry = [&](std::string_view name) {
    const auto number = read_numbers<1>(inertia, name);
    return number ? (*number)[0] : 0.0;
  };
  return {entry("ixx"), entry("ixy"), entry("ixz"), entry("iyy"), entry("iyz"), entry("izz")};
}

std::optional<Inertia<double>> read_inertia(const XmlOutline& outline, int link) {
  const auto inertial = outline.child(link, "inertial");
  if (!inertial) return std::nullopt;
  const auto mass = outline.child(*inertial, "mass");
  const auto matrix = outline.child(*inertial, "inertia");
  if (!mass || !matrix) return std::nullopt;
  const auto kilograms = read_numbers<1>(outline.elements[*mass], "value");
  if (!kilograms || (*kilograms)[0] <= 0) return std::nullopt;
  return act(read_origin(outline, *inertial),
             inertia_about_origin((*kilograms)[0], Vector3<double>::zero(),
                                  read_matrix(outline.elements[*matrix])));
}

std::optional<std::array<double, 4>> read_color(const XmlOutline& outline, int material) {
  const auto color = outline.child(material, "color");
  auto rgba = color ? read_numbers<4>(outline.elements[*color], "rgba") : std::nullopt;
  if (rgba)
    for (double& part : *rgba) part = std::clamp(part, 0.0, 1.0);
  return rgba;
}

using Materials = std::map<std::string_view, std::array<double, 4>>;

/// Colors of the robot's materials by name.
Materials read_materials(const XmlOutline& outline, int robot) {
  Materials materials;
  for (const int material : outline.children(robot, "material")) {
    const auto name = outline.elements[material].attribute("name");
    const auto color = read_color(outline, material);
    if (name && color) materials[*name] = *color;
  }
  return materials;
}

/// Shapes of a link's elements with one tag ("visual" or "collision").
std::vector<VisualShape> read_shapes(const XmlOutline& outline, int link, std::string_view tag,
                                     const Materials& materials) {
  std::vector<VisualShape> shapes;
  for (const int element : outline.children(link, tag)) {
    VisualShape& shape = shapes.emplace_back();
    read_geometry(outline, element, shape);
    shape.placement = read_origin(outline, element);
    const auto material = outline.child(element, "material");
    if (!material) continue;
    shape.color = read_color(outline, *material);
    const auto known = outline.elements[*material].attribute("name");
    if (!shape.color && known && materials.contains(*known)) shape.color = materials.at(*known);
  }
  return shapes;
}

}  // namespace

std::vector<LinkVisuals> urdf_visuals(std::string_view xml) {
  const XmlOutline outline = scan_xml(xml);
  std::vector<LinkVisuals> links;
  if (outline.defect || outline.elements.empty()) return links;
  const int robot = 0;
  const Materials materials = read_materials(outline, robot);
  for (const int link : outline.children(robot, "link")) {
    const auto name = outline.elements[link].attribute("name");
    if (!name) continue;
    links.push_back({.link = std::string(*name),
                     .visual = read_shapes(outline, link, "visual", materials),
                     .collision = read_shapes(outline, link, "collision", materials),
                     .inertia = read_inertia(outline, link)});
  }
  return links;
}

}  // namespace conddp
