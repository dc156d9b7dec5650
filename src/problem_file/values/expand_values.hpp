#pragma once

#include "base/json/ordered_json.hpp"
#include "problem_file/spec/spec.hpp"

namespace conddp {

/// Expanders of values: each returns JSON that its reader reads as the same value.

OrderedJson expand_vector(const Vector3<double>& vector);
OrderedJson expand_quaternion(const Quaternion<double>& q);
OrderedJson expand_numbers(const NamedNumbers& numbers);
OrderedJson expand_components(const ComponentsSpec& spec);
OrderedJson expand_symmetric_matrix(const MatrixSpec& matrix);
OrderedJson expand_names(const std::vector<Name>& names);
OrderedJson expand_motion(const PlanarMotion& motion);
OrderedJson expand_data_file(const DataFileSpec& file);
/// The contacts' names; all names if the spec selects all.
OrderedJson expand_contact_names(const ContactNames& names, const ProblemSpec& spec);

}  // namespace conddp
