#include "terminal/status_line.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "base/text/utf8.hpp"
#include "terminal/streams.hpp"
#include "terminal/terminal.hpp"

namespace conddp {
namespace {

constexpr std::chrono::milliseconds kPause(50);

/// The time, followed by as many of the comma-separated figures as fit.
std::string status_text(double elapsed_s, const std::string& figures, int width) {
  const std::string text = fmt::format("{:.1f} s{}", elapsed_s, figures);
  // A terminal may wrap after a full line.
  const std::size_t room = static_cast<std::size_t>(std::max(width - 1, 0));
  if (text.size() <= room) return text;
  const std::size_t comma = text.rfind(',', room);
  return comma == text.npos ? text.substr(0, room) : text.substr(0, comma);
}

}  // namespace

void StatusLine::show(const IterationRecord& row) {
  if (!active_) return;
  figures_ = fmt::format(", iteration {}, cost {:.6g}, stationarity {:.1e}, gap {:.1e}",
                         row.iteration, row.cost, row.stationarity, row.gap);
  refresh();
}

void StatusLine::show(const std::string& figures) {
  if (!active_) return;
  figures_ = ", " + printable(figures);
  refresh();
}

void StatusLine::refresh() {
  if (!active_) return;
  const Clock::time_point now = Clock::now();
  if (shown_ > 0 && now - last_drawn_ < kPause) return;
  last_drawn_ = now;
  const double elapsed = std::chrono::duration<double>(now - start_).count();
  const int width = terminal_of(2).width;
  std::string text = status_text(elapsed, figures_, width);
  const int length = static_cast<int>(text.size());
  // Spaces overwrite the rest of a longer line.
  text.append(std::clamp(shown_ - length, 0, std::max(width - 1 - length, 0)), ' ');
  print_message("\r" + text);
  shown_ = std::max(length, 1);
}

void StatusLine::erase() {
  if (shown_ == 0) return;
  const int room = std::min(shown_, std::max(terminal_of(2).width - 1, 0));
  print_message("\r" + std::string(room, ' ') + "\r");
  shown_ = 0;
}

}  // namespace conddp
