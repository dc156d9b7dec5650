#include "problem_file/memory_need.hpp"

#include <algorithm>
#include <limits>

#include <sys/resource.h>
#include <unistd.h>

#include <fmt/format.h>

namespace conddp {
namespace {

/// Bytes that a process can have at most.
double memory_there() {
  double bytes = std::numeric_limits<double>::infinity();
  const long pages = sysconf(_SC_PHYS_PAGES), page = sysconf(_SC_PAGESIZE);
  if (pages > 0 && page > 0) bytes = static_cast<double>(pages) * static_cast<double>(page);
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY)
    bytes = std::min(bytes, static_cast<double>(limit.rlim_cur));
  return bytes;
}

}  // namespace

double memory_need(double knots, int ndx, int nu, std::size_t costs) {
  const double z = ndx + nu;
  const double numbers = 3.5 * z * z + 60 * z + 100 + static_cast<double>(costs) * (ndx + 4);
  return knots * numbers * sizeof(double);
}

void check_memory(const ProblemSpec& spec, int ndx, int nu, Diagnostics& out) {
  double knots = 0;
  const PhaseSpec* longest = &spec.phases.front();
  for (const PhaseSpec& phase : spec.phases) {
    knots += phase.knots.value;
    if (phase.knots.value > longest->knots.value) longest = &phase;
  }
  const double need = memory_need(knots, ndx, nu, spec.costs.size());
  const double there = memory_there();
  if (need <= there) return;
  constexpr double kGiB = 1 << 30;
  out.error(longest->knots.place,
            fmt::format("{:.0f} knots with {} numbers in the state and {} controls need about "
                        "{:.3g} GiB of memory, and there are {:.3g}",
                        knots, ndx, nu, need / kGiB, there / kGiB),
            "take fewer knots");
}

}  // namespace conddp
