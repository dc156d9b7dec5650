#include "problem_file/build/reference_builder.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "base/spelling.hpp"

namespace conddp {
namespace {

using Numbers = std::optional<std::vector<double>>;

class ReferenceBuilder {
 public:
  ReferenceBuilder(const CostSpec& cost, const CostResidual& residual, const Plant& plant,
                   const StateBuilder& states, Diagnostics& out)
      : cost_(cost), residual_(residual), plant_(plant), states_(states), out_(out) {}

  Numbers value(const ReferenceValueSpec& spec) const {
    if (spec.name) {
      const Numbers state = states_.named(*spec.name);
      return state ? Numbers(residual_.in_state(*state)) : std::nullopt;
    }
    if (spec.state) {
      const Numbers state = states_.build(*spec.state);
      return state ? Numbers(residual_.in_state(*state)) : std::nullopt;
    }
    if (spec.components) return from_components(*spec.components);
    if (spec.twist) {
      const auto& [linear, angular] = std::pair(spec.twist->linear, spec.twist->angular);
      return std::vector{linear.x, linear.y, linear.z, angular.x, angular.y, angular.z};
    }
    return cost_.definition->reference->numbers(*spec.pose, out_);
  }

  /// Warns of positions outside of the joints' limits; whether there are any. Zero may stand for a
  /// joint that is not mentioned, and the initial state has been looked at.
  bool check_limits(const ReferenceValueSpec& spec, const std::vector<double>& value) const {
    if (!cost_.definition->of_positions) return false;
    if (spec.name && spec.name->value == "initial") return false;
    std::vector<double> x(plant_.system->manifold().nx(), std::nan(""));
    for (std::size_t i = 0; i < value.size(); ++i) {
      const std::size_t entry = residual_.indices.empty() ? i : residual_.indices[i];
      if (entry < x.size() && value[i] != 0) x[entry] = value[i];
    }
    const auto place_of = [&](const std::string& joint) {
      Place place = spec.place;
      const auto look = [&](const auto& named) {
        for (const auto& [name, number] : named)
          if (name.value == joint || name.value == "q/" + joint) place = name.place;
      };
      if (spec.components) look(spec.components->map);
      if (spec.state) look(spec.state->joints);
      return place;
    };
    return states_.check_limits(fmt::format("the reference of '{}'", cost_.name.value), x,
                                place_of);
  }

  /// What stands for a reference that the file leaves out.
  Numbers absent() const {
    using Needed = ReferenceForm::Needed;
    const ReferenceForm* form = cost_.definition->reference;
    const Needed needed = form != nullptr ? form->needed : Needed::kNever;
    const bool barrier = cost_.activation.kind == ActivationKind::quadratic_barrier;
    if (needed == Needed::kAlways || (needed == Needed::kWithoutBarrier && !barrier)) {
      out_.error(cost_.name.place, fmt::format("'{}' needs a reference", cost_.name.value),
                 "a configuration's name, 'initial', or numbers");
      return std::nullopt;
    }
    return residual_.parameters.neutral();
  }

 private:
  Numbers from_components(const ComponentsSpec& spec) const {
    Numbers numbers = resolve(spec, residual_.references, 0.0, out_);
    if (numbers && !residual_.parameters.normalize(numbers->data())) {
      out_.error(spec.place, "a quaternion of the state has not length 1");
      return std::nullopt;
    }
    return numbers;
  }

  const CostSpec& cost_;
  const CostResidual& residual_;
  const Plant& plant_;
  const StateBuilder& states_;
  Diagnostics& out_;
};

/// The columns of a file that hold a reference: those named, else those of the quantity itself.
std::optional<std::vector<std::string>> file_columns(const CostSpec& cost,
                                                     const CostResidual& residual,
                                                     Diagnostics& out) {
  const DataFileSpec& file = *cost.reference->file;
  const std::size_t count = residual.parameters.nx();
  std::vector<std::string> columns;
  if (!file.columns.empty()) {
    for (const Name& name : file.columns) columns.push_back(name.value);
    if (columns.size() == count) return columns;
    out.error(file.file.place, fmt::format("the cost '{}' takes {} columns, not {}",
                                           cost.name.value, count, columns.size()));
    return std::nullopt;
  }
  if (!residual.columns.empty()) return residual.columns;
  out.error(file.file.place, fmt::format("say which {} columns of the file to use", count),
            "columns: [...]");
  return std::nullopt;
}

}  // namespace

std::optional<TimeSeries> series_of(const DataFileSpec& file, const DataTable& table,
                                    const std::vector<std::string>& columns,
                                    const StateManifold& manifold, Diagnostics& out) {
  std::vector<std::size_t> indices;
  bool complete = true;
  for (const std::string& column : columns) {
    const auto index = table.find(column);
    if (index) {
      indices.push_back(*index);
      continue;
    }
    out.error(file.file.place, fmt::format("'{}' has no column '{}'", file.file.value, column),
              name_hint(column, table.columns, "its columns"));
    complete = false;
  }
  if (!complete) return std::nullopt;
  TimeSeries series(manifold);
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    std::vector<double> value;
    for (const std::size_t i : indices)
      if (table.rows[row][i]) value.push_back(*table.rows[row][i]);
    if (value.size() != indices.size()) continue;
    if (!manifold.normalize(value.data())) {
      out.error(file.file.place,
                fmt::format("'{}' has a quaternion that has not length 1 at t = {}",
                            file.file.value, table.times[row]));
      return std::nullopt;
    }
    series.append(table.times[row], std::move(value));
  }
  if (!series.empty()) return series;
  out.error(file.file.place, fmt::format("'{}' has no complete row", file.file.value));
  return std::nullopt;
}

std::optional<TimeSeries> build_reference(const CostSpec& cost, const CostResidual& residual,
                                          const Plant& plant, const StateBuilder& states,
                                          const std::vector<double>& times, Diagnostics& out) {
  const ReferenceBuilder builder(cost, residual, plant, states, out);
  const StateManifold& manifold = residual.parameters;
  if (!cost.reference) {
    const auto value = builder.absent();
    if (!value) return std::nullopt;
    return TimeSeries(manifold, *value);
  }
  const ReferenceSpec& spec = *cost.reference;
  if (spec.file) {
    const auto columns = file_columns(cost, residual, out);
    if (!columns) return std::nullopt;
    const auto table = load_data_table(spec.file->path, spec.file->file.place, out);
    if (!table) return std::nullopt;
    return series_of(*spec.file, *table, *columns, manifold, out);
  }
  TimeSeries series(manifold);
  bool complete = true, outside = false;
  for (std::size_t i = 0; i < spec.values.size(); ++i) {
    double time = spec.times.empty() ? 0.0 : spec.times[i].value;
    if (!spec.knots.empty()) {
      const Located<int>& knot = spec.knots[i];
      if (knot.value >= static_cast<int>(times.size())) {
        out.error(knot.place, fmt::format("knot {} lies behind the last one, {}", knot.value,
                                          times.size() - 1));
        complete = false;
        continue;
      }
      time = times[knot.value];
    }
    const auto value = builder.value(spec.values[i]);
    complete &= value.has_value();
    if (!value) continue;
    outside = outside || builder.check_limits(spec.values[i], *value);
    series.append(time, *value);
  }
  if (!complete) return std::nullopt;
  return series;
}

std::vector<double> reference_at(const CostSpec& cost, const TimeSeries& reference, double time) {
  const ReferenceForm* form = cost.definition->reference;
  return form != nullptr && form->holds ? reference.hold(time) : reference.interpolate(time);
}

}  // namespace conddp
