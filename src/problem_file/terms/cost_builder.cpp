#include "problem_file/terms/cost_builder.hpp"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "ocp/residuals/weighted_residual.hpp"
#include "problem_file/model/named_phases.hpp"
#include "problem_file/residuals/residual_table.hpp"
#include "problem_file/terms/swing_reference.hpp"
#include "problem_file/terms/weight_matrix.hpp"

namespace conddp {
namespace {

/// "state, control and joint_velocity", for hints.
std::string list_with_limits() {
  std::vector<std::string_view> names;
  for (const ResidualDefinition* definition : residual_table())
    if (definition->has_limits) names.push_back(definition->name);
  const std::string_view last = names.back();
  names.pop_back();
  return fmt::format("{} and {}", fmt::join(names, ", "), last);
}

/// Sets the robot's limits for a residual as bounds of a barrier.
bool set_limits_of_robot(const CostSpec& cost, const CostResidual& residual, Activation& activation,
                         Diagnostics& out) {
  if (residual.lower.empty()) {
    out.error(cost.activation.place,
              fmt::format("a robot has no limits for the residual '{}'", cost.residual.value),
              fmt::format("'from: urdf' serves {}", list_with_limits()));
    return false;
  }
  if (cost.reference) {
    out.error(cost.reference->place, "limits from the URDF are absolute: leave the reference out");
    return false;
  }
  activation.lower = residual.lower;
  activation.upper = residual.upper;
  return true;
}

/// Sets the barrier's bounds: the robot's limits if requested, narrowed by those of the file.
bool set_barrier(const CostSpec& cost, const CostResidual& residual, Activation& activation,
                 Diagnostics& out) {
  const ActivationSpec& spec = cost.activation;
  const std::size_t n = residual.residual->size();
  activation.lower.assign(n, -kUnlimited);
  activation.upper.assign(n, kUnlimited);
  if (spec.from_urdf && !set_limits_of_robot(cost, residual, activation, out)) return false;
  const auto lower = resolve(spec.lower, residual.rows, -kUnlimited, out);
  if (!lower) return false;
  const auto upper = resolve(spec.upper, residual.rows, kUnlimited, out);
  if (!upper) return false;
  for (std::size_t i = 0; i < n; ++i) {
    activation.lower[i] = std::max(activation.lower[i], (*lower)[i]);
    activation.upper[i] = std::min(activation.upper[i], (*upper)[i]);
    if (activation.lower[i] <= activation.upper[i]) continue;
    out.error(spec.place,
              fmt::format("for '{}' the lower bound {} lies above the upper bound {}",
                          residual.rows.names[i], activation.lower[i], activation.upper[i]));
    return false;
  }
  return true;
}

std::optional<Activation> build_activation(const CostSpec& cost, const CostResidual& residual,
                                           const ContactCost& contact, Diagnostics& out) {
  Activation activation{.kind = cost.activation.kind, .epsilon = cost.activation.epsilon};
  activation.lower = contact.lower;
  activation.upper = contact.upper;
  if (activation.kind == ActivationKind::quadratic_barrier && contact.lower.empty() &&
      !set_barrier(cost, residual, activation, out))
    return std::nullopt;
  if (cost.weights) {
    const auto weights = resolve(*cost.weights, residual.rows, 1.0, out);
    if (!weights) return std::nullopt;
    // Unit weights change the rounding of sums, so they are omitted: equal problems are built
    // equally.
    if (std::any_of(weights->begin(), weights->end(), [](double w) { return w != 1; }))
      activation.weights = *weights;
  }
  return activation;
}

/// Applies the file's matrix to a cost's residual; false if it does not fit.
bool apply_matrix(const CostSpec& spec, CostResidual& residual, ContactCost& contact,
                  Diagnostics& out) {
  const auto matrix = resolve(*spec.matrix, residual, spec.residual.value, out);
  if (!matrix) return false;
  residual.residual = weighted_residual(residual.residual, *matrix);
  if (!contact.make) return true;
  contact.make = [make = std::move(contact.make), W = *matrix](const auto& system,
                                                               const auto& indices) {
    return weighted_residual(make(system, indices), W);
  };
  return true;
}

/// The variants of the phases where a function can be active.
std::vector<bool> variants_of(const CostSpec& function, const CostContext& context) {
  const Plant& plant = context.plant;
  std::vector<bool> on(plant.variants.size(), false);
  if (context.last_node) {
    on[plant.variant_at.back()] = true;
    return on;
  }
  const std::vector<bool> possible = possible_phases(function, context.spec);
  for (std::size_t p = 0; p < possible.size(); ++p) {
    if (!possible[p]) continue;
    on[plant.variant_at[p]] = true;
    if (function.ends.value) on[plant.variant_at[p + 1]] = true;
  }
  return on;
}

void add_cost(const CostSpec& spec, CostResidual residual, ContactCost contact,
              const CostContext& context, std::vector<BuiltCost>& costs, Diagnostics& out) {
  auto activation = build_activation(spec, residual, contact, out);
  auto reference =
      spec.keys.find(key::swing) != nullptr
          ? swing_reference(spec, residual, context.spec, context.contacts, context.plant,
                            context.states.initial(), context.times, out)
          : build_reference(spec, residual, context.plant, context.states, context.times, out);
  if (!activation || !reference) return;
  if (spec.matrix && !apply_matrix(spec, residual, contact, out)) return;
  costs.push_back({&spec, std::move(residual), std::move(contact), std::move(*activation),
                   std::move(*reference)});
}

/// True if the contacts of at least one cost are held at a node where it can be active.
bool is_ever_held(const CostSpec& spec, const std::vector<ContactCost>& costs,
                  const CostContext& context) {
  const ContactPlan& plan = context.contacts;
  const auto is_held = [&](std::size_t phase) {
    return std::ranges::any_of(costs, [&](const ContactCost& cost) {
      return plan.find(phase, cost.contacts).has_value();
    });
  };
  if (context.last_node) return is_held(plan.terminal());
  const std::vector<bool> possible = possible_phases(spec, context.spec);
  for (std::size_t p = 0; p < possible.size(); ++p)
    if (possible[p] && is_held(p)) return true;
  return false;
}

/// Adds a cost on each variant of the plant where it can be active; stops at the first error.
void add_variants(const CostSpec& spec, const CostContext& context, std::vector<BuiltCost>& costs,
                  Diagnostics& out) {
  const int errors = out.error_count();
  for (const PlantOfCost& own : plants_of(spec, context)) {
    auto residual = make_cost_residual(spec, context.spec, own.plant, context.ndx, out);
    const std::size_t count = costs.size();
    if (residual) add_cost(spec, std::move(*residual), {}, context, costs, out);
    if (costs.size() > count) costs.back().variant = own.variant;
    if (out.error_count() > errors) return;
  }
}

}  // namespace

std::vector<PlantOfCost> plants_of(const CostSpec& function, const CostContext& context) {
  const Plant& plant = context.plant;
  if (plant.variants.empty()) return {{{}, plant}};
  std::vector<PlantOfCost> plants;
  const std::vector<bool> on = variants_of(function, context);
  const bool chosen = context.last_node || function.phases || function.knots;
  for (std::size_t v = 0; v < on.size(); ++v) {
    const bool lacks_control =
        function.definition->needs.control && plant.variants[v].system->actuators() == 0;
    if (on[v] && (chosen || !lacks_control || plant.controls.empty()))
      plants.push_back({v, plant.variant(v)});
  }
  return plants;
}

std::vector<BuiltCost> build_costs(const std::vector<CostSpec>& specs, const CostContext& context,
                                   Diagnostics& out) {
  std::vector<BuiltCost> costs;
  for (const CostSpec& spec : specs) {
    if (is_on_contacts(spec) && context.plant.multibody()) {
      if (context.last_node && !spec.definition->of_contacts()) {
        out.error(spec.residual.place,
                  "the last node has no forces of contacts that an expression could read",
                  "give the rows to a running cost or constraint, with 'knots' or 'phases'");
        continue;
      }
      std::vector<ContactCost> contacts =
          make_contact_costs(spec, context.spec, context.contacts, context.plant, context.ndx, out);
      if (!contacts.empty() && !is_ever_held(spec, contacts, context))
        out.warning(spec.residual.place,
                    fmt::format("'{}' counts nowhere: where it could, its contacts are not held",
                                spec.name.value),
                    "phases hold contacts by their key, 'contacts: all'");
      for (ContactCost& contact : contacts) {
        CostResidual prototype = contact.prototype;
        add_cost(spec, std::move(prototype), std::move(contact), context, costs, out);
      }
      continue;
    }
    add_variants(spec, context, costs, out);
  }
  return costs;
}

std::vector<double> residual_parameters(const BuiltCost& cost, const NodeTime& time) {
  std::vector<double> parameters = reference_at(*cost.spec, cost.reference, time.written);
  if (cost.residual.time == TimeParameters::kTime) parameters.push_back(time.written);
  if (cost.residual.time == TimeParameters::kAll) time.append_to(parameters);
  return parameters;
}

void write_parameters(const BuiltCost& cost, const CostTerm& term, const NodeTime& time,
                      double weight, double* parameters) {
  const std::vector<double> own = residual_parameters(cost, time);
  std::copy(own.begin(), own.end(), parameters + term.parameters);
  parameters[term.weight] = weight;
}

}  // namespace conddp
