#pragma once

#include "problem_file/spec/residual_definition.hpp"

namespace conddp {

/// The key `contacts` of residuals on contacts.
const ResidualKey& contacts_key();

}  // namespace conddp
