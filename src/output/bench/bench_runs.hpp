#pragma once

#include <set>
#include <string>

#include "base/json/ordered_json.hpp"

namespace conddp {

/// The entries of a bench.json that a report needs.
inline constexpr std::string_view kBenchKeys[] = {"machine", "request", "runs"};

/// Measurements of `bench` for the page of a report: the machine, the request, and `runs`,
/// restricted to problems with these names. Throws MalformedSolution.
OrderedJson bench_runs(const OrderedJson& bench, const std::set<std::string>& problems);

}  // namespace conddp
