#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <functional>
#include <map>

#include <pugixml.hpp>

#include "robot/urdf/affine.hpp"
#include "robot/urdf/mesh_parts.hpp"
#include "spatial/so3.hpp"

namespace conddp {
namespace {

using Color = std::array<double, 4>;

/// Limits that nested instances cannot exceed.
constexpr int kDeepest = 64;
constexpr std::size_t kMostVertices = 20'000'000, kMostNodes = 1'000'000;

/// The numbers at the beginning of a text.
template <class Number>
std::vector<Number> numbers_of(const char* text) {
  std::vector<Number> numbers;
  const char* const end = text + std::char_traits<char>::length(text);
  for (Number number{};; numbers.push_back(number)) {
    while (text != end && std::isspace(static_cast<unsigned char>(*text))) ++text;
    const auto [next, error] = std::from_chars(text, end, number);
    if (error != std::errc()) return numbers;
    text = next;
  }
}

std::vector<double> reals_of(const pugi::xml_node& node) {
  return numbers_of<double>(node.child_value());
}

Affine transform_of(const pugi::xml_node& element) {
  const std::string kind = element.name();
  const std::vector<double> n = reals_of(element);
  Affine result;
  if (kind == "translate" && n.size() == 3) result.p = {n[0], n[1], n[2]};
  if (kind == "scale" && n.size() == 3)
    for (int i = 0; i < 3; ++i) result.A.m[4 * i] = n[i];
  if (kind == "rotate" && n.size() == 4) {
    const Vector3<double> axis{n[0], n[1], n[2]};
    const double length = std::sqrt(squared_norm(axis));
    if (length > 0) result.A = rotation_matrix(exp_so3((n[3] * M_PI / 180 / length) * axis));
  }
  if (kind == "matrix" && n.size() == 16)
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) result.A.m[3 * i + j] = n[4 * i + j];
      result.p[i] = n[4 * i + 3];
    }
  return result;
}

class Document {
 public:
  explicit Document(const pugi::xml_node& root) : root_(root) { note_ids(root, 0); }

  std::vector<MeshPart> parts() {
    const double meter = root_.child("asset").child("unit").attribute("meter").as_double(1);
    Affine place;
    for (int i = 0; i < 3; ++i) place.A.m[4 * i] = meter;
    const pugi::xml_node scene =
        target(root_.child("scene").child("instance_visual_scene").attribute("url"));
    for (const pugi::xml_node& node : scene.children("node")) add_node(node, place, 0);
    return std::move(parts_);
  }

 private:
  void note_ids(const pugi::xml_node& node, int depth) {
    if (const auto id = node.attribute("id")) by_id_.try_emplace(id.value(), node);
    if (depth < kDeepest)
      for (const pugi::xml_node& child : node.children()) note_ids(child, depth + 1);
  }

  /// The element that a reference `#id` names, or an empty one.
  pugi::xml_node target(const pugi::xml_attribute& reference) const {
    const std::string_view url = reference.value();
    const auto found = by_id_.find(url.substr(std::min<std::size_t>(1, url.size())));
    return found == by_id_.end() ? pugi::xml_node() : found->second;
  }

  void add_node(const pugi::xml_node& node, Affine place, int depth) {
    if (depth > kDeepest || vertices_ > kMostVertices || ++nodes_ > kMostNodes) return;
    for (const pugi::xml_node& child : node.children()) place = place * transform_of(child);
    for (const pugi::xml_node& instance : node.children("instance_geometry"))
      add_geometry(instance, place);
    for (const pugi::xml_node& child : node.children("node")) add_node(child, place, depth + 1);
    for (const pugi::xml_node& instance : node.children("instance_node"))
      add_node(target(instance.attribute("url")), place, depth + 1);
  }

  void add_geometry(const pugi::xml_node& instance, const Affine& place) {
    const pugi::xml_node mesh = target(instance.attribute("url")).child("mesh");
    for (const char* kind : {"triangles", "polylist", "polygons"})
      for (const pugi::xml_node& faces : mesh.children(kind)) {
        MeshPart part = part_of(faces, place);
        part.color = color_of(instance, faces.attribute("material").value());
        if (!part.triangles.empty()) parts_.push_back(std::move(part));
      }
  }

  MeshPart part_of(const pugi::xml_node& faces, const Affine& place) {
    MeshPart part;
    int stride = 1, offset = 0;
    for (const pugi::xml_node& input : faces.children("input")) {
      const int at = input.attribute("offset").as_int();
      if (at < 0 || at > kDeepest) return part;
      stride = std::max(stride, at + 1);
      if (std::string_view(input.attribute("semantic").value()) != "VERTEX") continue;
      offset = at;
      part.vertices = vertices_of(target(input.attribute("source")), place);
    }
    vertices_ += part.vertices.size();
    const std::vector<int> counts = numbers_of<int>(faces.child("vcount").child_value());
    for (const pugi::xml_node& list : faces.children("p")) {
      std::vector<std::uint32_t> corners;
      const std::vector<std::uint32_t> numbers = numbers_of<std::uint32_t>(list.child_value());
      for (std::size_t i = static_cast<std::size_t>(offset); i < numbers.size();
           i += static_cast<std::size_t>(stride))
        corners.push_back(numbers[i]);
      add_faces(corners, faces.name(), counts, part);
    }
    return part;
  }

  /// Polygons of the given numbers of corners, of three, or a single one; as fans.
  static void add_faces(const std::vector<std::uint32_t>& corners, std::string_view kind,
                        const std::vector<int>& counts, MeshPart& part) {
    std::size_t first = 0;
    for (std::size_t face = 0; first < corners.size(); ++face) {
      std::size_t count = kind == "triangles" ? 3 : corners.size();
      if (kind == "polylist") {
        if (face >= counts.size() || counts[face] < 1) return;
        count = static_cast<std::size_t>(counts[face]);
      }
      if (count > corners.size() - first) return;
      for (std::size_t i = 2; i < count; ++i)
        add_triangle({corners[first], corners[first + i - 1], corners[first + i]}, part);
      first += count;
    }
  }

  static void add_triangle(const std::array<std::uint32_t, 3>& triangle, MeshPart& part) {
    for (const std::uint32_t i : triangle) {
      if (i >= part.vertices.size()) return;
      const Vector3<double>& p = part.vertices[i];
      if (!std::isfinite(p.x + p.y + p.z)) return;
    }
    part.triangles.push_back(triangle);
  }

  std::vector<Vector3<double>> vertices_of(const pugi::xml_node& vertices,
                                           const Affine& place) const {
    std::vector<Vector3<double>> points;
    const pugi::xml_node input = vertices.find_child_by_attribute("input", "semantic", "POSITION");
    const pugi::xml_node source = target(input.attribute("source"));
    const std::vector<double> numbers = reals_of(source.child("float_array"));
    const int stride =
        source.child("technique_common").child("accessor").attribute("stride").as_int(3);
    if (stride < 3) return points;
    for (std::size_t i = 0; i + 2 < numbers.size(); i += static_cast<std::size_t>(stride))
      points.push_back(place * Vector3<double>{numbers[i], numbers[i + 1], numbers[i + 2]});
    return points;
  }

  /// Diffuse color of the material that an instance binds to a symbol.
  std::optional<Color> color_of(const pugi::xml_node& instance, const char* symbol) const {
    const pugi::xml_node bound =
        instance.child("bind_material")
            .child("technique_common")
            .find_child_by_attribute("instance_material", "symbol", symbol);
    const pugi::xml_node material = target(bound.attribute("target"));
    const pugi::xml_node technique = target(material.child("instance_effect").attribute("url"))
                                         .child("profile_COMMON")
                                         .child("technique");
    for (const char* shading : {"phong", "blinn", "lambert"}) {
      const std::vector<double> n =
          reals_of(technique.child(shading).child("diffuse").child("color"));
      if (n.size() == 4) return Color{n[0], n[1], n[2], n[3]};
    }
    return std::nullopt;
  }

  pugi::xml_node root_;
  std::map<std::string, pugi::xml_node, std::less<>> by_id_;
  std::vector<MeshPart> parts_;
  std::size_t vertices_ = 0, nodes_ = 0;
};

}  // namespace

std::vector<MeshPart> collada_parts(std::string_view xml) {
  pugi::xml_document document;
  if (!document.load_buffer(xml.data(), xml.size())) return {};
  return Document(document.child("COLLADA")).parts();
}

}  // namespace conddp
