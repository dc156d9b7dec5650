#pragma once

namespace conddp {

/// What an output stream can show.
struct Terminal {
  bool is_tty = false;
  bool colour = false;  ///< a terminal, not TERM=dumb, and NO_COLOR is not set
  int width = 80;       ///< columns
};

/// Of a file descriptor: 1 for stdout, 2 for stderr.
Terminal terminal_of(int descriptor);

}  // namespace conddp
