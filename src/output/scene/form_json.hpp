#pragma once

#include "base/json/ordered_json.hpp"
#include "ocp/residuals/residuals.hpp"
#include "problem_file/model/spec_collision.hpp"
#include "problem_file/model/spec_terrain.hpp"

namespace conddp {

OrderedJson coordinates_json(const Vector3<double>& v);

/// The form of a shape, in its own axes: kind and numbers, see scene_obstacles.hpp.
OrderedJson form_json(const SphereSpec& sphere);
OrderedJson form_json(const CapsuleSpec& capsule);
OrderedJson form_json(const HalfSpaceSpec& half_space);
OrderedJson form_json(const Polytope& polytope);
OrderedJson form_json(const HeightMapSpec& map);
OrderedJson form_json(const BoxSpec& box);
OrderedJson form_json(const CylinderSpec& cylinder);
OrderedJson form_json(const HullSpec& hull);

}  // namespace conddp
