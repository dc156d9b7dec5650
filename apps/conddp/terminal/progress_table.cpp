#include "terminal/progress_table.hpp"

#include <fmt/format.h>

#include "terminal/streams.hpp"

namespace conddp {

void ProgressTable::print(const IterationRecord& row) {
  constexpr int kRepeatHeading = 20;
  if (row.homotopy != share_) print_message(fmt::format("homotopy at s = {:.4g}\n", row.homotopy));
  share_ = row.homotopy;
  if (row.restoration > restoration_) print_message("restoration of feasibility\n");
  restoration_ = row.restoration;
  if (lines_++ % kRepeatHeading == 0)
    print_message(fmt::format("{:>5} {:>14} {:>12} {:>10} {:>10} {:>8} {:>6} {:>9} {:>8}\n", "iter",
                              "cost", "stationarity", "gap", "constraint", "step", "sweeps",
                              "regular.", "time [s]"));
  print_message(fmt::format(
      "{:>5} {:>14.7g} {:>12.3e} {:>10.2e} {:>10.2e} {:>8.3g} {:>6} {:>9.1e} {:>8.3f}\n",
      row.iteration, row.cost, row.stationarity, row.gap, row.constraint, row.step, row.sweeps,
      row.regularization, row.time_s));
}

}  // namespace conddp
