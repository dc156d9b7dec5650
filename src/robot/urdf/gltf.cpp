// glTF 2.0, section numbers of https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "base/text/base64.hpp"
#include "robot/urdf/affine.hpp"
#include "robot/urdf/mesh_parts.hpp"
#include "spatial/so3.hpp"

namespace conddp {
namespace {

using Json = nlohmann::json;

/// Elements of all instances together, which are not limited by the size of a file.
constexpr std::size_t kMostElements = 30'000'000;

std::uint32_t word_at(std::string_view bytes, std::size_t at) {
  std::uint32_t word = 0;
  std::memcpy(&word, bytes.substr(at).data(), sizeof word);
  return word;
}

/// The JSON and the binary chunk of a file.
struct Chunks {
  std::string_view json, binary;
};

/// The chunks of a binary file (section 4.4); other files are JSON.
Chunks chunks_of(std::string_view bytes) {
  constexpr std::uint32_t kVersion = 2, kJson = 0x4e4f534a, kBinary = 0x004e4942;
  constexpr std::size_t kFileHead = 12, kChunkHead = 8;
  if (!bytes.starts_with("glTF")) return {bytes, {}};
  if (bytes.size() < kFileHead || word_at(bytes, 4) != kVersion)
    throw MeshDefect("only version 2 of glTF is read");
  Chunks chunks;
  for (bytes.remove_prefix(kFileHead); bytes.size() >= kChunkHead;) {
    const std::size_t size = word_at(bytes, 0);
    const std::uint32_t kind = word_at(bytes, 4);
    bytes.remove_prefix(kChunkHead);
    if (size > bytes.size()) throw MeshDefect("it ends too early");
    if (kind == kJson && chunks.json.empty()) chunks.json = bytes.substr(0, size);
    if (kind == kBinary && chunks.binary.empty()) chunks.binary = bytes.substr(0, size);
    bytes.remove_prefix(size);
  }
  return chunks;
}

/// A path without the escapes of addresses: `%20` is a blank.
std::string unescaped(std::string_view uri) {
  std::string path;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    int code = 0;
    const auto digits = uri.substr(i).substr(std::min<std::size_t>(1, uri.size() - i), 2);
    const bool escaped =
        uri[i] == '%' &&
        std::from_chars(digits.data(), digits.data() + digits.size(), code, 16).ptr ==
            digits.data() + 2;
    path += escaped ? static_cast<char>(code) : uri[i];
    if (escaped) i += 2;
  }
  return path;
}

/// Colors are linear in glTF, those of pages are sRGB.
double srgb(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

class GltfDocument {
 public:
  GltfDocument(std::string_view bytes, const ReadSideFile& read)
      : read_(read), chunks_(chunks_of(bytes)), json_(Json::parse(chunks_.json)) {}

  std::vector<MeshPart> parts() {
    check_extensions();
    const Json& scene = item("scenes", count(json_, "scene", 0));
    // glTF's y axis points up and becomes z, as in RViz and Drake.
    Affine upright;
    upright.A = {{1, 0, 0, 0, 0, -1, 0, 1, 0}};
    add_nodes(scene, "nodes", upright);
    return std::move(parts_);
  }

 private:
  /// Extensions of looks change no surface; others may.
  void check_extensions() const {
    for (const std::string name : json_.value("extensionsRequired", Json::array())) {
      constexpr std::string_view kLooks[] = {"KHR_materials_", "KHR_texture_", "EXT_texture_",
                                             "KHR_lights_"};
      if (std::ranges::none_of(kLooks, [&](auto prefix) { return name.starts_with(prefix); }))
        throw MeshDefect(fmt::format("it needs the extension '{}', which is not read", name));
    }
  }

  /// A number of bytes or items, or an index.
  static std::size_t count(const Json& object, const char* key,
                           std::optional<std::size_t> fallback = std::nullopt) {
    if (fallback && !object.contains(key)) return *fallback;
    const Json& value = object.at(key);
    constexpr std::size_t kMost = 0xffffffff;
    if (!value.is_number_unsigned() || value.get<std::size_t>() > kMost)
      throw MeshDefect(fmt::format("'{}' is not a number of bytes or items", key));
    return value.get<std::size_t>();
  }

  /// An element of one of the document's lists.
  const Json& item(const char* list, std::size_t index) const { return json_.at(list).at(index); }

  template <std::size_t N>
  static std::array<double, N> numbers(const Json& object, const char* key,
                                       const std::array<double, N>& fallback) {
    return object.contains(key) ? object.at(key).get<std::array<double, N>>() : fallback;
  }

  void add_nodes(const Json& parent, const char* key, const Affine& place) {
    for (const Json& index : parent.value(key, Json::array())) {
      // A node has one parent; more would make circles, or trees of exponential size.
      const std::size_t number = index.get<std::size_t>();
      constexpr std::size_t kDeepestNode = 200;
      if (!nodes_.insert(number).second || depth_ > kDeepestNode)
        throw MeshDefect("its nodes are not a tree");
      const Json& node = item("nodes", number);
      const Affine here = place * transform(node);
      if (node.contains("mesh"))
        for (const Json& primitive : item("meshes", count(node, "mesh")).at("primitives"))
          add_primitive(primitive, here);
      ++depth_;
      add_nodes(node, "children", here);
      --depth_;
    }
  }

  /// Section 3.5.3: a matrix by columns, or translation, rotation and scale.
  static Affine transform(const Json& node) {
    Affine result;
    if (node.contains("matrix")) {
      const auto matrix = node.at("matrix").get<std::array<double, 16>>();
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) result.A(i, j) = matrix[4 * j + i];
        result.p[i] = matrix[12 + i];
      }
      return result;
    }
    const auto t = numbers<3>(node, "translation", {0, 0, 0});
    const auto q = numbers<4>(node, "rotation", {0, 0, 0, 1});
    const auto s = numbers<3>(node, "scale", {1, 1, 1});
    result.A = rotation_matrix(Quaternion<double>{q[0], q[1], q[2], q[3]});
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) result.A(i, j) *= s[j];
    result.p = {t[0], t[1], t[2]};
    return result;
  }

  void add_primitive(const Json& primitive, const Affine& place) {
    constexpr std::size_t kLines = 3, kTriangles = 4;
    const std::size_t mode = count(primitive, "mode", kTriangles);
    if (mode <= kLines) return;
    if (mode != kTriangles) throw MeshDefect("strips and fans of triangles are not read");
    MeshPart part;
    const Json& points = item("accessors", count(primitive.at("attributes"), "POSITION"));
    if (points.at("type") != "VEC3" || count(points, "componentType") != kFloat)
      throw MeshDefect("its positions are not three floats each");
    each_element(points, 3 * sizeof(float), [&](const char* element) {
      float p[3];
      std::memcpy(p, element, sizeof p);
      part.vertices.push_back(place * Vector3<double>{p[0], p[1], p[2]});
    });
    const std::vector<std::uint32_t> corners = corners_of(primitive, part.vertices.size());
    for (std::size_t i = 0; i + 2 < corners.size(); i += 3) {
      const std::array<std::uint32_t, 3> triangle{corners[i], corners[i + 1], corners[i + 2]};
      if (std::ranges::max(triangle) < part.vertices.size()) part.triangles.push_back(triangle);
    }
    if (primitive.contains("material"))
      part.color = color_of(item("materials", count(primitive, "material")));
    parts_.push_back(std::move(part));
  }

  /// Indices of the triangles' vertices, three each; without indices, vertices are in their order.
  std::vector<std::uint32_t> corners_of(const Json& primitive, std::size_t vertices) {
    std::vector<std::uint32_t> corners;
    if (!primitive.contains("indices")) {
      for (std::size_t i = 0; i < vertices; ++i) corners.push_back(static_cast<std::uint32_t>(i));
      return corners;
    }
    const Json& indices = item("accessors", count(primitive, "indices"));
    const std::size_t kind = count(indices, "componentType");
    const std::size_t size = kind == kByte ? 1 : kind == kShort ? 2 : kind == kWord ? 4 : 0;
    if (size == 0 || indices.at("type") != "SCALAR")
      throw MeshDefect("its indices are not unsigned integers");
    each_element(indices, size, [&](const char* element) {
      std::uint32_t corner = 0;
      std::memcpy(&corner, element, size);
      corners.push_back(corner);
    });
    return corners;
  }

  /// Section 3.9.2: the base color; a texture is not read.
  static std::optional<std::array<double, 4>> color_of(const Json& material) {
    const Json look = material.value("pbrMetallicRoughness", Json::object());
    if (look.contains("baseColorTexture") && !look.contains("baseColorFactor")) return std::nullopt;
    auto color = numbers<4>(look, "baseColorFactor", {1, 1, 1, 1});
    for (double& part : color) part = std::clamp(part, 0.0, 1.0);
    for (int i = 0; i < 3; ++i) color[i] = srgb(color[i]);
    if (material.value("alphaMode", "OPAQUE") != "BLEND") color[3] = 1;
    return color;
  }

  /// Calls a function with each element of an accessor (section 3.6.2).
  template <class Use>
  void each_element(const Json& accessor, std::size_t size, const Use& use) {
    if (accessor.contains("sparse")) throw MeshDefect("sparse accessors are not read");
    if (!accessor.contains("bufferView")) throw MeshDefect("an accessor has no data");
    const Json& view = item("bufferViews", count(accessor, "bufferView"));
    const std::string_view buffer = buffer_of(count(view, "buffer"));
    const std::size_t first = count(view, "byteOffset", 0), length = count(view, "byteLength");
    const std::size_t offset = count(accessor, "byteOffset", 0), items = count(accessor, "count");
    const std::size_t given = count(view, "byteStride", 0), stride = given == 0 ? size : given;
    // Each number has 32 bits at most, and their products 64.
    if (first + length > buffer.size() ||
        (items > 0 && (offset + size > length || (items - 1) * stride > length - offset - size)))
      throw MeshDefect("its data end too early");
    elements_ += items;
    if (elements_ > kMostElements) throw MeshDefect("it has too many vertices");
    for (std::size_t i = 0; i < items; ++i)
      use(buffer.substr(first + offset + i * stride, size).data());
  }

  /// The bytes of a buffer: of the file's binary chunk, of a data URI, or of a file beside it.
  std::string_view buffer_of(std::size_t index) {
    const Json& buffer = item("buffers", index);
    if (!buffer.contains("uri")) return chunks_.binary;
    const auto [known, is_new] = buffers_.try_emplace(index);
    if (!is_new) return known->second;
    const std::string uri = buffer.at("uri");
    if (!uri.starts_with("data:")) return known->second = read_(unescaped(uri));
    constexpr std::string_view kCoding = ";base64,";
    const std::size_t coding = uri.find(kCoding);
    const auto bytes = coding == uri.npos
                           ? std::nullopt
                           : bytes_of_base64(std::string_view(uri).substr(coding + kCoding.size()));
    if (!bytes) throw MeshDefect("the data of a buffer are not base64");
    return known->second = *bytes;
  }

  static constexpr std::size_t kByte = 5121, kShort = 5123, kWord = 5125, kFloat = 5126;

  const ReadSideFile& read_;
  Chunks chunks_;
  Json json_;
  std::map<std::size_t, std::string> buffers_;
  std::set<std::size_t> nodes_;
  std::size_t depth_ = 0, elements_ = 0;
  std::vector<MeshPart> parts_;
};

}  // namespace

std::vector<MeshPart> gltf_parts(std::string_view bytes, const ReadSideFile& read) {
  try {
    return GltfDocument(bytes, read).parts();
  } catch (const Json::exception& error) {
    throw MeshDefect(fmt::format("it is not glTF ({})", error.what()));
  }
}

}  // namespace conddp
