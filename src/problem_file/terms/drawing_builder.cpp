#include "problem_file/terms/drawing_builder.hpp"

#include <fmt/format.h>

#include "base/text/spelling.hpp"
#include "problem_file/residuals/residual_table.hpp"

namespace conddp {
namespace {

ConstraintSpec constraint_of(const DrawnText& drawn, const DrawingSpec& drawing) {
  ConstraintSpec constraint;
  CostSpec& function = constraint.function;
  function.name = {drawn.name, drawn.text->place};
  function.where.kind = TermPlace::Kind::kDrawing;
  function.residual = {drawn.key, drawn.text->place};
  function.definition = find_residual("expression");
  function.keys.set(key::expression_rows, ExpressionRowsSpec{{*drawn.text}, {}});
  function.phases = drawing.phases;
  return constraint;
}

/// Reports an expression with a number of values that its key does not take.
void check_size(const CostSpec& function, int size, Diagnostics& out) {
  const std::string& key = function.residual.value;
  const bool is_angle = key == "angle", is_place = key == "at";
  if (is_angle ? size == 1 : size == 2 || size == 3 || (size == 7 && is_place)) return;
  out.error(function.name.place,
            fmt::format("this has {}", counted(static_cast<std::size_t>(size), "number")),
            is_angle   ? "an angle is one number, rad"
            : is_place ? "a place is [x, y], [x, y, z] or, with a quaternion, [x, y, z, q]"
                       : "a corner is [x, y] or [x, y, z]");
}

}  // namespace

std::vector<DrawnText> drawn_texts(const DrawingSpec& drawing) {
  std::vector<DrawnText> texts;
  const std::string& name = drawing.name.value;
  if (drawing.at) texts.push_back({"at", name + "/at", &*drawing.at});
  if (drawing.angle) texts.push_back({"angle", name + "/angle", &*drawing.angle});
  for (std::size_t i = 0; i < drawing.line.size(); ++i)
    texts.push_back({"line", fmt::format("{}/line/{}", name, i), &drawing.line[i]});
  return texts;
}

std::vector<ConstraintSpec> drawn_constraints(const std::vector<DrawingSpec>& drawings) {
  std::vector<ConstraintSpec> constraints;
  for (const DrawingSpec& drawing : drawings)
    for (const DrawnText& drawn : drawn_texts(drawing))
      constraints.push_back(constraint_of(drawn, drawing));
  return constraints;
}

std::vector<BuiltConstraint> build_drawn(const std::vector<ConstraintSpec>& drawn,
                                         const CostContext& context, Diagnostics& out) {
  std::vector<BuiltConstraint> list = build_constraints(drawn, context, out);
  for (BuiltConstraint& built : list) {
    const Residual& residual = *built.function.residual.residual;
    check_size(built.spec->function, residual.size(), out);
    built.at_last_node = !built.spec->function.phases && !residual.needs_control();
  }
  return list;
}

}  // namespace conddp
