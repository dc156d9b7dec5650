#pragma once

#include "problem_file/spec/spec_values.hpp"
#include "problem_file/yaml/yaml_reader.hpp"

namespace conddp {

/// Readers of values that stand under many keys; each reports why it returns nothing.

std::optional<Vector3<double>> read_vector3(const YamlReader& reader, std::string_view what);
/// Of a key that may be left out; without a valid value `vector` stays as it is.
void read_vector3(YamlMap& map, std::string_view key, std::string_view what,
                  Vector3<double>& vector);
NamedNumbers read_named_numbers(const YamlReader& reader, const NumberRange& range = kAnyNumber);
std::optional<ComponentsSpec> read_components(const YamlReader& reader,
                                              const NumberRange& range = kAnyNumber);
/// The same of bounds, where null stands for none.
std::optional<ComponentsSpec> read_component_bounds(const YamlReader& reader);
/// Rows of numbers, or numbers by the names of their row and column.
std::optional<MatrixSpec> read_symmetric_matrix(const YamlReader& reader);
/// Factor that gives a vector of this length the length 1; 1 within rounding, so that what was
/// scaled once is not changed again.
double unit_scale(double length);
/// A key with a rotation in one of its forms: `orientation` (quaternion x y z w) or `rpy` (rad).
std::optional<Quaternion<double>> read_orientation(YamlMap& map);
std::optional<PoseSpec> read_pose(const YamlReader& reader);
std::optional<TwistSpec> read_twist(const YamlReader& reader);
std::optional<PlanarMotion> read_planar_motion(const YamlReader& reader);
/// `all`, a name, or a list of names.
ContactNames read_contact_names(const YamlReader& reader);

}  // namespace conddp
