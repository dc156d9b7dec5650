#pragma once

#include <chrono>
#include <string>

#include "solvers/common/iteration_record.hpp"

namespace conddp {

/// The state of a solve in the last line of a terminal, redrawn in place and erased at the end:
/// elapsed time, iteration, cost, stationarity, as far as they fit. Needs nothing of the terminal
/// but that a carriage return leads back to the line's start.
class StatusLine {
 public:
  /// An inactive one never prints.
  explicit StatusLine(bool active) : active_(active) {}
  ~StatusLine() { erase(); }
  StatusLine(const StatusLine&) = delete;
  StatusLine& operator=(const StatusLine&) = delete;

  /// Remembers the row, and draws where that is due.
  void show(const IterationRecord& row);
  /// The same with other words instead of a row's figures.
  void show(const std::string& figures);
  /// Draws again where that is due: the time goes on while an iteration lasts.
  void refresh();
  void erase();

 private:
  using Clock = std::chrono::steady_clock;
  const bool active_;
  const Clock::time_point start_ = Clock::now();
  Clock::time_point last_drawn_{};
  std::string figures_;
  int shown_ = 0;  ///< characters that stand in the line
};

}  // namespace conddp
