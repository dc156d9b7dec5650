#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace conddp {

/// The frame of an answer on the pipe of a worker: a line with the bytes of the result and of the
/// solution, then these. A request is the line of an item in the manifest.
struct AnswerFrame {
  std::size_t result = 0, solution = 0;
};

/// The line of a frame, and the frame of a line without its end.
std::string frame_line(const AnswerFrame& frame);
AnswerFrame parse_frame(std::string_view line);

/// Exit status of a worker that has recorded that memory is used up, and takes no further item.
inline constexpr int kMemoryUsedUp = 4;

/// What a worker process does: takes items of a run from one descriptor, solves them one after the
/// other and writes their results to the other one. An item starts from the answer of its parent if
/// that was among the last kNeighbourBlock items. Limits the memory of its process as the
/// manifest says, and ends with the process that started it. Returns the exit status of the
/// process: 0 when there are no more items, 2 where the run cannot be read, kMemoryUsedUp.
int serve_items(const std::filesystem::path& run, int requests, int answers);

}  // namespace conddp
