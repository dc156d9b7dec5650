#include "commands/parallel_tasks.hpp"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

namespace conddp {

void run_tasks(int count, int threads, const std::function<bool(int)>& task) {
  std::atomic<int> next = 0;
  std::mutex mutex;
  std::exception_ptr thrown;
  const auto work = [&] {
    try {
      for (int i; (i = next++) < count;)
        if (!task(i)) next = count;
    } catch (...) {
      next = count;
      const std::lock_guard lock(mutex);
      if (!thrown) thrown = std::current_exception();
    }
  };
  std::vector<std::jthread> others;
  try {
    for (int i = 1; i < std::min(threads, count); ++i) others.emplace_back(work);
  } catch (const std::system_error&) {
    // If no more threads can be created, the existing ones do the work.
  }
  work();
  others.clear();
  if (thrown) std::rethrow_exception(thrown);
}

}  // namespace conddp
