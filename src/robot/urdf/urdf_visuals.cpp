#include "robot/urdf/urdf_visuals.hpp"

#include <algorithm>
#include <cmath>
#include <locale>
#include <map>
#include <sstream>

#include <pugixml.hpp>

namespace conddp {
namespace {

Vector3<double> vector(const std::array<double, 3>& v) { return {v[0], v[1], v[2]}; }

/// First n numbers of an attribute, if all of them are present and finite.
template <std::size_t n>
std::optional<std::array<double, n>> read_numbers(pugi::xml_attribute attribute) {
  std::istringstream stream(attribute.value());
  stream.imbue(std::locale::classic());
  std::array<double, n> numbers;
  for (double& number : numbers)
    if (!(stream >> number) || !std::isfinite(number)) return std::nullopt;
  return numbers;
}

std::optional<double> read_number(pugi::xml_attribute attribute) {
  const auto number = read_numbers<1>(attribute);
  return number ? std::optional((*number)[0]) : std::nullopt;
}

SE3<double> read_origin(pugi::xml_node origin) {
  SE3<double> placement = SE3<double>::identity();
  if (const auto xyz = read_numbers<3>(origin.attribute("xyz"))) placement.p = vector(*xyz);
  if (const auto rpy = read_numbers<3>(origin.attribute("rpy")))
    placement.R = rotation_matrix(exp_so3(Vector3<double>{0, 0, (*rpy)[2]})) *
                  rotation_matrix(exp_so3(Vector3<double>{0, (*rpy)[1], 0})) *
                  rotation_matrix(exp_so3(Vector3<double>{(*rpy)[0], 0, 0}));
  return placement;
}

/// Reads kind and size from a child of <geometry>; a shape whose attributes are missing stays
/// unknown.
void read_geometry(pugi::xml_node geometry, VisualShape& shape) {
  const auto set = [&](ShapeKind kind, const Vector3<double>& size) {
    shape.kind = kind;
    shape.size = size;
  };
  const auto radius = read_number(geometry.attribute("radius"));
  const auto length = read_number(geometry.attribute("length"));
  shape.mesh = geometry.name();
  if (shape.mesh == "box") {
    if (const auto size = read_numbers<3>(geometry.attribute("size")))
      set(ShapeKind::box, vector(*size));
  } else if (shape.mesh == "cylinder" && radius && length) {
    set(ShapeKind::cylinder, {*radius, *length, 0});
  } else if (shape.mesh == "sphere" && radius) {
    set(ShapeKind::sphere, {*radius, 0, 0});
  } else if (const auto file = geometry.attribute("filename"); shape.mesh == "mesh" && file) {
    const auto scale = read_numbers<3>(geometry.attribute("scale"));
    set(ShapeKind::mesh, scale ? vector(*scale) : shape.size);
    shape.mesh = file.value();
  }
}

/// Reads <inertial>; missing numbers of <inertia> are zero.
std::optional<Inertia<double>> read_inertia(pugi::xml_node inertial) {
  const pugi::xml_node matrix = inertial.child("inertia");
  const double mass = read_number(inertial.child("mass").attribute("value")).value_or(0);
  if (mass <= 0 || !matrix) return std::nullopt;
  const auto entry = [&](const char* name) {
    return read_number(matrix.attribute(name)).value_or(0);
  };
  return act(read_origin(inertial.child("origin")),
             inertia_about_origin(mass, Vector3<double>::zero(),
                                  {entry("ixx"), entry("ixy"), entry("ixz"), entry("iyy"),
                                   entry("iyz"), entry("izz")}));
}

std::optional<std::array<double, 4>> read_color(pugi::xml_node material) {
  auto rgba = read_numbers<4>(material.child("color").attribute("rgba"));
  if (rgba)
    for (double& part : *rgba) part = std::clamp(part, 0.0, 1.0);
  return rgba;
}

using Materials = std::map<std::string, std::array<double, 4>>;

/// Colors of the robot's materials by name.
Materials read_materials(pugi::xml_node robot) {
  Materials materials;
  for (const pugi::xml_node material : robot.children("material")) {
    const std::string name = material.attribute("name").value();
    if (const auto color = read_color(material); color && !name.empty()) materials[name] = *color;
  }
  return materials;
}

/// Shapes of a link's elements with one tag ("visual" or "collision").
std::vector<VisualShape> read_shapes(pugi::xml_node link, const char* tag,
                                     const Materials& materials) {
  std::vector<VisualShape> shapes;
  for (const pugi::xml_node element : link.children(tag)) {
    VisualShape& shape = shapes.emplace_back();
    read_geometry(element.child("geometry").first_child(), shape);
    shape.placement = read_origin(element.child("origin"));
    const pugi::xml_node material = element.child("material");
    const auto known = materials.find(material.attribute("name").value());
    shape.color = read_color(material);
    if (!shape.color && known != materials.end()) shape.color = known->second;
  }
  return shapes;
}

}  // namespace

std::vector<LinkVisuals> urdf_visuals(std::string_view xml) {
  pugi::xml_document document;
  std::vector<LinkVisuals> links;
  if (!document.load_buffer(xml.data(), xml.size(), pugi::parse_default, pugi::encoding_utf8))
    return links;
  const pugi::xml_node robot = document.document_element();
  const Materials materials = read_materials(robot);
  for (const pugi::xml_node link : robot.children("link"))
    links.push_back({.link = link.attribute("name").value(),
                     .visual = read_shapes(link, "visual", materials),
                     .collision = read_shapes(link, "collision", materials),
                     .inertia = read_inertia(link.child("inertial"))});
  return links;
}

}  // namespace conddp
