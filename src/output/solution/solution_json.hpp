#pragma once

#include "analysis/findings/diagnosis.hpp"
#include "base/json/json_text.hpp"
#include "output/solution/solution.hpp"

namespace conddp {

/// Description of a solve without its bulk data: problem, tool, status, costs, residuals, times,
/// guess.
OrderedJson solution_head(const Solution& solution);

/// Identification of conddp: version, revision, build, libraries.
OrderedJson tool_json();

/// The complete solution.json (schemas/solution.schema.json) without its certificate.
OrderedJson solution_json(const Solution& solution);

/// Columns, units and phases of a trajectory in a document.
OrderedJson motion_names(const BuiltProblem& built);

/// Adds the certificate to a document or a head.
void add_certificate(OrderedJson certificate, OrderedJson& document);

/// Number of nulls in a value.
int count_nulls(const OrderedJson& value);

/// Diagnosis of the solve: pattern, sentence, knot, quantity and remedy.
OrderedJson diagnosis_json(const Diagnosis& diagnosis);

}  // namespace conddp
