#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace conddp {

/// The frame of an answer on a worker's pipe: a line with the sizes of the result and of the
/// solution in bytes, followed by both. A request is the item's line of the manifest.
struct AnswerFrame {
  std::size_t result = 0, solution = 0;
};

/// Write a frame's line, and parse one without its line end.
std::string frame_line(const AnswerFrame& frame);
AnswerFrame parse_frame(std::string_view line);

/// Exit status of a worker that has reported exhausted memory and accepts no further items.
inline constexpr int kMemoryUsedUp = 4;

/// The main loop of a worker process: reads items of a run from one descriptor, solves them in
/// sequence, and writes their results to the other. An item starts from the answer of its parent if
/// that was among the last kNeighbourBlock items. Limits the memory of the process according to the
/// manifest, and ends with the parent process. Returns the exit status: 0 when there are no more
/// items, 2 if the run cannot be read, or kMemoryUsedUp.
int serve_items(const std::filesystem::path& run, int requests, int answers);

}  // namespace conddp
