#include "output/solution/log_columns.hpp"

namespace conddp {
namespace {

using Row = IterationRecord;

constexpr LogColumn kColumns[] = {
    {"iteration", "", true, [](const Row& r) -> double { return r.iteration; }},
    {"cost", "", false, [](const Row& r) { return r.cost; }},
    {"merit", "", false, [](const Row& r) { return r.merit; }},
    {"stationarity", "", false, [](const Row& r) { return r.stationarity; }},
    {"stationarity_knot", "", true, [](const Row& r) -> double { return r.stationarity_knot; }},
    {"gap", "", false, [](const Row& r) { return r.gap; }},
    {"gap_knot", "", true, [](const Row& r) -> double { return r.gap_knot; }},
    {"constraint", "", false, [](const Row& r) { return r.constraint; }},
    {"step", "", false, [](const Row& r) { return r.step; }},
    {"regularization", "", false, [](const Row& r) { return r.regularization; }},
    {"penalty", "", false, [](const Row& r) { return r.penalty; }},
    {"expected_decrease", "", false, [](const Row& r) { return r.expected_decrease; }},
    {"actual_decrease", "", false, [](const Row& r) { return r.actual_decrease; }},
    {"trials", "", true, [](const Row& r) -> double { return r.trials; }},
    {"sweeps", "", true, [](const Row& r) -> double { return r.sweeps; }},
    {"clamped_controls", "", true, [](const Row& r) -> double { return r.clamped_controls; }},
    {"active_set_changes", "", true, [](const Row& r) -> double { return r.active_set_changes; }},
    {"outer", "", true, [](const Row& r) -> double { return r.outer; }},
    {"newton", "", true, [](const Row& r) -> double { return r.newton; }},
    {"active_rows", "", true, [](const Row& r) -> double { return r.active_rows; }},
    {"constraint_knot", "", true, [](const Row& r) -> double { return r.constraint_knot; }},
    {"complementarity", "", false, [](const Row& r) { return r.complementarity; }},
    {"constraint_penalty", "", false, [](const Row& r) { return r.constraint_penalty; }},
    {"barrier", "", false, [](const Row& r) { return r.barrier; }},
    {"relaxation", "", false, [](const Row& r) { return r.relaxation; }},
    {"fallbacks", "", true, [](const Row& r) { return double(r.fallbacks); }},
    {"homotopy", "", false, [](const Row& r) { return r.homotopy; }},
    {"restoration", "", true, [](const Row& r) { return double(r.restoration); }},
    {"time", "s", false, [](const Row& r) { return r.time_s; }},
};

}  // namespace

std::span<const LogColumn> log_columns() { return kColumns; }

std::string log_key(const LogColumn& column) {
  std::string key(column.name);
  if (!column.unit.empty()) (key += '_') += column.unit;
  return key;
}

}  // namespace conddp
