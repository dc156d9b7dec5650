#pragma once

#include "analysis/findings/diagnosis.hpp"
#include "base/json/json_text.hpp"
#include "output/solution/solution.hpp"

namespace conddp {

/// What was solved and how it ended, without the bulk: problem, tool, status, costs, residuals,
/// times, guess.
OrderedJson solution_head(const Solution& solution);

/// Which conddp it was: version, revision, build, libraries.
OrderedJson tool_json();

/// The whole of solution.json (schemas/solution.schema.json) but its certificate.
OrderedJson solution_json(const Solution& solution);

/// Adds the certificate to a document or a head.
void add_certificate(OrderedJson certificate, OrderedJson& document);

/// How many nulls a value is or holds.
int count_nulls(const OrderedJson& value);

/// How the solve went: pattern, sentence, knot, quantity and remedy.
OrderedJson diagnosis_json(const Diagnosis& diagnosis);

}  // namespace conddp
