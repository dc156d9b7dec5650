#pragma once

namespace conddp {

/// Capabilities of an output stream.
struct Terminal {
  bool is_tty = false;
  bool redraws = false;  ///< supports redrawing a line; not TERM=dumb
  bool colour = false;   ///< same, unless NO_COLOR is set
  int width = 80;        ///< columns, 80 if unknown

  /// Width for line breaks in messages. Files and pipes get unbroken lines (0) for programs.
  int message_width() const { return is_tty ? width : 0; }
};

/// Capabilities of a file descriptor: 1 for stdout, 2 for stderr.
Terminal terminal_of(int descriptor);

}  // namespace conddp
