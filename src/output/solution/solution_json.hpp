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

/// How numbers of the trajectory, of gains and of multipliers stand in a document: as lists, or as
/// blocks (number_block.hpp), which the certificate reads as well.
enum class NumberForm { kLists, kBlocks };

/// The whole of solution.json (schemas/solution.schema.json) but its certificate.
OrderedJson solution_json(const Solution& solution, NumberForm form = NumberForm::kLists);

/// Adds the certificate to a document or a head.
void add_certificate(OrderedJson certificate, OrderedJson& document);

/// How many nulls a value is or holds, or numbers in their place in blocks.
int count_nulls(const OrderedJson& value);

/// How the solve went: pattern, sentence, knot, quantity and remedy.
OrderedJson diagnosis_json(const Diagnosis& diagnosis);

}  // namespace conddp
