#include <algorithm>

#include <fmt/format.h>

#include "ocp/residuals/library_residual.hpp"
#include "problem_file/data/library_file.hpp"
#include "problem_file/plant/library_builder.hpp"
#include "problem_file/residuals/cost_residual.hpp"
#include "problem_file/residuals/reference_form.hpp"
#include "problem_file/residuals/residual_keys.hpp"
#include "problem_file/residuals/residual_table.hpp"
#include "systems/system.hpp"

namespace conddp {
namespace {

const Key<Name> kLibrary{"library"};
const Key<Name> kFunction{"function"};
const Key<NamedNumbers> kParameters{"parameters", NamedNumbers()};

/// Indices of the function's inputs in a knot of the plant's system.
LibraryInputs inputs_of(const ResidualContext& context) {
  const System& system = *context.plant.system;
  const auto& columns = system.state_columns();
  const auto clock = std::find_if(columns.begin(), columns.end(),
                                  [](const Column& column) { return column.name == kClock; });
  return {.states = own_states(system),
          .clock = clock != columns.end() ? static_cast<int>(clock - columns.begin()) : -1,
          .ndx = context.ndx};
}

std::shared_ptr<const LibraryKnotFunction> find_function(const ResidualContext& context,
                                                         const LibraryInputs& inputs) {
  const CostSpec& cost = context.cost;
  const Name library = cost.keys.value(kLibrary);
  const auto loaded = load_library_file(context.spec.file.parent_path(), library, context.out);
  if (!loaded) return nullptr;
  const LibraryFunctionSpec spec = {.library = library,
                                    .function = cost.keys.value(kFunction),
                                    .parameters = cost.keys.value(kParameters),
                                    .parameters_place = cost.residual.place};
  const LibraryFit fit = {.sizes = {.states = static_cast<int>(inputs.states.size()),
                                    .controls = context.plant.actuated().nu()},
                          .states_place = spec.function.place,
                          .controls_place = spec.function.place};
  return make_library_function(loaded, spec, fit, context.out);
}

std::optional<CostResidual> make_library(const ResidualContext& context) {
  const auto fail = [&](std::string message, std::string hint) {
    context.out.error(context.cost.keys.value(kFunction).place, std::move(message),
                      std::move(hint));
    return std::nullopt;
  };
  if (!context.plant.system->manifold().curved().empty())
    return fail("a compiled function is of states that are numbers, without rotations in space",
                "expressions can have rotations: 'residual: expression'");
  const LibraryInputs inputs = inputs_of(context);
  const auto function = find_function(context, inputs);
  if (!function) return std::nullopt;
  CostResidual result;
  result.residual = make_library_residual(function, inputs);
  if (!result.residual)
    return fail("the Jacobian of the function is too large for a residual",
                "make several functions of it, each a residual of its own");
  if (function->reads_time() && inputs.clock < 0) result.time = TimeParameters::kTime;
  if (result.time != TimeParameters::kNone && context.spec.first_free_duration() != nullptr)
    return fail("where durations are free, the time 't' of a knot is not given",
                "give the system a state that counts the time: its rate is 1");
  std::vector<std::string> rows;
  for (int row = 1; row <= function->rows(); ++row) rows.push_back(std::to_string(row));
  result.rows = result.references = {"rows", std::move(rows)};
  result.parameters = StateManifold::flat(function->rows());
  return result;
}

}  // namespace

std::span<const ResidualDefinition> library_residuals() {
  static const ResidualKey library = residual_key(
      kLibrary, {.says = "For library: a shared library of compiled code (--allow-code)"},
      NameForm{}, {.required = true});
  static const ResidualKey function =
      residual_key(kFunction, {.says = "For library: the function of x, u, p and t, with its jac_"},
                   NameForm{}, {.required = true});
  static const ResidualKey parameters = residual_key(
      kParameters, {.says = "For library: the numbers of the function's input p, in order"},
      NamedNumbersForm{});
  static const ResidualDefinition all[] = {
      {.name = "library",
       .description = "a compiled function of the state, the control and the time",
       .unit = "same as the function",
       .synonyms = {"casadi", "external", "compiled"},
       .needs = {.code = true},
       .keys = {&library, &function, &parameters},
       .reference = &kRowsReference,
       .is_point = [](const CostSpec&) { return true; },
       .make = make_library}};
  return all;
}

}  // namespace conddp
