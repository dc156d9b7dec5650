#include "problem_file/terms/reference_builder.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "base/text/spelling.hpp"

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

  /// Warns of positions outside the joint limits; true if there are any. Zeros are skipped, because
  /// they may stand for missing joints, and the initial state has already been checked.
  bool check_limits(const ReferenceValueSpec& spec, const std::vector<double>& value) const {
    if (!cost_.definition->of_positions) return false;
    if (spec.name && spec.name->value == "initial") return false;
    return states_.check_limits(fmt::format("the reference of '{}'", cost_.name.value),
                                state_of(value),
                                [&](const std::string& joint) { return place_of(joint, spec); });
  }

  /// The default for a missing reference.
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
  /// The state with the entries of a reference; other entries and zeros are NaN.
  std::vector<double> state_of(const std::vector<double>& value) const {
    std::vector<double> x(plant_.system->manifold().nx(), std::nan(""));
    for (std::size_t i = 0; i < value.size(); ++i) {
      const std::size_t entry = residual_.indices.empty() ? i : residual_.indices[i];
      if (entry < x.size() && value[i] != 0) x[entry] = value[i];
    }
    return x;
  }

  /// Place of a joint's position in a reference.
  static Place place_of(const std::string& joint, const ReferenceValueSpec& spec) {
    Place place = spec.place;
    if (spec.components) look_up(joint, spec.components->map, place);
    if (spec.state) look_up(joint, spec.state->joints, place);
    return place;
  }
  template <class Named>
  static void look_up(const std::string& joint, const Named& named, Place& place) {
    for (const auto& [name, number] : named)
      if (name.value == joint || name.value == "q/" + joint) place = name.place;
  }

  Numbers from_components(const ComponentsSpec& spec) const {
    Numbers numbers = resolve(spec, residual_.references, 0.0, out_);
    if (numbers && !residual_.parameters.normalize(numbers->data())) {
      out_.error(spec.place, "a quaternion of the state does not have length 1");
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

/// The columns of a file that hold a reference: the named columns, otherwise the quantity's own.
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

/// Indices of columns in a table; missing columns are reported.
std::optional<std::vector<std::size_t>> indices_of(const std::vector<std::string>& columns,
                                                   const DataFileSpec& file, const DataTable& table,
                                                   Diagnostics& out) {
  std::vector<std::size_t> indices;
  for (const std::string& column : columns) {
    if (const auto index = table.find(column))
      indices.push_back(*index);
    else
      out.error(file.file.place, fmt::format("'{}' has no column '{}'", file.file.value, column),
                name_hint(column, table.columns, "its columns"));
  }
  if (indices.size() < columns.size()) return std::nullopt;
  return indices;
}

/// The cells of a row in these columns; empty if a cell is empty.
std::optional<std::vector<double>> cells(const std::vector<std::optional<double>>& row,
                                         const std::vector<std::size_t>& columns) {
  std::vector<double> values;
  for (const std::size_t i : columns) {
    if (!row[i]) return std::nullopt;
    values.push_back(*row[i]);
  }
  return values;
}

}  // namespace

std::optional<TimeSeries> series_of(const DataFileSpec& file, const DataTable& table,
                                    const std::vector<std::string>& columns,
                                    const StateManifold& manifold, Diagnostics& out) {
  const auto indices = indices_of(columns, file, table, out);
  if (!indices) return std::nullopt;
  TimeSeries series(manifold);
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    auto value = cells(table.rows[row], *indices);
    if (!value) continue;
    if (!manifold.normalize(value->data())) {
      out.error(file.file.place,
                fmt::format("'{}' has a quaternion whose length is not 1 at t = {}",
                            file.file.value, table.times[row]));
      return std::nullopt;
    }
    series.append(table.times[row], *std::move(value));
  }
  if (!series.empty()) return series;
  out.error(file.file.place, fmt::format("'{}' has no complete row", file.file.value));
  return std::nullopt;
}

namespace {

std::optional<TimeSeries> reference_from_file(const CostSpec& cost, const CostResidual& residual,
                                              Diagnostics& out) {
  const DataFileSpec& file = *cost.reference->file;
  const auto columns = file_columns(cost, residual, out);
  if (!columns) return std::nullopt;
  const auto table = load_data_table(file.path, file.file.place, out);
  if (!table) return std::nullopt;
  return series_of(file, *table, *columns, residual.parameters, out);
}

/// Time of a way-point, s.
double time_of(const ReferenceSpec& spec, std::size_t i, const std::vector<double>& times) {
  if (spec.knots.empty()) return spec.times.empty() ? 0.0 : spec.times[i].value;
  return times[spec.knots[i].value];
}

/// A single value, or way-points.
std::optional<TimeSeries> reference_from_values(const ReferenceBuilder& builder,
                                                const ReferenceSpec& spec,
                                                const StateManifold& manifold,
                                                const std::vector<double>& times) {
  TimeSeries series(manifold);
  bool complete = true, outside = false;
  for (std::size_t i = 0; i < spec.values.size(); ++i) {
    const auto value = builder.value(spec.values[i]);
    complete &= value.has_value();
    if (!value) continue;
    outside = outside || builder.check_limits(spec.values[i], *value);
    series.append(time_of(spec, i, times), *value);
  }
  if (!complete) return std::nullopt;
  return series;
}

/// Warns of a reference that lies almost entirely after the end of the motion, as with times in ms.
void check_times(const TimeSeries& series, const CostSpec& cost, double end, Diagnostics& out) {
  const std::vector<double>& times = series.times();
  const auto within = std::ranges::count_if(times, [&](double t) { return t <= end; });
  if (within > 1 || times.size() - within < 2) return;
  out.warning(cost.reference->place,
              fmt::format("of the {} times of this reference {} within the motion, which ends at "
                          "{:.6g} s: the next one is {:.6g} s",
                          times.size(), within == 1 ? "one lies" : "none lies", end, times[within]),
              "times are in s");
}

}  // namespace

std::optional<TimeSeries> build_reference(const CostSpec& cost, const CostResidual& residual,
                                          const Plant& plant, const StateBuilder& states,
                                          const std::vector<double>& times, Diagnostics& out) {
  const ReferenceBuilder builder(cost, residual, plant, states, out);
  if (!cost.reference) {
    const auto value = builder.absent();
    if (!value) return std::nullopt;
    return TimeSeries(residual.parameters, *value);
  }
  auto series = cost.reference->file
                    ? reference_from_file(cost, residual, out)
                    : reference_from_values(builder, *cost.reference, residual.parameters, times);
  if (series) check_times(*series, cost, times.back(), out);
  return series;
}

std::vector<double> reference_at(const CostSpec& cost, const TimeSeries& reference, double time) {
  const ReferenceForm* form = cost.definition->reference;
  return form != nullptr && form->holds ? reference.hold(time) : reference.interpolate(time);
}

}  // namespace conddp
