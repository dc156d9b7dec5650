#include "problem_file/terms/constraint_builder.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "base/text/spelling.hpp"

namespace conddp {
namespace {

/// Narrows bounds by those of the file; an empty interval is reported for rows that satisfy
/// `counts`.
template <class Predicate>
bool narrow(const ConstraintSpec& constraint, const ComponentNames& rows, Predicate counts,
            std::vector<double>& lower, std::vector<double>& upper, Diagnostics& out) {
  const auto low = resolve(constraint.lower, rows, -kUnlimited, out);
  const auto up = resolve(constraint.upper, rows, kUnlimited, out);
  if (!low || !up) return false;
  for (std::size_t i = 0; i < lower.size(); ++i) {
    lower[i] = std::max(lower[i], (*low)[i]);
    upper[i] = std::min(upper[i], (*up)[i]);
    if (lower[i] <= upper[i] || !counts(static_cast<int>(i))) continue;
    out.error(
        constraint.function.name.place,
        fmt::format("no value of '{}' satisfies the constraint '{}': the lower bound is {}, the "
                    "upper one {}",
                    rows.names[i], constraint.function.name.value, lower[i], upper[i]));
    return false;
  }
  return true;
}

/// Index into the state of each tangent coordinate, −1 on curved parts.
std::vector<int> flat_indices(const StateManifold& manifold) {
  std::vector<int> indices(manifold.ndx(), -1);
  for (const auto& segment : manifold.segments())
    for (int i = 0; segment.part == StateManifold::Part::flat && i < segment.n; ++i)
      indices[segment.dx + i] = segment.x + i;
  return indices;
}

/// Multiplies the width of ranges and keeps their middles: ranges of positions need not contain 0.
void widen(double scale, std::vector<double>& lower, std::vector<double>& upper) {
  if (scale == 1) return;
  for (std::size_t i = 0; i < lower.size(); ++i) {
    if (std::isinf(lower[i]) || std::isinf(upper[i])) continue;
    const double middle = 0.5 * (lower[i] + upper[i]), half = 0.5 * (upper[i] - lower[i]);
    lower[i] = middle - scale * half;
    upper[i] = middle + scale * half;
  }
}

/// Soft bounds on the control, which solvers do not treat as control bounds.
std::optional<BuiltConstraint> build_soft_control_bounds(const ConstraintSpec& spec,
                                                         const CostContext& context,
                                                         const Plant& plant, Diagnostics& out) {
  if (spec.from_urdf && !plant.multibody()) {
    out.error(*spec.from_urdf, "a closed-form system has no URDF", "give 'lower' and 'upper'");
    return std::nullopt;
  }
  auto control = make_cost_residual(spec.function, context.spec, plant, context.ndx, out);
  if (!control) return std::nullopt;
  const std::size_t n = control->rows.names.size();
  BuiltConstraint built{.spec = &spec};
  built.lower.assign(n, -kUnlimited);
  built.upper.assign(n, kUnlimited);
  if (spec.from_urdf) {
    built.lower = control->lower;
    built.upper = control->upper;
    scale_efforts(spec.scale, built.lower, built.upper);
  }
  const auto all = [](int) { return true; };
  if (!narrow(spec, control->rows, all, built.lower, built.upper, out)) return std::nullopt;
  TimeSeries zero(control->parameters, std::vector<double>(n, 0.0));
  built.function = {&spec.function, std::move(*control), {}, {}, std::move(zero)};
  return built;
}

/// True if a system has the bounded quantity and the source of its bounds; reports an error
/// otherwise.
bool check_bounded(const ConstraintSpec& spec, const Plant& plant, Diagnostics& out) {
  const bool whole = spec.bounded->value == BoundedQuantity::kState;
  if (!whole && plant.system->kind() != SystemKind::second_order) {
    out.error(spec.bounded->place, "this system has no positions and velocities",
              "write 'bounds: state'");
    return false;
  }
  if (!spec.from_urdf || plant.multibody()) return true;
  out.error(*spec.from_urdf, "a closed-form system has no URDF", "give 'lower' and 'upper'");
  return false;
}

/// True if a quantity contains the tangent coordinate i. The first nv coordinates are positions.
bool has_coordinate(BoundedQuantity quantity, int i, int nv) {
  if (quantity == BoundedQuantity::kState) return true;
  return (quantity == BoundedQuantity::kVelocity) == (i >= nv);
}

/// Coordinates of the state that are bounded.
struct BoundedCoordinates {
  std::vector<int> indices;  ///< into the state
  std::vector<std::string> names;
  std::vector<double> lower, upper;

  void add(int index, const std::string& name, double low, double high) {
    if (std::isinf(low) && std::isinf(high)) return;
    indices.push_back(index);
    names.push_back(name);
    lower.push_back(low);
    upper.push_back(high);
  }
};

std::optional<BoundedCoordinates> bounded_coordinates(const ConstraintSpec& spec,
                                                      const CostResidual& state,
                                                      const System& system, Diagnostics& out) {
  std::vector<double> lower(system.ndx(), -kUnlimited), upper(system.ndx(), kUnlimited);
  const ComponentNames names = tangent_names(system);
  if (spec.from_urdf) {
    for (int i = 0, row = 0; i < system.ndx(); ++i) {
      if (!names.is_listed(i)) continue;
      lower[i] = state.lower[row];
      upper[i] = state.upper[row];
      ++row;
    }
    widen(spec.scale, lower, upper);
  }
  const std::vector<int> flat = flat_indices(system.manifold());
  const auto wanted = [&](int i) {
    return flat[i] >= 0 && system.has_state(flat[i]) &&
           has_coordinate(spec.bounded->value, i, system.nv());
  };
  if (!narrow(spec, names, wanted, lower, upper, out)) return std::nullopt;
  BoundedCoordinates bounded;
  for (int i = 0; i < system.ndx(); ++i)
    if (wanted(i)) bounded.add(flat[i], names.names[i], lower[i], upper[i]);
  return bounded;
}

/// Bounds on the coordinates of a plant's state that have one; may be empty.
std::optional<BuiltConstraint> build_state_bounds(const ConstraintSpec& spec,
                                                  const CostContext& context, const Plant& plant,
                                                  Diagnostics& out) {
  const System& system = *plant.system;
  if (!check_bounded(spec, plant, out)) return std::nullopt;
  const auto state = make_cost_residual(spec.function, context.spec, plant, context.ndx, out);
  if (!state) return std::nullopt;
  auto bounded = bounded_coordinates(spec, *state, system, out);
  if (!bounded) return std::nullopt;
  const int n = static_cast<int>(bounded->names.size());
  CostResidual chosen;
  chosen.indices = std::move(bounded->indices);
  chosen.rows = chosen.references = {"bounded coordinates", std::move(bounded->names)};
  chosen.parameters = StateManifold::flat(n);
  chosen.residual = coordinate_residual(system.manifold(), chosen.indices);
  TimeSeries zero(chosen.parameters, std::vector<double>(n, 0.0));
  BuiltConstraint built{.spec = &spec, .at_last_node = !spec.function.phases};
  built.lower = std::move(bounded->lower);
  built.upper = std::move(bounded->upper);
  built.function = {&spec.function, std::move(chosen), {}, {}, std::move(zero)};
  return built;
}

/// Replaces a contact's residual by A times its force in axes along its normal, which phases may
/// turn.
void set_force_rows(const Eigen::MatrixXd& A, const CostContext& context, BuiltCost& function) {
  function.contact.make = [ndx = context.ndx, A](
                              const std::shared_ptr<const MultibodySystem>& system,
                              const std::vector<int>& indices) {
    const Contact& contact = system->contacts().contacts()[indices.front()];
    const Matrix3<double> R = rotation_to_normal(contact.normal);
    Eigen::Matrix3d turned;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) turned(i, j) = R(j, i);
    LinearCone rows;
    rows.A = A * turned;
    return contact_cone_residual(system, indices.front(), ndx, rows);
  };
  function.residual.residual = make_prototype(function.contact, context.contacts, context.plant);
  function.residual.parameters = StateManifold::flat(0);
  function.reference = TimeSeries(function.residual.parameters, {});
}

/// The exact friction cone of a contact: (force along two tangents; μ times the normal force). Also
/// adds the limits of the normal force, if any.
void add_friction_cone(const ConstraintSpec& spec, const CostContext& context, BuiltCost function,
                       std::vector<BuiltConstraint>& list, Diagnostics& out) {
  const ContactSpec& contact = context.spec.contacts[function.contact.contacts.front()];
  if (contact.axes != FrameAxes::world_aligned) {
    if (!spec.function.definition->is_cone)  // a cone has reported it
      out.error(spec.function.residual.place,
                fmt::format("the friction cone of '{}' needs a normal that is fixed in the world",
                            contact.name.value),
                "give the contact 'axes: world'");
    return;
  }
  Eigen::MatrixXd A = Eigen::Matrix3d::Identity();
  const Eigen::MatrixXd normal = A.row(2);
  A.row(2) *= contact.friction * spec.function.keys.value(key::safety);
  BuiltConstraint cone{.spec = &spec, .kind = ConstraintKind::second_order_cone};
  cone.function = function;
  set_force_rows(A, context, cone.function);
  list.push_back(std::move(cone));
  if (!(contact.min_normal_force > 0) && std::isinf(contact.max_normal_force)) return;
  BuiltConstraint limits{.spec = &spec};
  limits.function = std::move(function);
  set_force_rows(normal, context, limits.function);
  limits.lower = {contact.min_normal_force};
  limits.upper = {contact.max_normal_force};
  list.push_back(std::move(limits));
}

/// Adds one constraint for each center; without centers the constraint itself.
void add_centers(const BuiltConstraint& constraint, std::vector<BuiltConstraint>& list,
                 Diagnostics& out) {
  if (constraint.spec->centers.empty()) return list.push_back(constraint);
  const CostResidual& residual = constraint.function.residual;
  for (const Located<std::vector<double>>& center : constraint.spec->centers) {
    if (static_cast<int>(center.value.size()) != residual.parameters.nx())
      return out.error(center.place, fmt::format("a center has {} here, not {}",
                                                 counted(residual.parameters.nx(), "number"),
                                                 center.value.size()));
    list.push_back(constraint);
    list.back().function.reference = TimeSeries(residual.parameters, center.value);
  }
}

/// The residual of a constraint; with centers its reference is initially the origin.
CostSpec function_of(const ConstraintSpec& spec) {
  CostSpec function = spec.function;
  if (spec.centers.empty()) return function;
  const Place& place = spec.centers.front().place;
  function.reference = ReferenceSpec{
      .place = place, .values = {*function.definition->reference->zero(function, place)}};
  return function;
}

/// Sets rows to the given numbers; rows without a number are free.
bool set_equal(BuiltConstraint& built, const ComponentNames& rows, Diagnostics& out) {
  const auto below = resolve(*built.spec->equals, rows, -kUnlimited, out);
  if (!below) return false;  // reports errors only once
  const auto above = resolve(*built.spec->equals, rows, kUnlimited, out);
  if (!above) return false;
  built.lower = *below;
  built.upper = *above;
  return true;
}

bool set_cone(BuiltConstraint& built, int rows, Diagnostics& out) {
  built.kind = ConstraintKind::second_order_cone;
  built.slope = built.spec->slope;
  if (rows >= 2) return true;
  out.error(built.spec->function.residual.place, "a cone needs a residual of two rows or more");
  return false;
}

/// Sets the kind and bounds of a constraint whose residual is built.
bool set_bounds(BuiltConstraint& built, Diagnostics& out) {
  const ConstraintSpec& spec = *built.spec;
  const CostResidual& residual = built.function.residual;
  const int n = residual.residual->size();
  if (spec.function.keys.value(key::cone)) return set_cone(built, n, out);
  if (spec.at_least || spec.at_most) {
    built.kind = ConstraintKind::norm;
    built.lower = {spec.at_least.value_or(-kUnlimited)};
    built.upper = {spec.at_most.value_or(kUnlimited)};
    return true;
  }
  if (!built.function.contact.lower.empty()) {
    built.lower = built.function.contact.lower;
    built.upper = built.function.contact.upper;
    return true;
  }
  if (is_zero(spec)) {
    built.lower.assign(n, 0.0);
    built.upper.assign(n, 0.0);
    return true;
  }
  if (spec.equals) return set_equal(built, residual.rows, out);
  built.lower.assign(n, -kUnlimited);
  built.upper.assign(n, kUnlimited);
  return narrow(
      spec, residual.rows, [](int) { return true; }, built.lower, built.upper, out);
}

}  // namespace

void scale_efforts(double scale, std::vector<double>& lower, std::vector<double>& upper) {
  for (std::vector<double>* bounds : {&lower, &upper})
    for (double& bound : *bounds) bound *= scale;
}

bool is_zero(const ConstraintSpec& c) {
  return !c.bounded && !c.equals && !c.lower && !c.upper && !c.at_least && !c.at_most &&
         !c.function.keys.value(key::cone) && !c.function.definition->is_cone;
}

namespace {

/// Adds bounds on the state or control for each variant of the plant that has any.
void add_bounds(const ConstraintSpec& spec, const CostContext& context,
                std::vector<BuiltConstraint>& list, Diagnostics& out) {
  const auto build = spec.bounded->value == BoundedQuantity::kControl ? build_soft_control_bounds
                                                                      : build_state_bounds;
  const std::size_t count = list.size();
  for (const PlantOfCost& own : plants_of(spec.function, context)) {
    auto built = build(spec, context, own.plant, out);
    if (!built) return;
    built->function.variant = own.variant;
    if (!built->lower.empty()) list.push_back(std::move(*built));
  }
  if (list.size() > count) return;
  out.error(spec.bounded->place, "no coordinate of the state is bounded here",
            spec.from_urdf ? "the URDF limits none of them: give 'lower' and 'upper'"
                           : "rotations and floating bases have no coordinates to bound; name "
                             "others");
}

/// Adds the constraints of a residual: several on contacts, or one for each center.
void add_constraints(const ConstraintSpec& spec, const CostContext& context,
                     std::vector<BuiltConstraint>& list, Diagnostics& out) {
  for (BuiltCost& function : build_costs({function_of(spec)}, context, out)) {
    function.spec = &spec.function;
    if (function.contact.make && spec.function.keys.value(key::cone)) {
      add_friction_cone(spec, context, std::move(function), list, out);
      continue;
    }
    BuiltConstraint built{.spec = &spec};
    built.function = std::move(function);
    if (set_bounds(built, out)) add_centers(built, list, out);
  }
}

}  // namespace

namespace {

/// The largest finite number among bounds and the initial reference.
double largest_number(const BuiltConstraint& constraint) {
  double largest = 0;
  const auto meet = [&](const std::vector<double>& numbers) {
    for (const double a : numbers)
      if (std::isfinite(a)) largest = std::max(largest, std::abs(a));
  };
  meet(constraint.lower);
  meet(constraint.upper);
  const TimeSeries& reference = constraint.function.reference;
  if (!reference.empty()) meet(reference.interpolate(0));
  return largest;
}

/// Warns of a constraint whose bounds are smaller than the allowed violation.
void warn_of_tolerance(const BuiltConstraint& constraint, double tolerance, Diagnostics& out) {
  const double largest = largest_number(constraint);
  if (constraint.spec->softness != Softness::hard || largest == 0 || largest > tolerance) return;
  const Name& name = constraint.spec->function.name;
  out.warning(name.place,
              fmt::format("what bounds '{}' is {:.3g} at most, no more than the tolerance of "
                          "violations, {:.3g}",
                          name.value, largest, tolerance),
              "take a unit in which it is larger, or set solver.tolerances.constraint");
}

}  // namespace

std::vector<BuiltConstraint> build_constraints(const std::vector<ConstraintSpec>& specs,
                                               const CostContext& context, Diagnostics& out) {
  std::vector<BuiltConstraint> list;
  for (const ConstraintSpec& spec : specs) {
    if (spec.bounded)
      add_bounds(spec, context, list, out);
    else
      add_constraints(spec, context, list, out);
  }
  for (const BuiltConstraint& built : list)
    warn_of_tolerance(built, context.spec.solver.options.tolerances.constraint, out);
  return list;
}

namespace {

RowsByDuration rows_by_duration(const BuiltConstraint& constraint) {
  const int rows =
      constraint.kind == ConstraintKind::norm ? 1 : constraint.function.residual.residual->size();
  return conddp::rows_by_duration(constraint.kind, rows, constraint.lower, constraint.upper);
}

}  // namespace

ConstraintTerm make_term(const BuiltConstraint& constraint,
                         std::shared_ptr<const Residual> residual,
                         const std::optional<DurationColumn>& duration) {
  ConstraintTerm term =
      make_constraint(constraint.spec->function.name.value, std::move(residual), constraint.kind,
                      constraint.slope, constraint.spec->softness);
  if (!duration || term.softness != Softness::l1) return term;
  const RowsByDuration rows = rows_by_duration(constraint);
  return rows.rows.empty() ? term : by_duration(term, rows, *duration);
}

void write_parameters(const BuiltConstraint& constraint, const ConstraintTerm& term,
                      const NodeTime& time, bool active, double* parameters) {
  const std::vector<double> own = residual_parameters(constraint.function, time);
  double* to = std::copy(own.begin(), own.end(), parameters + term.parameters);
  const std::vector<double>*lower = &constraint.lower, *upper = &constraint.upper;
  RowsByDuration rows;
  if (term.by_duration) {
    rows = rows_by_duration(constraint);
    std::copy(rows.offsets.begin(), rows.offsets.end(), to);
    lower = &rows.lower;
    upper = &rows.upper;
  }
  std::copy(lower->begin(), lower->end(), parameters + term.lower());
  std::copy(upper->begin(), upper->end(), parameters + term.upper());
  parameters[term.active()] = active ? 1 : 0;
  if (term.softness != Softness::hard) parameters[term.weight()] = constraint.spec->weight;
}

}  // namespace conddp
