#pragma once

#include "problem_file/spec/spec_values.hpp"
#include "problem_file/yaml/yaml_reader.hpp"

namespace conddp {

/// Readers of values that many keys share; each reports why it returns nothing.

std::optional<Vector3<double>> read_vector3(const YamlReader& reader, std::string_view what);
NamedNumbers read_named_numbers(const YamlReader& reader, const NumberRange& range = kAnyNumber);
std::optional<ComponentsSpec> read_components(const YamlReader& reader,
                                              const NumberRange& range = kAnyNumber);
/// The same for bounds; null means unbounded.
std::optional<ComponentsSpec> read_component_bounds(const YamlReader& reader);
/// Rows of numbers, or numbers by the names of their row and column.
std::optional<MatrixSpec> read_symmetric_matrix(const YamlReader& reader);
/// Factor that scales a vector of this length to unit length; 1 within rounding, so that repeated
/// scaling changes nothing.
double unit_scale(double length);
std::optional<PlanarMotion> read_planar_motion(const YamlReader& reader);
/// `all`, a name, or a list of names.
ContactNames read_contact_names(const YamlReader& reader);

}  // namespace conddp
