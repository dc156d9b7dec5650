#include "problem_file/plant/library_builder.hpp"

#include <fmt/format.h>

namespace conddp {

std::shared_ptr<const LibraryKnotFunction> make_library_function(
    const std::shared_ptr<const SharedLibrary>& library, const LibraryFunctionSpec& spec,
    const LibraryFit& fit, Diagnostics& out) {
  using Part = LibraryKnotFunction::Defect::Part;
  std::vector<double> parameters;
  for (const auto& [name, value] : spec.parameters) parameters.push_back(value);
  std::optional<LibraryKnotFunction::Defect> defect;
  auto function =
      LibraryKnotFunction::make(library, spec.function.value, fit.sizes, parameters, defect);
  if (function) return function;
  const auto place = [&] {
    switch (defect->part) {
      case Part::kStates:
        return fit.states_place;
      case Part::kControls:
        return fit.controls_place;
      case Part::kParameters:
        return spec.parameters_place;
      case Part::kFunction:
        break;
    }
    return spec.function.place;
  };
  out.error(place(), defect->message, defect->hint);
  return nullptr;
}

std::shared_ptr<const System> build_library_system(const LibrarySystemSpec& spec,
                                                   Diagnostics& out) {
  const LibrarySystemColumns& columns = spec.columns;
  const LibraryFit fit = {
      .sizes = {.states = static_cast<int>(columns.states.size() + columns.velocities.size()),
                .controls = static_cast<int>(columns.controls.size())},
      .states_place = spec.states_place,
      .controls_place = spec.controls_place};
  auto function = make_library_function(spec.loaded, spec.function, fit, out);
  if (!function) return nullptr;
  const int rows = static_cast<int>(columns.states.size());
  if (function->rows() != rows) {
    out.error(spec.states_place, fmt::format("'{}' gives {} numbers, and the file has {} {}",
                                             spec.function.function.value, function->rows(), rows,
                                             columns.velocities.empty() ? "states" : "positions"));
    return nullptr;
  }
  if (columns.kind == SystemKind::discrete && function->reads_time()) {
    out.error(spec.function.function.place,
              "difference equations have no time, but this function has an input 't'",
              "give it a state that counts the steps");
    return nullptr;
  }
  return make_library_system(columns, std::move(function));
}

}  // namespace conddp
