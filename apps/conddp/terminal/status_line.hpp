#pragma once

#include <chrono>
#include <string>

#include "solvers/common/iteration_record.hpp"

namespace conddp {

/// The state of a solve in the last line of a terminal, redrawn in place and erased at the end:
/// elapsed time, iteration, cost, stationarity, as far as they fit. The terminal only needs to
/// support the carriage return.
class StatusLine {
 public:
  /// An inactive status line never prints.
  explicit StatusLine(bool active) : active_(active) {}
  ~StatusLine() { erase(); }
  StatusLine(const StatusLine&) = delete;
  StatusLine& operator=(const StatusLine&) = delete;

  /// Stores the row and redraws if due.
  void show(const IterationRecord& row);
  /// Stores a text instead of a row's figures and redraws if due.
  void show(const std::string& figures);
  /// Redraws if due: the time advances during an iteration.
  void refresh();
  void erase();

 private:
  using Clock = std::chrono::steady_clock;
  const bool active_;
  const Clock::time_point start_ = Clock::now();
  Clock::time_point last_drawn_{};
  std::string figures_;
  int shown_ = 0;  ///< characters in the line
};

}  // namespace conddp
