#pragma once

namespace conddp {

/// What an output stream can show.
struct Terminal {
  bool is_tty = false;
  bool redraws = false;  ///< a terminal that takes a line back; not TERM=dumb
  bool colour = false;   ///< the same where NO_COLOR is not set
  int width = 80;        ///< columns, 80 where it is unknown

  /// Where to break lines of messages: in a file or a pipe they are not broken (0), so that
  /// programs find them whole.
  int message_width() const { return is_tty ? width : 0; }
};

/// Of a file descriptor: 1 for stdout, 2 for stderr.
Terminal terminal_of(int descriptor);

}  // namespace conddp
