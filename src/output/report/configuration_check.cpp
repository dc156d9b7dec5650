#include "output/report/configuration_check.hpp"

#include <fmt/format.h>

#include "problem_file/expand/expand_problem.hpp"

namespace conddp {

Check configuration_check(const OrderedJson& claimed, const ProblemSpec& spec,
                          const BuiltProblem& built) {
  OrderedJson actual = expand_problem(spec, built);
  if (claimed == actual) return {"configuration", true};
  OrderedJson answer = claimed;
  for (OrderedJson* json : {&answer, &actual}) {
    if (json->is_object()) json->erase("initial_guess");
    // Numbers are rounded as in the file, because its text is compared.
    *json = OrderedJson::parse(json->dump());
  }
  const OrderedJson patch = OrderedJson::diff(actual, answer);
  Check check{"configuration", patch.empty()};
  if (!patch.empty())
    check.message = "differs from the problem at " + patch[0]["path"].get<std::string>();
  if (patch.size() > 1) check.message += fmt::format(" and {} more places", patch.size() - 1);
  return check;
}

}  // namespace conddp
