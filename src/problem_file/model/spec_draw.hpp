#pragma once

#include <optional>
#include <variant>
#include <vector>

#include "problem_file/model/spec_collision.hpp"
#include "problem_file/model/spec_expression.hpp"

namespace conddp {

/// Something that reports draw: a shape or a dot at a place, a line, or a shape fixed in the world.
struct DrawingSpec {
  Name name;
  std::variant<std::monostate, SphereSpec, CapsuleSpec, BoxSpec, CylinderSpec, HullSpec> shape;
  std::optional<ExpressionText> at;     ///< x, y (m), also z, or a pose
  std::optional<ExpressionText> angle;  ///< about its z axis, rad
  std::vector<ExpressionText> line;     ///< corners: x, y, or x, y, z, m
  std::optional<std::vector<Name>> phases;

  bool has_shape() const { return shape.index() > 0; }
};

}  // namespace conddp
