#include "output/bench/bench_runs.hpp"

#include "base/json/json_document.hpp"

namespace conddp {
namespace {

/// A table has one line per run.
constexpr std::size_t kMaxRuns = 500;

const OrderedJson& object_of(const OrderedJson& json, const char* key) {
  const OrderedJson& value = solution_member(json, key);
  if (!value.is_object()) throw MalformedSolution{fmt::format("'{}' is not an object", key)};
  return value;
}

void check_run(const OrderedJson& run) {
  for (const char* key : {"problem", "solver", "status"}) solution_text(run, key);
  if (!run.contains("iterations")) return;  // unsupported problem
  for (const char* key : {"time_s", "residuals"}) object_of(run, key);
}

}  // namespace

OrderedJson bench_runs(const OrderedJson& bench, const std::set<std::string>& problems) {
  OrderedJson runs = OrderedJson::array();
  for (const OrderedJson& run : solution_list(bench, "runs")) {
    check_run(run);
    if (!problems.contains(solution_text(run, "problem"))) continue;
    if (runs.size() == kMaxRuns)
      throw MalformedSolution{
          fmt::format("it has more than {} runs on the problems of this page", kMaxRuns)};
    runs.push_back(run);
  }
  if (runs.empty()) throw MalformedSolution{"it has no run on a problem of this page"};
  OrderedJson result = OrderedJson::object();
  for (const char* key : {"machine", "request"}) result[key] = object_of(bench, key);
  result["runs"] = std::move(runs);
  return result;
}

}  // namespace conddp
