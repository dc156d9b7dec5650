#include "output/scene/form_json.hpp"

#include "problem_file/plant/shape_pairs.hpp"

namespace conddp {

OrderedJson coordinates_json(const Vector3<double>& v) { return {v.x, v.y, v.z}; }

OrderedJson form_json(const SphereSpec& sphere) {
  return {
      {"kind", "sphere"}, {"center", coordinates_json(sphere.center)}, {"radius", sphere.radius}};
}
OrderedJson form_json(const CapsuleSpec& capsule) {
  return {{"kind", "capsule"},
          {"from", coordinates_json(capsule.from)},
          {"to", coordinates_json(capsule.to)},
          {"radius", capsule.radius}};
}
OrderedJson form_json(const HalfSpaceSpec& half_space) {
  return {{"kind", "half_space"},
          {"normal", coordinates_json(half_space.normal)},
          {"point", coordinates_json(half_space.point)}};
}
OrderedJson form_json(const Polytope& polytope) {
  OrderedJson points = OrderedJson::array();
  for (const Vector3<double>& vertex : polytope.vertices)
    points.push_back(coordinates_json(vertex));
  return {{"kind", "hull"}, {"points", std::move(points)}};
}
OrderedJson form_json(const HeightMapSpec& map) {
  OrderedJson heights = OrderedJson::array();
  for (const double height : map.heights) heights.push_back(eight_digits(height));
  return {{"kind", "heights"},
          {"origin", coordinates_json(map.origin)},
          {"cell", map.cell},
          {"columns", map.columns},
          {"heights", std::move(heights)}};
}
OrderedJson form_json(const BoxSpec& box) { return form_json(polytope_of(box, -1)); }
OrderedJson form_json(const CylinderSpec& cylinder) { return form_json(polytope_of(cylinder, -1)); }
OrderedJson form_json(const HullSpec& hull) { return form_json(polytope_of(hull, -1)); }

}  // namespace conddp
