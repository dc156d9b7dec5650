#include "problem_file/expand/expand_sections.hpp"

namespace conddp {
namespace {

OrderedJson expand_form(const CapsuleSpec& capsule) {
  return {{"capsule",
           {{"radius", capsule.radius},
            {"from", expand_vector(capsule.from)},
            {"to", expand_vector(capsule.to)}}}};
}

}  // namespace

OrderedJson expand_form(const SphereSpec& sphere) {
  return {{"sphere", {{"radius", sphere.radius}, {"center", expand_vector(sphere.center)}}}};
}

OrderedJson expand_form(const HalfSpaceSpec& half_space) {
  return {
      {"half_space",
       {{"normal", expand_vector(half_space.normal)}, {"point", expand_vector(half_space.point)}}}};
}

OrderedJson expand_collision(const CollisionSpec& collision) {
  const auto form = [](const auto& shape) {
    return std::visit([](const auto& f) { return expand_form(f); }, shape.form);
  };
  OrderedJson shapes = OrderedJson::object(), obstacles = OrderedJson::object();
  for (const ShapeSpec& shape : collision.shapes) {
    shapes[shape.name.value] = {{"frame", shape.frame.value}};
    shapes[shape.name.value].update(form(shape));
  }
  for (const ObstacleSpec& obstacle : collision.obstacles)
    obstacles[obstacle.name.value] = form(obstacle);
  return {{"shapes", std::move(shapes)}, {"obstacles", std::move(obstacles)}};
}

}  // namespace conddp
